"""What the vehicle does not say: what it is, and where it will be when a command acts.

response     how its rate loop and motors answer a command
prediction   a state advanced by a short time, under the commands already sent
kalman       position, velocity, thrust scale, drag, disturbance, the estimator's own bias
observer     what keeps the filter honest: freezing, bounds, noise, jumps
"""
