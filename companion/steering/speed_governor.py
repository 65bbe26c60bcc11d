"""The speed governor: where the vehicle cannot fly the path at the mission's speed, the speed gives way and comes back.

What the path asks for at a speed v is a specific force F = k v^2 + c v T - d - g e3 (k its curvature, T its tangent;
drag c and disturbance d as they are estimated now). Ahead of every place where |F| would be more than the vehicle has,
or tilted further than it may, the speed is brought down in time. A short peak may ask for all the thrust there is, what
is sustained only for less: the rest is for turning and for errors. What is flown then is slower than the mission wants;
the mission's speed is what the flight is measured against all the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from companion.frames import Vec3, clamped
from companion.law.speed_scale import UNITY, SpeedScale
from companion.paths.arc import ArcTable

SPACING = 0.4
"""m between the places looked at. Engineering choice: a tenth of a second at 4 m/s."""
PLANNED_BRAKING = 1.0
"""m/s^2 that is counted on to slow down in time. Engineering choice: two thirds of BRAKING_MAX."""
BRAKING_MAX = 1.5
"""m/s^2 at which the speed gives way at most. Engineering choice: 9 degrees of tilt."""
RECOVERY_MAX = 1.5
"""m/s^2 at which the speed comes back at most. As BRAKING_MAX."""
LOOK_AHEAD_MIN = 0.5
"""s of flight that are looked ahead even when standing still is near. Engineering choice."""
SMOOTHING_TIME = 0.15
"""s, time constant with which a change of the speed sets in. Engineering choice: no step in the acceleration."""
SPEED_SCALE_MIN = 0.25
"""Share of the mission's speed, at least. Engineering choice: a path that cannot be flown at all is flown slowly."""
SUSTAINED_THRUST_MAX = 0.96
"""Share of the largest thrust, for what is sustained. Engineering choice: 4 % are left for turning and errors."""
SUSTAINED_TIME = 0.5
"""s for which a thrust counts as sustained. Engineering choice: some ten motor lags."""
BISECTIONS = 8
"""Number of steps of the search for the fastest speed. Engineering choice: to 0.3 % of the mission's."""


class Capability(NamedTuple):
    """What the vehicle has at most, and the forces on it.

    ``specific_thrust``: m/s^2, largest thrust over mass. ``tan_tilt_max``: tangent of the steepest tilt. ``drag``: 1/s.
    ``disturbance_n``, ``gravity``: m/s^2.
    """

    specific_thrust: float
    tan_tilt_max: float
    drag: float
    disturbance_n: Vec3
    gravity: float


class Place(NamedTuple):
    """A place of the path.

    ``tangent``: unit. ``curvature``: 1/m. ``speed``: m/s, the mission's, without a sign. ``sustained_ratio``: the share
    of its curvature that the path has in the mean of SUSTAINED_TIME around it; 1 where it has as much or more.
    ``heading``: rad, asked for.
    """

    tangent: Vec3
    curvature: Vec3
    speed: float
    sustained_ratio: float = 1.0
    heading: float = 0.0


@dataclass(frozen=True)
class Course:
    """A path by places ``spacing`` m apart from its beginning. ``direction``: +1 along it, -1 against."""

    places: tuple[Place, ...]
    spacing: float
    closed: bool
    direction: float

    @cached_property
    def hardest(self) -> tuple[float, float]:
        """m/s^2 across the path at the mission's speed where that is most, and the mission's fastest speed (m/s)."""
        across = max(math.hypot(*place.curvature) * place.speed * place.speed for place in self.places)
        return across, max(place.speed for place in self.places)

    def is_easy(self, scale: float, capability: Capability) -> bool:
        """Whether nothing on the whole course can be too much, by a bound that is quickly computed."""
        across, fastest = self.hardest
        f = abs(scale)
        push = across * f * f + capability.drag * fastest * f + math.hypot(*capability.disturbance_n)
        upright = capability.gravity - push
        return (
            upright > 0.0
            and push <= capability.tan_tilt_max * upright
            and capability.gravity + push <= SUSTAINED_THRUST_MAX * capability.specific_thrust
        )

    def allowed_speed(self, s: float, scale: float, capability: Capability) -> float:
        """The largest speed (m/s) at arc length ``s`` from which every place ahead can still be met slowly enough, when
        ``scale`` times the mission's speed is wanted; infinite if nothing is in the way."""
        count = len(self.places)
        step = self.direction if scale >= 0.0 else -self.direction
        first = s / self.spacing
        begin = math.floor(first) if step > 0.0 else math.ceil(first)
        wanted = abs(scale)
        most = math.inf
        travelled, k = 0.0, begin
        here = self.places[self.index(begin)]
        now = here.speed * wanted
        reach = now * (LOOK_AHEAD_MIN + 0.5 * now / PLANNED_BRAKING) + self.spacing
        while travelled <= reach:
            index = k % count if self.closed else k
            if not 0 <= index < count:
                break
            place = self.places[index]
            speed = place.speed * wanted
            if not _is_feasible(place, speed, step, capability):
                slow = _fastest(place, speed, step, capability)
                before = max(0.0, travelled - self.spacing)
                most = min(most, math.sqrt(slow * slow + 2.0 * PLANNED_BRAKING * before))
            k += 1 if step > 0.0 else -1
            travelled += self.spacing
        return most

    @cached_property
    def rows(self) -> tuple[tuple[float, ...], ...]:
        """The places as numbers: tangent, curvature, speed, heading."""
        return tuple((*each.tangent, *each.curvature, each.speed, each.heading) for each in self.places)

    def between(self, s: float) -> tuple[int, int, float]:
        """The places before and after arc length ``s`` (m), and how far from the one to the other it lies."""
        u = s / self.spacing
        i = math.floor(u)
        if 0 <= i < len(self.places) - 1:
            return i, i + 1, u - i
        return self.index(i), self.index(i + 1), u - i

    def index(self, k: int) -> int:
        """Of the ``k``-th place: round and round where the course is closed, else the last one for ever."""
        count = len(self.places)
        return k % count if self.closed else min(max(k, 0), count - 1)

    def speed(self, s: float) -> float:
        """m/s, the mission's speed near arc length ``s``."""
        return self.places[round(clamped(s / self.spacing, 0.0, len(self.places) - 1.0))].speed


