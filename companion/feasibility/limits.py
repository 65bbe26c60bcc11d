"""The limits of a vehicle, and how much of each a demand uses: 0 in a hover, 1 at the limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.allocation import Allocation
from companion.feasibility.demand import Demand, without_yaw
from companion.law.feedback import Bounds
from companion.thrust_range import THRUST_USED_MAX, ZETA_MAX, ZETA_MIN
from companion.vehicle import MotorInterface, Vehicle

Array = NDArray[np.float64]

PLANNED_UNDER_DETECTOR = math.radians(10.0)
"""rad that a path is planned to stay under the autopilot's failure detector, which ends a flight. In flight wind may
take 2 of it (steering.tilt_barrier.STEADY_UNDER_DETECTOR). Engineering choice."""


@dataclass(frozen=True, slots=True)
class Limit:
    """One limit: the ``worst`` value along the path, at arc length ``at_s`` (m), against ``limit`` (None: no limit), in
    the unit that the ``name`` ends with. ``used``: the share of it that is used, 1 at the limit. ``part``: which motor
    or axis."""

    name: str
    worst: float
    limit: float | None
    at_s: float
    ok: bool
    used: float
    part: str = ""


class Quantity(NamedTuple):
    """One thing asked of a vehicle along a path, and how much of it there is.

    ``values``: at n places, in the unit that the ``name`` ends with. ``rest``: in a hover. ``low``, ``high``: its
    limits, infinite where it has none. ``part``: which motor or axis.
    """

    name: str
    values: Array
    rest: float
    low: float
    high: float
    part: str = ""

    @property
    def used(self) -> Array:
        """The share of the way from rest to the limit that is gone; inf where the value is not finite."""
        with np.errstate(invalid="ignore"):
            up = (self.values - self.rest) / (self.high - self.rest)
            down = (self.values - self.rest) / (self.low - self.rest)
            used = np.maximum(up, down)
        return np.where(np.isfinite(self.values), np.abs(used), np.inf)


def tilt_limit(vehicle: Vehicle) -> float:
    """rad, infinite where there is none. An autopilot that watches the tilt leaves less."""
    if vehicle.limits is None:
        return math.inf
    if vehicle.motors is MotorInterface.DIRECT:
        return vehicle.limits.tilt
    return min(vehicle.limits.tilt, vehicle.limits.failure_detector - PLANNED_UNDER_DETECTOR)


def quantities(asked: Demand, vehicle: Vehicle) -> list[Quantity]:
    """Everything that is limited, those of ``check`` first and in their order."""
    limits, bounds = vehicle.limits, Bounds()
    none = math.inf
    weight = vehicle.weight
    rates = (none, none, none) if limits is None else limits.body_rates
    result = [
        Quantity(
            "thrust_n",
            asked.thrust,
            weight,
            -none if limits is None else ZETA_MIN * weight,
            none if limits is None else min(ZETA_MAX * weight, THRUST_USED_MAX * vehicle.thrust_max),
        ),
        Quantity("tilt_deg", np.degrees(asked.tilt), 0.0, -none, math.degrees(tilt_limit(vehicle))),
    ]
    result += _motors(asked.motors, vehicle)
    for axis, limit, values in zip(("roll", "pitch", "yaw"), rates, asked.rates, strict=True):
        high = math.degrees(limit)
        result.append(Quantity("body_rate_dps", np.degrees(values), 0.0, -high, high, axis))
    high = math.degrees(rates[2])
    result.append(Quantity("yaw_rate_dps", np.degrees(asked.yaw_rate), 0.0, -high, high))
    high = none if limits is None else math.degrees(bounds.yaw_acceleration)
    result.append(Quantity("yaw_acceleration_dps2", np.degrees(asked.yaw_acceleration), 0.0, -high, high))
    result.append(Quantity("speed_mps", asked.speed, 0.0, -none, none if limits is None else limits.speed))
    return result


def _motors(asked: Array, vehicle: Vehicle) -> list[Quantity]:
    hover = Allocation(vehicle).commands((vehicle.weight, 0.0, 0.0, 0.0))
    result = []
    for i, (rotor, command, values) in enumerate(zip(vehicle.rotors, hover, asked, strict=True), 1):
        low, high = rotor.command
        result.append(Quantity("motor", values, (command - low) / (high - low), 0.0, 1.0, f"motor {i}"))
    return result


def use_without_yaw(asked: Demand, vehicle: Vehicle) -> float:
    """The largest share of any motor's range used anywhere, were the heading let go."""
    return max(float(np.max(q.used)) for q in _motors(without_yaw(asked, vehicle), vehicle))


def worst_use(asked: Demand, vehicle: Vehicle) -> float:
    """The largest share of any limit used anywhere."""
    return max(float(np.max(q.used)) for q in quantities(asked, vehicle))


def worst(found: list[Quantity], s: Array) -> list[Limit]:
    """Where each quantity uses most, or lies farthest from rest where it has no limit: of its parts the worst one."""
    result: dict[str, tuple[float, Limit]] = {}
    for q in found:
        used = q.used
        away = np.where(np.isfinite(q.values), np.abs(q.values - q.rest), np.inf)
        limited = math.isfinite(q.low) or math.isfinite(q.high)
        size = used if limited else away
        i = int(np.argmax(size))
        if q.name in result and size[i] <= result[q.name][0]:
            continue
        value = float(q.values[i])
        side = q.high if value >= q.rest else q.low
        symmetric = q.low == -q.high  # a rate to the left is as good as one to the right
        result[q.name] = (
            float(size[i]),
            Limit(
                q.name,
                abs(value) if symmetric else value,
                abs(side) if math.isfinite(side) else None,
                float(s[i]),
                bool(used[i] <= 1.0),
                float(used[i]),
                q.part,
            ),
        )
    return [limit for _, limit in result.values()]
