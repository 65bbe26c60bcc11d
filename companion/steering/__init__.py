"""From a state to a setpoint: the law at one output level, with the thrust it integrates and the limits it keeps.

    motors   the paper's chain: snap -> torques -> motor commands

Every level answers the same three questions: where to begin (``begin``), what to send now (``steer``, towards an aim:
``Along`` the path or ``At`` a point), and what to send when the law has no say (``level``).
"""
