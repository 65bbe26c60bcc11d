"""When a command acts: dead time, hold, rate loop."""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.link_delay import PX4_STEP


class Timing(NamedTuple):
    """When what acts, s after the state. ``delay``: the dead time; ``hold``: half the time a command is held until the
    next one; ``lag``: of the rate loop, with the ``smoothing`` of what is sent."""

    delay: float
    hold: float
    lag: float
    smoothing: float

    @property
    def horizon(self) -> float:
        """When the rates of this command will have been reached: where the law is evaluated."""
        return self.delay + self.hold + self.lag

    @property
    def attitude(self) -> float:
        """When an attitude setpoint is followed. What is smoothed is not held as well: PX4's model moves on when a new
        setpoint comes; its loop runs in steps."""
        return self.delay + max(self.hold, self.smoothing, 0.5 * PX4_STEP) - 0.5 * PX4_STEP
