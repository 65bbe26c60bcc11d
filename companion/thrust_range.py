"""The dynamic extension (Eq. 4): the thrust zeta as a state of the controller, integrated within bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from companion.vehicle import Vehicle

ZETA_MIN = 0.25
"""Share of the weight, the least zeta: the attitude is not determined at zero. Engineering choice."""
ZETA_MAX = 1.9
"""Share of the weight, the largest zeta. Engineering choice: a tilt of 58 degrees in level flight."""
THRUST_USED_MAX = 0.95
"""Share of the largest thrust, the largest zeta. Engineering choice: 5 % are left for turning."""
ZETA_DOT_MAX = 3.0
"""Number of weights a second, the fastest change of zeta. Engineering choice: no motor follows more."""


class Bound(Enum):
    """What held zeta. ``SLEW``: zeta_dot, and zeta itself is where the motors can make it; ``LEVEL``: zeta."""

    NONE = "none"
    SLEW = "slew"
    LEVEL = "level"


@dataclass(frozen=True, slots=True)
class ThrustRange:
    """Where zeta (N) may be and how fast it may change (N/s).

    On a bound zeta_dot is zero, so that nothing winds up behind it.
    """

    low: float
    high: float
    rate: float

    def twice_integrated(
        self, zeta: float, zeta_dot: float, zeta_ddot: float, dt: float, high: float = math.inf
    ) -> tuple[float, float, Bound]:
        """(zeta, zeta_dot) ``dt`` later, and the bound that was met. ``high``: N, a bound lower than the range's."""
        wanted = zeta_dot + zeta_ddot * dt
        limited = max(-self.rate, min(self.rate, wanted))
        later = zeta + 0.5 * (zeta_dot + limited) * dt
        high = min(self.high, high)
        if not self.low <= later <= high:
            return max(self.low, min(high, later)), 0.0, Bound.LEVEL
        return later, limited, Bound.NONE if limited == wanted else Bound.SLEW

    def integrated(self, zeta: float, zeta_dot: float, dt: float, high: float) -> tuple[float, float, Bound]:
        """(zeta ``dt`` later, its slope), and the bound that was met. ``high``: N, a bound lower than the range's."""
        slope = max(-self.rate, min(self.rate, zeta_dot))
        later = zeta + slope * dt
        if not self.low <= later <= high:
            return max(self.low, min(high, later)), 0.0, Bound.LEVEL
        return later, slope, Bound.NONE if slope == zeta_dot else Bound.SLEW


UNBOUNDED = ThrustRange(-float("inf"), float("inf"), float("inf"))
"""N and N/s, of a vehicle without limits. The paper's own."""


def thrust_range_of(vehicle: Vehicle) -> ThrustRange:
    """The range for ``vehicle``."""
    if vehicle.limits is None:
        return UNBOUNDED
    high = min(ZETA_MAX * vehicle.weight, THRUST_USED_MAX * vehicle.thrust_max)
    return ThrustRange(ZETA_MIN * vehicle.weight, high, ZETA_DOT_MAX * vehicle.weight)