def _is_feasible(place: Place, v: float, way: float, capability: Capability) -> bool:
    sustained = SUSTAINED_THRUST_MAX * capability.specific_thrust
    return _is_within(place, v, way, capability, 1.0, capability.specific_thrust) and _is_within(
        place, v, way, capability, place.sustained_ratio, sustained
    )


def _is_within(place: Place, v: float, way: float, capability: Capability, bend: float, most: float) -> bool:
    """Whether ``bend`` of a place's curvature takes no more thrust than ``most`` (m/s^2), nor too steep a tilt."""
    (kx, ky, kz), (tx, ty, tz), (dx, dy, dz) = place.curvature, place.tangent, capability.disturbance_n
    v2, cv = bend * v * v, capability.drag * v * way
    x, y, z = kx * v2 + tx * cv - dx, ky * v2 + ty * cv - dy, kz * v2 + tz * cv - dz - capability.gravity
    level = x * x + y * y
    return z < 0.0 and level <= (capability.tan_tilt_max * z) ** 2 and level + z * z <= most * most


def _fastest(place: Place, v: float, way: float, capability: Capability) -> float:
    """The largest speed below ``v`` that is possible there, no less than the slowest that is flown."""
    low, high = SPEED_SCALE_MIN * v, v
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _is_feasible(place, middle, way, capability) else (low, middle)
    return low


def govern_speed(
    governor: SpeedScale, course: Course, s: float, asked: SpeedScale, capability: Capability, dt: float
) -> SpeedScale:
    """The governor's factor ``dt`` s later, at arc length ``s`` (m). ``asked``: what all the other factors ask for.

    The factor follows its target by a first-order lag of its rate, which is bounded; its acceleration is not counted.
    """
    if governor.value == 1.0 and course.is_easy(asked.value, capability):
        return governor
    speed = course.speed(s) * max(abs(asked.value), 0.1)
    if speed <= 0.0:
        return governor
    target = min(1.0, max(course.allowed_speed(s, asked.value, capability) / speed, SPEED_SCALE_MIN))
    value, rate, _ = governor
    if target == value == 1.0:
        return UNITY
    towards = (target - value) / max(dt, SMOOTHING_TIME)
    wanted = min(max(towards, -BRAKING_MAX / speed), RECOVERY_MAX / speed)
    rate += (wanted - rate) * min(1.0, dt / SMOOTHING_TIME)
    value += rate * dt
    if value >= 1.0:
        return UNITY
    return SpeedScale(max(value, SPEED_SCALE_MIN), rate)


def course_of(
    table: ArcTable,
    speed: Callable[[float], float],
    closed: bool,
    direction: float,
    heading: Callable[[float], float] = lambda s: 0.0,
) -> Course:
    """The course along a curve. ``speed``: the mission's at an arc length, of either sign. ``heading``: rad there."""
    count = max(8, math.ceil(table.length / SPACING))
    spacing = table.length / count
    places = []
    for i in range(count if closed else count + 1):
        _, tangent, curvature = table.at(i * spacing)
        places.append(Place(tangent, curvature, abs(speed(i * spacing)), heading=heading(i * spacing)))
    bends = [math.hypot(*place.curvature) for place in places]
    ratios = [_sustained_ratio(bends, i, place.speed, spacing, closed) for i, place in enumerate(places)]
    places = [place._replace(sustained_ratio=ratio) for place, ratio in zip(places, ratios, strict=True)]
    return Course(tuple(places), spacing, closed, direction)


def _sustained_ratio(bends: Sequence[float], i: int, speed: float, spacing: float, closed: bool) -> float:
    """See Place."""
    reach = round(0.5 * SUSTAINED_TIME * speed / spacing)
    around = range(i - reach, i + reach + 1)
    near = [bends[k % len(bends)] if closed else bends[min(max(k, 0), len(bends) - 1)] for k in around]
    return min(1.0, sum(near) / (len(near) * bends[i])) if bends[i] > 0.0 else 1.0
