"""The autopilot's control loops, PX4's own structure and figures, from the inside out.

filters     the low-pass filters of the gyro path
mixing      torques and thrust to motor commands, for any placement of four rotors; what to give up first
rates       body rates -> torques
attitude    attitude -> body rates
position    position and velocity -> attitude and thrust
reference   the smooth motion the position loop follows in the automatic modes
cascade     which of these run for which kind of setpoint

Gains are PX4's defaults for the quadrotor of its own simulation. For any other vehicle they are scaled so that a unit
of error asks for the same angular acceleration, which makes every vehicle file fly alike.
"""
