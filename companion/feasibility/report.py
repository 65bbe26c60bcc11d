"""The answer before take-off: can this vehicle fly this mission, how fast at most, and where is it tight."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.feasibility.demand import Demand, demand
from companion.feasibility.fastest import flyable
from companion.feasibility.limits import Quantity, quantities, worst_use
from companion.feasibility.stations import Stations, places, stations
from companion.mission import Mission
from companion.vehicle import Vehicle

Array = NDArray[np.float64]

RADIUS_MIN = 0.3
"""m; nearer to the path than its radius of curvature the closest point is one, and a vehicle is never nearer than this
to its path for sure."""
REGULARITY_MIN = 0.01
CLEARANCE_MIN = 0.3
"""m above what the mission counts from."""
JUMPS = {"speed_jump_mps": 0.1, "yaw_jump_deg": 1.0}
"""How badly a speed or a heading may meet itself where a path closes."""
SCALE_MAX = 20.0
NAMES = ("thrust_n", "tilt_deg", "motor", "body_rate_dps", "yaw_rate_dps", "path_radius_m", "regularity", "vdot_over_g")
"""The limits of the contract ``companion.check/1``."""
REPORTED_ONLY = frozenset({"vdot_over_g"})
"""Remark 4.3: sufficient, not necessary; it never decides."""


@dataclass(frozen=True, slots=True)
class Limit:
    """One limit: the ``worst`` value along the path, at arc length ``at_s``, against ``limit`` (None: there is none).
    ``used``: the share of it that is used, 1 at the limit. ``part``: which motor or axis."""

    name: str
    worst: float
    limit: float | None
    at_s: float
    ok: bool
    used: float
    part: str = ""


@dataclass(frozen=True)
class Report:
    """What ``check`` says. ``mission``: as it would be flown, its speed known. ``limits``: those of the contract, in
    its order; ``others``: more of the same kind. ``speed_scale_max``: the largest factor on the whole speed that keeps
    every limit. ``max_vdot``: m/s^2, of Remark 4.3. ``asked``, ``at``: the demand and the places it was looked at."""

    mission: Mission
    vehicle: Vehicle
    limits: tuple[Limit, ...]
    others: tuple[Limit, ...]
    length: float
    duration: float
    speed_scale_max: float
    max_vdot: float
    at: Stations
    asked: Demand

    @property
    def feasible(self) -> bool:
        """Whether every limit that decides is kept."""
        return all(limit.ok for limit in (*self.limits, *self.others) if limit.name not in REPORTED_ONLY)

    @property
    def tightest(self) -> Limit:
        """The limit of which most is used."""
        deciding = (limit for limit in (*self.limits, *self.others) if limit.name not in REPORTED_ONLY)
        return max(deciding, key=lambda limit: limit.used)


def check(mission: Mission, vehicle: Vehicle) -> Report:
    """The report for a mission, its speed found first where it is ``auto``. CompanionError: it cannot be looked at."""
    mission = flyable(mission, vehicle)
    at = stations(mission, places(mission))
    asked = demand(at, vehicle)
    found = _by_name(quantities(asked, vehicle), at.s)
    found += [_radius(at), _regularity(at, asked, vehicle), _vdot(at, asked, vehicle)]
    others = [limit for limit in found if limit.name not in NAMES]
    others += [_clearance(mission, at), *_jumps(mission, at)]
    limits = tuple(next(limit for limit in found if limit.name == name) for name in NAMES)
    slowness = 1.0 / np.abs(at.alpha[0])
    return Report(
        mission=mission,
        vehicle=vehicle,
        limits=limits,
        others=tuple(others),
        length=mission.table.length,
        duration=float(np.sum(0.5 * (slowness[1:] + slowness[:-1]) * np.diff(at.s))),
        speed_scale_max=speed_scale_max(at, vehicle),
        max_vdot=float(np.max(asked.acceleration)),
        at=at,
        asked=asked,
    )


def speed_scale_max(at: Stations, vehicle: Vehicle) -> float:
    """The largest factor on the whole speed profile up to which every limit is kept; at most ``SCALE_MAX``."""

    def kept(scale: float) -> bool:
        return worst_use(demand(at, vehicle, scale), vehicle) <= 1.0

    low, high = 0.0, SCALE_MAX
    for scale in np.geomspace(0.02, SCALE_MAX, 25):
        if not kept(float(scale)):
            high = float(scale)
            break
        low = float(scale)
    else:
        return SCALE_MAX
    for _ in range(18):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if kept(middle) else (low, middle)
    return low


def _by_name(found: list[Quantity], s: Array) -> list[Limit]:
    """The part of each quantity that uses most."""
    result: dict[str, Limit] = {}
    for q in found:
        used = q.used
        i = int(np.argmax(used))
        if q.name in result and used[i] <= result[q.name].used:
            continue
        side = q.high if q.values[i] >= q.rest else q.low
        limit = side if math.isfinite(side) else None
        result[q.name] = Limit(
            q.name, float(q.values[i]), limit, float(s[i]), bool(used[i] <= 1.0), float(used[i]), q.part
        )
    return list(result.values())


def _radius(at: Stations) -> Limit:
    """The radius of the tube in which the closest point is one: the distance to the evolute."""
    bend = np.linalg.norm(at.path[2], axis=0)
    i = int(np.argmax(bend))
    radius = 1.0 / float(bend[i]) if bend[i] > 1e-6 else 1e6
    return Limit("path_radius_m", radius, RADIUS_MIN, float(at.s[i]), radius >= RADIUS_MIN, RADIUS_MIN / radius)


def _regularity(at: Stations, asked: Demand, vehicle: Vehicle) -> Limit:
    """How far from a singularity of Lemma 4.1: the sine between the gradients, the cosine of the tilt, the thrust over
    the weight, whichever is least; 0 is singular."""
    least = np.minimum(at.sine, np.minimum(np.cos(asked.tilt), asked.thrust / vehicle.weight))
    least = np.where(np.isfinite(least), least, 0.0)
    i = int(np.argmin(least))
    worst = float(least[i])
    return Limit(
        "regularity", worst, REGULARITY_MIN, float(at.s[i]), worst >= REGULARITY_MIN, REGULARITY_MIN / max(worst, 1e-9)
    )


def _vdot(at: Stations, asked: Demand, vehicle: Vehicle) -> Limit:
    i = int(np.argmax(asked.acceleration))
    worst = float(asked.acceleration[i]) / vehicle.gravity
    return Limit("vdot_over_g", worst, 1.0, float(at.s[i]), worst < 1.0, worst)


def _clearance(mission: Mission, at: Stations) -> Limit:
    height = mission.placement.origin_n[2] - at.path[0, 2]
    i = int(np.argmin(height))
    worst = float(height[i])
    used = CLEARANCE_MIN / worst if worst > 0.0 else math.inf
    return Limit("ground_clearance_m", worst, CLEARANCE_MIN, float(at.s[i]), worst >= CLEARANCE_MIN, used)


def _jumps(mission: Mission, at: Stations) -> list[Limit]:
    """How speed and heading meet themselves where the path closes."""
    if not mission.closed:
        return []
    speed = abs(float(at.alpha[0, -1] - at.alpha[0, 0]))
    turned = math.remainder(float(at.beta[0, -1] - at.beta[0, 0]), math.tau)
    found = {"speed_jump_mps": speed, "yaw_jump_deg": abs(math.degrees(turned))}
    return [
        Limit(name, worst, JUMPS[name], float(at.s[-1]), worst <= JUMPS[name], worst / JUMPS[name])
        for name, worst in found.items()
    ]
