"""The answer before take-off: can this vehicle fly this mission, how fast at most, and where is it tight."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from companion.feasibility import geometry
from companion.feasibility.auto import flyable
from companion.feasibility.demand import Demand, compute_demand
from companion.feasibility.headroom import SPEED_MIN, TooSlowError
from companion.feasibility.limits import Limit, quantities, use_without_yaw, worst, worst_use
from companion.feasibility.stations import Stations, places, stations_along
from companion.frames import Vec3
from companion.mission import GlobalOrigin, Mission
from companion.profiles import AutoSpeed, ConstantSpeed
from companion.profiles.ends import flight_time, start_time
from companion.vehicle import Vehicle

Array = NDArray[np.float64]

REGULARITY_MIN = 0.01
"""below it the law is close to singular (engineering choice)."""
SCALE_MAX = 20.0
"""factor on the speed up to which the fastest one is looked for."""
NAMES = ("thrust_n", "tilt_deg", "motor", "body_rate_dps", "yaw_rate_dps", "path_radius_m", "regularity", "vdot_over_g")
"""The limits of the contract ``companion.check/1``."""
REPORTED_ONLY = frozenset({"vdot_over_g"})
"""Remark 4.3: sufficient, not necessary; it never decides."""

PREDICTED = frozenset({"thrust_n", "tilt_deg", "motor", "body_rate_dps", "yaw_rate_dps"})
CAPABILITY = PREDICTED | {"speed_mps", "yaw_acceleration_dps2"}
"""What more of a vehicle would mend; ground, fence, bends and jumps stay where they are."""
ACCURACY = 0.03
"""How far the flown extremes of thrust, tilt and motors may lie from the predicted ones (bench/agreement.py)."""


@dataclass(frozen=True)
class Report:
    """What ``check`` says."""

    mission: Mission  # as it would be flown, its speed known
    vehicle: Vehicle
    auto: bool  # whether its speed was left to the vehicle
    limits: tuple[Limit, ...]  # those of the contract, in its order
    others: tuple[Limit, ...]  # more of the same kind
    length: float  # m
    duration: float  # s once along the path, with the start and the stop where it is open
    speed_scale_max: float  # the largest factor on the whole speed that keeps every limit; 0 where none does
    at_most: Limit  # the limit that is met there
    max_vdot: float  # m/s^2, of Remark 4.3
    at: Stations  # the places that were looked at
    asked: Demand  # the demand there
    ground: float  # m, down in the vehicle's local frame

    @property
    def deciding(self) -> tuple[Limit, ...]:
        """Every limit that decides."""
        return tuple(limit for limit in (*self.limits, *self.others) if limit.name not in REPORTED_ONLY)

    @property
    def feasible(self) -> bool:
        """Whether every limit that decides is kept."""
        return all(limit.ok for limit in self.deciding)

    @property
    def may_be_flown(self) -> bool:
        """Whether no limit is broken by more than a flight may differ from its prediction, but for motors whose range
        would do were the heading let go: it gives way first, the path is kept. What there must be at least (height
        above ground, distance to a fence, room in a bend) is kept either way."""
        return all(limit.ok or (limit.name in PREDICTED and self._is_near(limit)) for limit in self.deciding)

    @property
    def only_capability_lacks(self) -> bool:
        """Whether what is broken is only what the vehicle is predicted to need: its own risk, where ground, a fence, a
        bend or a jump of the path are not."""
        return all(limit.ok or limit.name in CAPABILITY for limit in self.deciding)

    @property
    def heading_gives_way(self) -> bool:
        """Whether motors have to let the heading go somewhere for the path's sake."""
        return any(limit.name == "motor" and limit.used > 1.0 + ACCURACY for limit in self.limits) and (
            use_without_yaw(self.asked, self.vehicle) <= 1.0 + ACCURACY
        )

    def _is_near(self, limit: Limit) -> bool:
        return limit.used <= 1.0 + ACCURACY or (limit.name == "motor" and self.heading_gives_way)

    @property
    def tightest(self) -> Limit:
        """The limit of which most is used."""
        return max(self.deciding, key=lambda limit: limit.used)

    @property
    def proposition_4_2(self) -> bool:
        """Whether Proposition 4.2's condition holds as Remark 4.3 evaluates it: max |V'| < g along the path."""
        return self.max_vdot < self.vehicle.gravity


