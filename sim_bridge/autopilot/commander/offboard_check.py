"""Whether offboard setpoints stay away, or are back: PX4's offboardCheck and what its commander makes of it."""

from __future__ import annotations

import math

LOOK_PERIOD = 0.1
"""s between two looks: PX4's health checks run at 10 Hz."""
ACTED_AFTER = 0.02
"""s from such a look until the failsafe flies (seen in all: 0.02 to 0.17 s beyond COM_OF_LOSS_T, mostly before 0.1)."""
RETURN_NOTICED_AFTER = 0.07
"""s from the first new setpoint until offboard is resumed (seen: 0.02 to 0.13)."""


class OffboardCheck:
    """What is remembered between two looks."""

    def __init__(self) -> None:
        self._look = -1
        self._resumed_at: float | None = None

    def is_lost(self, t: float, setpoint_at: float, limit: float, *, was_lost: bool, is_flown: bool) -> bool:
        """offboard_control_signal_lost at ``t`` (s). ``setpoint_at``: s, the last setpoint, which may be ``limit`` s
        old. ``was_lost``: what the flag says so far; ``is_flown``: whether offboard is what flies."""
        if not is_flown:
            self._resumed_at = None
            return t - setpoint_at > limit
        if not was_lost:
            look = math.floor((t - ACTED_AFTER) / LOOK_PERIOD + 1e-6)
            is_new, self._look, self._resumed_at = look != self._look, look, None
            return is_new and look * LOOK_PERIOD - setpoint_at > limit
        if t - setpoint_at > limit:
            self._resumed_at = None
        elif self._resumed_at is None:
            self._resumed_at = t
        return self._resumed_at is None or t - self._resumed_at < RETURN_NOTICED_AFTER
