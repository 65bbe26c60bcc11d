"""The heading along a plan's route: leg by leg, blended where two legs meet."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.frames import Vec3, wrap
from companion.geodesy import LocalFrame
from companion.paths.curve import Curve
from companion.plans.items import Place
from companion.plans.waypoints import Waypoint
from companion.profiles import ConstantYaw, LookAt, TangentYaw, Yaw, yaw_table

TURN_RATE, TURN_ACCELERATION = math.radians(45.0), math.radians(60.0)
"""How fast the nose turns where two headings meet, and how quickly it takes that up, if the legs are long enough."""
STEEPEST, SHARPEST = 35.0 / 16.0, 7.52
"""The largest slope and second derivative of a blend from 0 to 1 on an interval of length 1."""
BLEND_MIN = 0.5
"""m, half the length of a blend."""
LEG_SHARE = 0.45
"""The share of a leg that a blend at its end may take."""
SAMPLE_EVERY = 2.0
"""m between the samples of a heading that changes along a leg."""
VERTICAL = 0.02
"""The share of a leg that is level, under which it has no heading of its own."""

Heading = Callable[[float], float]
"""rad at an arc length."""


def leg_yaw(
    curve: Curve,
    points: list[Vec3],
    waypoints: list[Waypoint],
    arcs: list[float],
    speeds: list[float],
    frame: LocalFrame,
    smooth: bool,
) -> tuple[Yaw, Vec3 | None]:
    """The heading along ``curve``, and the place it faces all the way (north, east, down in m from the planned home),
    if it does. ``arcs``: m, of each waypoint; ``speeds``: m/s, of the leg that leads to it."""
    closed = curve.closed
    legs = list(range(1, len(points))) + ([0] if closed else [])
    asked = {waypoints[k].heading for k in legs}
    along = [_along(points[k - 1], points[k]) for k in legs]
    if asked == {None} and (all(heading is not None for heading in along) or smooth):
        return TangentYaw(), None
    if len(asked) == 1:
        (only,) = asked
        if isinstance(only, Place):
            target = only.seen_from(frame)
            return LookAt(target), target
        if only is not None:
            return ConstantYaw(math.radians(only)), None
    headings = _headings(curve, [waypoints[k].heading for k in legs], along, frame)
    ends = [*arcs, curve.table.length] if closed else arcs
    rows = _rows(headings, ends, [speeds[k] for k in legs], closed)
    return yaw_table(rows, curve.table.length if closed else None), None


def _rows(headings: list[Heading], ends: list[float], speeds: list[float], closed: bool) -> list[tuple[float, float]]:
    """Samples (m, rad) of the headings of legs between ``ends``, with room between them for the blends."""
    count = len(headings)
    margins = [0.0] * (count + 1)
    for j in range(0 if closed else 1, count):
        before, after = headings[j - 1], headings[j]
        turn = abs(wrap(after(ends[j]) - before(ends[j] if j else ends[-1])))
        speed = max(speeds[j - 1], speeds[j])
        time = max(STEEPEST * turn / TURN_RATE, math.sqrt(SHARPEST * turn / TURN_ACCELERATION))
        wanted = max(0.5 * speed * time, BLEND_MIN)
        shortest = min(ends[j + 1] - ends[j], ends[j] - ends[j - 1] if j else ends[-1] - ends[-2])
        margins[j] = min(wanted, LEG_SHARE * shortest)
    if closed:
        margins[count] = margins[0]
    rows: list[tuple[float, float]] = []
    for j, heading in enumerate(headings):
        begin, end = ends[j] + margins[j], ends[j + 1] - margins[j + 1]
        steady = heading(begin) == heading(0.5 * (begin + end)) == heading(end)
        parts = 1 if steady else max(1, math.ceil((end - begin) / SAMPLE_EVERY))
        for i in range(parts + 1):
            s = begin + (end - begin) * i / parts
            if not rows or s > rows[-1][0] + 1e-6:
                rows.append((s, heading(s)))
    return rows


def _headings(
    curve: Curve, asked: list[float | Place | None], along: list[float | None], frame: LocalFrame
) -> list[Heading]:
    headings: list[Heading] = []
    last = next((heading for heading in along if heading is not None), 0.0)
    for wanted, ahead in zip(asked, along, strict=True):
        if isinstance(wanted, Place):
            headings.append(_towards(curve, wanted.seen_from(frame)))
            continue
        if wanted is not None:
            last = math.radians(wanted)
        elif ahead is not None:
            last = ahead
        headings.append(_steady(last))
    return headings


def _steady(heading: float) -> Heading:
    return lambda s: heading


def _towards(curve: Curve, target: Vec3) -> Heading:
    def heading(s: float) -> float:
        north, east, _ = curve.table.at(s)[0]
        return math.atan2(target[1] - east, target[0] - north)

    return heading


def _along(begin: Vec3, end: Vec3) -> float | None:
    north, east = end[0] - begin[0], end[1] - begin[1]
    if math.hypot(north, east) < VERTICAL * math.dist(begin, end):
        return None
    return math.atan2(east, north)
