"""What is left of a vehicle's limits at a speed, for many places and speeds at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.feasibility.demand import compute_demand
from companion.feasibility.limits import quantities
from companion.feasibility.stations import Stations
from companion.profiles import AutoSpeed
from companion.vehicle import CompanionError, Vehicle

Array = NDArray[np.float64]

ACCELERATION = 2.5
"""m/s^2 along the path, either way."""
SPEED_MAX = 30.0
"""m/s, for a vehicle that states no limit."""
END_SPEED = 1.0
"""m/s at the ends of an open path: start and end are phases of the flight, and it is not to be long in them."""
SPEED_MIN = 0.1
"""m/s; slower than this is not flown (engineering choice)."""
BISECTIONS = 16
"""halvings in search of the steady speed: of 30 m/s, below 1 mm/s is left."""


class TooSlowError(CompanionError):
    """No speed is slow enough for the vehicle; says where."""


@dataclass(frozen=True)
class Headroom:
    """The limits of ``vehicle`` along one path, as ``auto`` is told to keep them. ``ends``: m, where an open path
    begins and ends; None where it goes round."""

    vehicle: Vehicle
    auto: AutoSpeed
    ends: tuple[float, float] | None

    def used(self, at: Stations, alpha: Array) -> Array:
        """For every limit (rows) and place the share of what may be used; 1 is the most. ``alpha``: the speed (always
        positive here) and its three derivatives over arc length."""
        asked = compute_demand(at.with_speed(alpha * self.auto.direction), self.vehicle)
        rows = []
        for q in quantities(asked, self.vehicle):
            for side in (q.high, q.low):
                if math.isfinite(side):
                    rows.append((q.values - q.rest) / (side - q.rest) / self.auto.margin)
        rows.append(asked.along / (ACCELERATION * self.auto.margin))
        rows.append(-rows[-1])
        rows.append(asked.speed / self.cap(at.s))
        result: Array = np.where(np.isfinite(rows), rows, 1e3)
        return result

    def cap(self, s: Array) -> Array:
        """m/s, the speed never passed at arc length ``s``, whatever the vehicle could do."""
        cap: Array = np.full(len(s), min(self.auto.speed_max or SPEED_MAX, SPEED_MAX))
        if self.ends is not None:
            left = np.minimum(s - self.ends[0], self.ends[1] - s)
            cap = np.minimum(cap, np.sqrt(END_SPEED**2 + 2.0 * ACCELERATION * self.auto.margin * np.maximum(left, 0.0)))
        if not self.auto.caps:
            return cap
        begins, speeds = (np.array(column) for column in zip(*self.auto.caps, strict=True))
        legs = np.clip(np.searchsorted(begins, s, side="right") - 1, 0, len(speeds) - 1)
        lowest: Array = np.minimum(cap, speeds[legs])
        return lowest

    def steady(self, at: Stations) -> Array:
        """m/s, the speed that the bends alone allow, held back where the acceleration along the path must be kept:
        forward for what comes after a bend, backward for what comes before one."""
        flat = np.zeros_like(at.s)
        low, high = np.full_like(at.s, 1e-3), self.cap(at.s)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            kept = self.used(at, np.stack([middle, flat, flat, flat])).max(axis=0) <= 1.0
            low, high = np.where(kept, middle, low), np.where(kept, high, middle)
        squared = low**2
        rise = (2.0 * ACCELERATION * self.auto.margin * np.diff(at.s)).tolist()
        closed = self.ends is None
        forward = _limit_acceleration(squared.tolist(), rise, closed)
        both = _limit_acceleration(forward[::-1], rise[::-1], closed)[::-1]
        result: Array = np.sqrt(np.array(both))
        return result


def _limit_acceleration(squared: list[float], rise: list[float], closed: bool) -> list[float]:
    """Squares of speeds that rise no faster than ``rise`` from one to the next."""
    held = list(squared)
    for _ in range(2 if closed else 1):
        if closed:
            held[0] = min(held[0], held[-1])
        for i, most in enumerate(rise, 1):
            held[i] = min(held[i], held[i - 1] + most)
    return held
