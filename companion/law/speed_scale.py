"""A factor on the mission's speed as a function of time, with two derivatives; factors multiply."""

from __future__ import annotations

from typing import NamedTuple


class SpeedScale(NamedTuple):
    """``value``: of the mission's speed that is asked for, 1 in steady flight; may exceed 1, and a negative one flies
    the other way. ``rate``: 1/s. ``acceleration``: 1/s^2.

    The ground station's factor, the start, the sign of the leg and the speed governor are one each; what the law is
    given is their product. The braking before an open end is a function of displacement: see ``profiles.ends``.
    """

    value: float = 1.0
    rate: float = 0.0
    acceleration: float = 0.0

    def __mul__(self, other: SpeedScale) -> SpeedScale:  # type: ignore[override]
        """The product as a function of time (Leibniz)."""
        if other is UNITY:
            return self
        if self is UNITY:
            return other
        return SpeedScale(
            self.value * other.value,
            self.rate * other.value + self.value * other.rate,
            self.acceleration * other.value + 2.0 * self.rate * other.rate + self.value * other.acceleration,
        )


UNITY = SpeedScale()
"""The mission's own speed."""
STANDSTILL = SpeedScale(0.0)
"""Factor 0: no speed. By definition."""
BACKWARDS = SpeedScale(-1.0)
"""Factor -1: the path flown against its direction. By definition."""
