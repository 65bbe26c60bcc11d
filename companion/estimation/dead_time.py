"""The dead time between a state and the effect of the command that was computed from it."""

from __future__ import annotations

from companion.frames import clamped

PX4_STEP = 0.004
"""s: a setpoint acts at PX4's next step of its attitude control (250 Hz)."""
DELAY_MAX = 0.2
"""s, the longest delay that is believed. Engineering choice: no link that is slower is flown over."""
DELAY_SLEW = 0.05
"""s of change a second: commands on their way are ordered by the delay. Engineering choice."""


def update_dead_time(
    before: float | None, round_trip: float | None, stated: float, dt: float, step: float = PX4_STEP
) -> float:
    """s, ``dt`` s later: the link there and back as measured, and the ``step`` (s) at which a command acts; as
    ``stated`` in the vehicle file where nothing is measured. It follows at DELAY_SLEW at most."""
    now = stated if round_trip is None else round_trip + step
    now = clamped(now, 0.0, DELAY_MAX)
    if before is None or dt == 0.0:
        return now
    most = DELAY_SLEW * dt
    return before + clamped(now - before, -most, most)
