"""The path comes first: where the vehicle cannot fly it at the mission's speed, the speed gives way and comes back.

What the path asks at a speed v is a thrust over mass F = k v^2 + c v T - d - g e3 (k its curvature, T its tangent; drag
and disturbance as they are known now). Ahead of every place where F would be more than the vehicle has, or lean further
than it may, the speed is brought down in time. A short peak may ask for all the thrust there is, what lasts only for
less: the rest is for turning and for errors. What is flown then is slower than the mission wants; the mission's speed
is what the flight is measured against all the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from companion.frames import Vec3
from companion.law.flight import Ramp
from companion.paths.arc import ArcTable

SPACING = 0.4
"""m between the places looked at."""
PLANNED, BRAKING, RECOVERING = 1.0, 1.5, 1.5
"""m/s^2: what is counted on to slow down in time, at which the speed gives way at most, and at which it comes back."""
LOOK_MIN = 0.5
"""s of flight that are looked ahead even when standing still is near."""
SMOOTH = 0.15
"""s over which the change of the speed sets in."""
SLOWEST = 0.25
"""The least share of the mission's speed."""
SHARE, LASTING = 0.96, 0.5
"""Of the largest thrust, for what lasts so long (s)."""


class Pace(NamedTuple):
    """``factor``: the share of the mission's speed that is asked for; ``rate``: 1/s."""

    factor: float = 1.0
    rate: float = 0.0


class Means(NamedTuple):
    """What the vehicle has: ``lift`` m/s^2 at most, ``lean`` (the tangent of the steepest tilt), and the forces on it:
    ``drag`` 1/s, ``disturbance_n`` and ``gravity`` m/s^2."""

    lift: float
    lean: float
    drag: float
    disturbance_n: Vec3
    gravity: float


class Place(NamedTuple):
    """A place of the path: unit tangent, curvature (1/m), the mission's speed (m/s, without a sign). ``lasting``: the
    share of its curvature that the path has in the mean of LASTING s around it; 1 where it has as much or more."""

    tangent: Vec3
    curvature: Vec3
    speed: float
    lasting: float = 1.0


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

    def easy(self, factor: float, means: Means) -> bool:
        """Whether nothing on the whole course can be too much, by a bound that is quickly computed."""
        across, fastest = self.hardest
        f = abs(factor)
        push = across * f * f + means.drag * fastest * f + math.hypot(*means.disturbance_n)
        upright = means.gravity - push
        return upright > 0.0 and push <= means.lean * upright and means.gravity + push <= SHARE * means.lift

    def allowed(self, s: float, factor: float, means: Means) -> float:
        """The largest speed (m/s) at arc length ``s`` from which every place ahead can still be met slowly enough, when
        ``factor`` of the mission's speed is wanted; infinite if nothing is in the way."""
        count = len(self.places)
        step = self.direction if factor >= 0.0 else -self.direction
        first = s / self.spacing
        begin = math.floor(first) if step > 0.0 else math.ceil(first)
        wanted = abs(factor)
        most = math.inf
        travelled, k = 0.0, begin
        here = self.places[begin % count if self.closed else min(max(begin, 0), count - 1)]
        now = here.speed * wanted
        reach = now * (LOOK_MIN + 0.5 * now / PLANNED) + self.spacing
        while travelled <= reach:
            index = k % count if self.closed else k
            if not 0 <= index < count:
                break
            place = self.places[index]
            speed = place.speed * wanted
            if not _can(place, speed, step, means):
                slow = _fastest(place, speed, step, means)
                most = min(most, math.sqrt(slow * slow + 2.0 * PLANNED * max(0.0, travelled - self.spacing)))
            k += 1 if step > 0.0 else -1
            travelled += self.spacing
        return most

    def speed(self, s: float) -> float:
        """m/s, the mission's speed near arc length ``s``."""
        return self.places[min(max(round(s / self.spacing), 0), len(self.places) - 1)].speed


def _can(place: Place, v: float, way: float, means: Means) -> bool:
    lasting = SHARE * means.lift
    return _bears(place, v, way, means, 1.0, means.lift) and _bears(place, v, way, means, place.lasting, lasting)


def _bears(place: Place, v: float, way: float, means: Means, bend: float, lift: float) -> bool:
    """Whether ``bend`` of a place's curvature takes no more than ``lift`` (m/s^2), nor leans too far."""
    (kx, ky, kz), (tx, ty, tz), (dx, dy, dz) = place.curvature, place.tangent, means.disturbance_n
    v2, cv = bend * v * v, means.drag * v * way
    x, y, z = kx * v2 + tx * cv - dx, ky * v2 + ty * cv - dy, kz * v2 + tz * cv - dz - means.gravity
    level = x * x + y * y
    return z < 0.0 and level <= (means.lean * z) ** 2 and level + z * z <= lift * lift


def _fastest(place: Place, v: float, way: float, means: Means) -> float:
    """The largest speed below ``v`` that is possible there, no less than the slowest that is flown."""
    low, high = SLOWEST * v, v
    for _ in range(8):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _can(place, middle, way, means) else (low, middle)
    return low


def paced(pace: Pace, course: Course, s: float, ramp: Ramp, means: Means, dt: float) -> Pace:
    """The pace ``dt`` s later."""
    if pace.factor == 1.0 and course.easy(ramp.factor, means):
        return pace
    speed = course.speed(s) * max(abs(ramp.factor), 0.1)
    if speed <= 0.0:
        return pace
    target = min(1.0, max(course.allowed(s, ramp.factor, means) / speed, SLOWEST))
    factor, rate = pace
    if target == factor == 1.0:
        return Pace()
    towards = (target - factor) / max(dt, SMOOTH)
    wanted = min(max(towards, -BRAKING / speed), RECOVERING / speed)
    rate += (wanted - rate) * min(1.0, dt / SMOOTH)
    factor += rate * dt
    if factor >= 1.0:
        return Pace()
    return Pace(max(factor, SLOWEST), rate)


def slowed(ramp: Ramp, pace: Pace) -> Ramp:
    """``ramp`` at a pace."""
    factor, rate = pace
    return Ramp(
        ramp.factor * factor,
        ramp.rate * factor + ramp.factor * rate,
        ramp.acceleration * factor + 2.0 * ramp.rate * rate,
    )


def course_of(table: ArcTable, speed: Callable[[float], float], closed: bool, direction: float) -> Course:
    """The course along a curve. ``speed``: the mission's at an arc length, of either sign."""
    count = max(8, math.ceil(table.length / SPACING))
    spacing = table.length / count
    places = []
    for i in range(count if closed else count + 1):
        _, tangent, curvature = table.at(i * spacing)
        places.append(Place(tangent, curvature, abs(speed(i * spacing))))
    bends = [math.hypot(*place.curvature) for place in places]
    lasting = [_lasting(bends, i, place.speed, spacing, closed) for i, place in enumerate(places)]
    places = [place._replace(lasting=share) for place, share in zip(places, lasting, strict=True)]
    return Course(tuple(places), spacing, closed, direction)


def _lasting(bends: Sequence[float], i: int, speed: float, spacing: float, closed: bool) -> float:
    """See Place."""
    reach = round(0.5 * LASTING * speed / spacing)
    around = range(i - reach, i + reach + 1)
    near = [bends[k % len(bends)] if closed else bends[min(max(k, 0), len(bends) - 1)] for k in around]
    return min(1.0, sum(near) / (len(near) * bends[i])) if bends[i] > 0.0 else 1.0
