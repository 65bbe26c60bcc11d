"""What the vehicle does not say: what it is, and where it will be when a command acts.

vehicle_estimate         the estimate block: all of the following, carried from state to state
motor_estimate           the same of a vehicle that takes motor commands
motion_estimate          what both have in common: position, velocity and forces
rate_loop_model          how its rate loop and motors answer a command
rate_loop_identification the lag and gain of its rate loop; yaw_loop_identification: the lags in yaw
body_model               what stands between a motor command and what the vehicle does
angular_damping          how the air damps the turning of the body, found in flight
kalman, kalman_step      position, velocity, thrust scale, drag, disturbance, and how the reported ones wander
kalman_update            what a measurement teaches one axis of it
noise_levels, adaptation how noisy it is, and how that is found
estimator                what keeps the filter consistent: freezing, noise, resets
clamps                   the most that is believed of disturbance, thrust scale and drag
motor_lag                the lag of the motors, found by when thrust shows in the velocity
thrust_curve             what thrust is beyond proportion to its command, found by how the velocity follows its changes
scale_change             a thrust scale that changes all at once
restraint                whether something holds the vehicle
predictor                a state advanced by a short time, under the commands already sent
dead_time                from a state to the moment its command acts
translation              the translational acceleration
learned                  what one flight leaves for the next
"""
