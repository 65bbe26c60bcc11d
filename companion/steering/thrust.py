"""The dynamic extension (Eq. 4): the thrust zeta as a state of the controller, integrated within bounds."""

from __future__ import annotations

from dataclasses import dataclass

from companion.vehicle import Vehicle

ZETA_MIN, ZETA_MAX, THRUST_SHARE_MAX = 0.25, 1.9, 0.95
"""zeta stays between these shares of the weight, and below this share of the largest thrust."""
ZETA_DOT_MAX = 3.0
"""weights a second."""


@dataclass(frozen=True, slots=True)
class ThrustRange:
    """Where zeta (N) may be and how fast it may change (N/s).

    On a bound zeta_dot is zero, so that nothing winds up behind it.
    """

    low: float
    high: float
    rate: float

    def twice_integrated(self, zeta: float, zeta_dot: float, zeta_ddot: float, dt: float) -> tuple[float, float, bool]:
        """(zeta, zeta_dot) ``dt`` later, and whether a bound was met."""
        wanted = zeta_dot + zeta_ddot * dt
        limited = max(-self.rate, min(self.rate, wanted))
        later = zeta + 0.5 * (zeta_dot + limited) * dt
        if not self.low <= later <= self.high:
            return max(self.low, min(self.high, later)), 0.0, True
        return later, limited, limited != wanted

    def integrated(self, zeta: float, zeta_dot: float, dt: float, high: float) -> tuple[float, float, bool]:
        """(zeta ``dt`` later, its slope), and whether a bound was met. ``high``: N, a bound lower than the range's."""
        slope = max(-self.rate, min(self.rate, zeta_dot))
        later = zeta + slope * dt
        if not self.low <= later <= high:
            return max(self.low, min(high, later)), 0.0, True
        return later, slope, slope != zeta_dot


UNBOUNDED = ThrustRange(-float("inf"), float("inf"), float("inf"))
"""The paper's own: for a vehicle without limits."""


def thrust_range(vehicle: Vehicle) -> ThrustRange:
    """The range for ``vehicle``."""
    if vehicle.limits is None:
        return UNBOUNDED
    high = min(ZETA_MAX * vehicle.weight, THRUST_SHARE_MAX * vehicle.thrust_max)
    return ThrustRange(ZETA_MIN * vehicle.weight, high, ZETA_DOT_MAX * vehicle.weight)
