"""From a state to a setpoint: the law at one output level, with the thrust it integrates and the limits it keeps.

    motors     the paper's chain: snap -> torques -> motor commands
    rates      one order earlier: jerk -> body rates and thrust, predicted to where they act, the vehicle observed
    encoding   those rates as they are, or as the attitude PX4 turns back into them
    thrust     the bounds of the thrust the law integrates
    pace       the path comes first: the speed gives way where the vehicle could not fly it

Every level answers the same three questions: where to begin (``begin``), what to send now (``steer``, towards an aim:
``Along`` the path or ``At`` a point), and what to send when the law has no say (``level``).
"""
