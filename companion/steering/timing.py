"""When a command acts: dead time, hold, rate loop."""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.dead_time import PX4_STEP
from companion.estimation.rate_loop_model import thrust_transition


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

    def relaxation(self, gain: float) -> float:
        """How much of the step from the last command to the law's answer is taken. ``gain``: 1/s, the law's largest on
        what its command integrates to.

        The law is asked at a horizon at which this very command has already acted for a while; the predictor holds the
        last one instead. u = law(x(u)) is therefore solved by a step of relaxation from the last command: with the gain
        k, and b s of what a command integrates to until the horizon, x(u) - x(last) = b (u - last), and what is left of
        an error after a step is none in the directions of that gain. Without it the loop over the last command has the
        gain -k b: it swings at every step where states are few or the lag is long.
        """
        acting = self.hold + self.lag
        return 1.0 / (1.0 + gain * (acting - (thrust_transition(self.lag, acting)[1] * acting)))

    @property
    def attitude(self) -> float:
        """When an attitude setpoint is followed. What is smoothed is not held as well: PX4's model moves on when a new
        setpoint comes; its loop runs in steps."""
        return self.delay + max(self.hold, self.smoothing, 0.5 * PX4_STEP) - 0.5 * PX4_STEP
