"""From a state to a setpoint: the law at one output level, with the thrust it integrates and the limits it keeps.

Each is the same block diagram; ``assembly`` puts it together for a vehicle, ``shared`` has the blocks that are alike:

    estimate -> predict -> govern speed -> law -> limits -> encode

    steering        what they all are: Steering, Steered, and the aims Along and At
    rates           jerk -> body rates and thrust; rate_memory: what it remembers
    motors          the paper's chain: snap -> torques -> motor commands; motor_memory: what it remembers
    torques         those torques, told to PX4's allocator
    speed_governor  the speed gives way where the vehicle could not fly the path at the mission's
    yaw             the yaw loop compensated; yaw_forecast: the yaw rates to come; yaw_reference: those that are planned
    path_poles      poles of h1 and h2, by the noise found
    tilt_barrier    no rate that leans the vehicle into its failure detector
    limits          body rates, thrust, anti-windup, levelling
    encoding        those rates as they are, or as the attitude PX4 turns back into them
    timing          when what acts

Every level answers the same three questions: where to begin (``begin``), what to send now (``steer``, towards an aim:
``Along`` the path or ``At`` a point), and what to send when the law has no say (``level``).
"""
