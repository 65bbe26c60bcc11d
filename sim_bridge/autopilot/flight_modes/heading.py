"""The smooth turning of the nose in the automatic modes: PX4's rate and acceleration limits."""

from __future__ import annotations

import math

from sim_bridge.autopilot.parameters import Parameters


class HeadingSmoothing:
    """``heading`` (rad, clockwise from north) and its ``rate`` (rad/s)."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.heading = self.rate = 0.0

    def point(self, heading: float) -> None:
        """Begin at a heading."""
        self.heading, self.rate = heading, 0.0

    def turn(self, wanted: float, step: float) -> None:
        """One ``step`` (s) nearer to a heading."""
        left = math.remainder(wanted - self.heading, math.tau)
        fastest = math.radians(max(1.0, self._parameters["MPC_YAWRAUTO_MAX"]))
        harshest = math.radians(max(1.0, self._parameters["MPC_YAWRAUTO_ACC"]))
        rate = math.copysign(min(fastest, math.sqrt(2.0 * harshest * abs(left)), abs(left) / step), left)
        change = max(-harshest * step, min(harshest * step, rate - self.rate))
        slows = abs(self.rate + change) < abs(self.rate)
        self.rate = rate if slows else self.rate + change
        self.heading = math.remainder(self.heading + self.rate * step, math.tau)
