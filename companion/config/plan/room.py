"""Corners that a short leg leaves no room to be rounded: the leg goes on beyond its waypoints, which stay on it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from companion.config.plan.corners import LEFT_MIN, TURN_RADIUS, Array, Legs, bend_radii, sharp_corners, turned_round
from companion.frames import Vec3

RADIUS_LEAST = 0.3
"""m: what ``check`` refuses to bend tighter (feasibility's RADIUS_MIN; a test holds the two together)."""
STEPS = tuple(0.1 * k for k in range(1, 11))
"""Ratios of the tolerance by which a leg's end is moved on: the first that is enough is taken. Engineering choice."""
BESIDE = 2
"""Number of waypoints before and after a leg whose bends a change of it is judged by."""


def flyable(legs: Legs) -> Legs:
    """``legs`` with room to turn and sharp corners turned round; without the room where that leaves wider bends."""
    plain, roomy = turned_round(legs), with_room(legs)
    if roomy is legs:
        return plain
    return max(turned_round(roomy), plain, key=lambda tried: float(_corners(tried)[1].min()))


def with_room(legs: Legs) -> Legs:
    """``legs``: with every corner that a short leg makes bend tighter than TURN_RADIUS moved on along that leg, by its
    tolerance at most. The path then turns beyond the waypoint and passes it on the leg, within its tolerance still. The
    ends of an open path are kept, and what would not become wider stays as it is."""
    fixed = set(sharp_corners(legs)) | (set() if legs.closed else {0, len(legs.points) - 1})
    found = legs
    count = len(legs.points)
    ring, radii = _corners(legs)
    tight = {ring[at] for at in np.flatnonzero(radii < TURN_RADIUS)}
    for i in range(count if legs.closed else count - 1):
        ends = (i, (i + 1) % count)
        movable = [k for k in ends if k not in fixed]
        if not movable or tight.isdisjoint(ends):
            continue
        before, tightest = found, _around(found, i)
        for share in STEPS:
            tried = _longer(before, legs.points, ends, movable, share)
            if tried is None or not _sharp_near(tried, i) <= fixed:
                continue  # a corner that became too sharp would be flown as two, farther from its waypoint
            radius = _around(tried, i)
            if radius > tightest:
                found, tightest = tried, radius
            if tightest >= TURN_RADIUS:
                break
    return found


def too_near(legs: Legs) -> str | None:
    """Which two items are too near to each other for the turn between them, where the path bends tighter than can be
    held; None where it does not."""
    corners, radii = _corners(legs)
    if not corners or float(radii.min()) >= RADIUS_LEAST:
        return None
    here = corners[int(radii.argmin())]
    beside = (here - 1, (here + 1) % len(legs.points))
    others = [k for k in beside if legs.waypoints[k].number != legs.waypoints[here].number]
    if not others:
        return None
    other = min(others, key=lambda k: math.dist(legs.points[k], legs.points[here]))
    first, last = sorted((legs.waypoints[here].number, legs.waypoints[other].number))
    return (
        f"items {first} and {last} are too near to each other for the turn there: it bends to a radius of "
        f"{radii.min():.2f} m, and {RADIUS_LEAST:g} m is the least; move them apart, or delete one of them"
    )


def _corners(legs: Legs) -> tuple[list[int], Array]:
    """The waypoints that the path turns at, and the least radius of each (m)."""
    count = len(legs.points)
    ring = [count - 1, *range(count), 0] if legs.closed else list(range(count))
    inner = ring[1:-1]
    return inner, bend_radii([legs.points[k] for k in ring], [legs.tolerances[k] for k in inner])


def _around(legs: Legs, i: int) -> float:
    """m, the least radius of the corners near leg ``i``."""
    ring = _near(legs, i)
    radii = bend_radii([legs.points[k] for k in ring], [legs.tolerances[k] for k in ring[1:-1]])
    return float(radii.min()) if len(radii) else math.inf


def _near(legs: Legs, i: int) -> list[int]:
    count = len(legs.points)
    near = range(i - BESIDE, i + BESIDE + 2)
    return [k % count for k in near] if legs.closed else [k for k in near if 0 <= k < count]


def _sharp_near(legs: Legs, i: int) -> set[int]:
    """The corners near leg ``i`` that are too sharp to be rounded."""
    ring = _near(legs, i)
    some = Legs(
        [legs.points[k] for k in ring], [legs.waypoints[k] for k in ring], False, [legs.tolerances[k] for k in ring]
    )
    return {ring[k] for k in sharp_corners(some)}


def _longer(legs: Legs, meant: list[Vec3], ends: tuple[int, int], movable: list[int], share: float) -> Legs | None:
    """With the ``movable`` ends of a leg moved on by ``share`` of their tolerances; None where one would be passed too
    far. ``meant``: the waypoints where they were drawn."""
    a, b = (np.array(legs.points[k]) for k in ends)
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
    points = list(legs.points)
    for k in movable:
        forward = along if k == ends[1] else -along
        x, y, z = map(float, np.array(points[k]) + share * legs.tolerances[k] * forward)
        points[k] = (x, y, z)
    tolerances = list(legs.tolerances)
    count = len(points)
    for k in movable:
        neighbours = (points[k - 1], points[(k + 1) % count])
        tolerances[k] -= min(_distance(meant[k], points[k], other) for other in neighbours)
        if tolerances[k] < LEFT_MIN:
            return None
    return replace(legs, points=points, tolerances=tolerances)


def _distance(point: Vec3, begin: Vec3, end: Vec3) -> float:
    """m, of a point from the leg between two."""
    p, a, b = (np.array(each) for each in (point, begin, end))
    way = b - a
    share = min(max(float((p - a) @ way) / max(float(way @ way), 1e-18), 0.0), 1.0)
    return float(np.linalg.norm(p - a - share * way))