def check(mission: Mission, vehicle: Vehicle, ground: float | None = None, wind_n: Vec3 = (0.0, 0.0, 0.0)) -> Report:
    """The report for a mission, its speed found first where it is ``auto``: a second's work at most for usual paths.

    ``ground``: m, down in the local frame; None: ``ground_under`` the mission. ``wind_n``: m/s, the steady velocity
    of the air; a speed that is ``auto`` is found in still air, as before a flight. CompanionError, ValueError,
    ArithmeticError: the path, its speed or its yaw is not defined somewhere.
    """
    auto = isinstance(mission.speed, AutoSpeed)
    try:
        flown = flyable(mission, vehicle)
    except TooSlowError:  # the limits broken at a crawl say why
        flown = replace(mission, speed=ConstantSpeed(mission.direction * SPEED_MIN))
    ground = ground_under(mission) if ground is None else ground
    at = replace(stations_along(flown, places(flown)), wind_n=wind_n)
    asked = compute_demand(at, vehicle)
    speed_free = (
        geometry.radius(at),
        geometry.clearance(at, ground),
        *geometry.fence_limits(at, flown.fence_n),
        *geometry.jumps(flown, at),
    )
    found = [*_of_speed(at, asked, vehicle), _vdot(at, asked, vehicle), *speed_free]
    limits = tuple(next(limit for limit in found if limit.name == name) for name in NAMES)
    scale, at_most = speed_scale_max(at, vehicle)
    broken = [limit for limit in speed_free if not limit.ok]
    return Report(
        mission=flown,
        vehicle=vehicle,
        auto=auto,
        limits=limits,
        others=tuple(limit for limit in found if limit.name not in NAMES),
        length=flown.table.length,
        duration=_duration(flown, at, vehicle),
        speed_scale_max=0.0 if broken else scale,
        at_most=max(broken, key=lambda limit: limit.used) if broken else at_most,
        max_vdot=float(np.max(asked.acceleration)),
        at=at,
        asked=asked,
        ground=ground,
    )


def _duration(mission: Mission, at: Stations, vehicle: Vehicle) -> float:
    """s, once along the path: at speed where it goes round, from rest to rest where it is open."""
    speed = np.abs(at.alpha[0])
    if mission.closed:
        slowness = 1.0 / speed
        return float(np.sum(0.5 * (slowness[1:] + slowness[:-1]) * np.diff(at.s)))
    start = 0.0 if vehicle.limits is None else start_time(float(speed.max()))
    if mission.direction > 0.0:
        return flight_time(at.s, speed, start)
    return flight_time(mission.table.length - at.s[::-1], speed[::-1], start)


def ground_under(mission: Mission) -> float:
    """m, down in the local frame: home where it is known, else the height that the mission's heights count from."""
    origin, home = mission.origin, mission.home
    above = 0.0
    if isinstance(origin, GlobalOrigin):
        known = None if home is None else home.altitude
        above = origin.altitude if origin.above_home else 0.0 if known is None else origin.altitude - known
    return mission.placement.origin_n[2] + above


def speed_scale_max(at: Stations, vehicle: Vehicle) -> tuple[float, Limit]:
    """The largest factor on the whole speed profile up to which every limit is kept, at most ``SCALE_MAX``; and the
    limit that is met there."""

    def kept(scale: float) -> bool:
        asked = compute_demand(at, vehicle, scale)
        return worst_use(asked, vehicle) <= 1.0 and _regularity(at, asked, vehicle).ok

    low, high = 0.0, SCALE_MAX
    for scale in np.geomspace(0.02, SCALE_MAX, 25):
        if not kept(float(scale)):
            high = float(scale)
            break
        low = float(scale)
    for _ in range(18 if low < SCALE_MAX else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if kept(middle) else (low, middle)
    return low, max(_of_speed(at, compute_demand(at, vehicle, low), vehicle), key=lambda limit: limit.used)


def _of_speed(at: Stations, asked: Demand, vehicle: Vehicle) -> list[Limit]:
    """The limits that depend on the speed."""
    return [*worst(quantities(asked, vehicle), at.s), _regularity(at, asked, vehicle)]


def _regularity(at: Stations, asked: Demand, vehicle: Vehicle) -> Limit:
    """How far from a singularity of Lemma 4.1: the sine between the gradients, the cosine of the tilt, the thrust over
    the weight, whichever is least; 0 is singular."""
    least = np.minimum(at.sine, np.minimum(np.cos(asked.tilt), asked.thrust / vehicle.weight))
    least = np.where(np.isfinite(least), least, 0.0)
    i = int(np.argmin(least))
    value = float(least[i])
    used = REGULARITY_MIN / max(value, 1e-9)
    return Limit("regularity", value, REGULARITY_MIN, float(at.s[i]), value >= REGULARITY_MIN, used)


def _vdot(at: Stations, asked: Demand, vehicle: Vehicle) -> Limit:
    i = int(np.argmax(asked.acceleration))
    value = float(asked.acceleration[i]) / vehicle.gravity
    return Limit("vdot_over_g", value, 1.0, float(at.s[i]), value < 1.0, value)
