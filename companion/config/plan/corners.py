"""Waypoints too near to each other, or turns too sharp, to be flown as they are: merged, turned round, in tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from companion.frames import Vec3
from companion.paths.polyline import PHI, SPLIT
from companion.plans.waypoints import Waypoint

RADIUS_MIN = 0.5
"""m; a rounded corner that bends tighter is flown as two."""
LEFT_MIN = 0.1
"""m of a tolerance that are left for rounding where two waypoints are flown as one."""
BEND = 35.0 / 16.0
"""Twice the largest second derivative of ``polyline``'s blend."""
HALF_LEG_MIN = 1.2
"""m, half the leg between the two: a turn on the spot then has a radius of 0.39 m."""
TURN_RADIUS = 0.35
"""m: as wide as a turn round is made where its legs allow it; 0.3 m is the least that can be held (feasibility)."""
ACROSS = (1.0, -1.0, 1.4, -1.4, 1.8, -1.8, 2.2, -2.2)
"""Half legs that are tried, to the one side and the other: the first that is wide enough is taken."""
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Legs:
    """``points``: north, east, down in m from the planned home. ``waypoints``: for each the leg that leads to it.
    ``tolerances``: m, how far from each the path may pass it."""

    points: list[Vec3]
    waypoints: list[Waypoint]
    closed: bool
    tolerances: list[float] = field(default_factory=list)


def merged(legs: Legs, tolerance: float) -> Legs:
    """Waypoints nearer to each other than ``tolerance`` (m), which no vehicle could tell apart within it, as one in
    their middle: as far from each as half of it at most, and the path passes that so much nearer. Of an open path the
    ends are kept."""
    groups: list[list[int]] = []
    for i, point in enumerate(legs.points):
        if groups:
            first = legs.points[groups[-1][0]]
            middle = [0.5 * (a + b) for a, b in zip(first, point, strict=True)]
            if all(math.dist(legs.points[k], middle) < 0.5 * tolerance for k in (*groups[-1], i)):
                groups[-1].append(i)
                continue
        groups.append([i])
    if len(groups) < (3 if legs.closed else 2):
        return replace(legs, tolerances=[tolerance] * len(legs.points))
    points, tolerances = [], []
    for k, group in enumerate(groups):
        first, last = legs.points[group[0]], legs.points[group[-1]]
        if not legs.closed and k in (0, len(groups) - 1):
            kept = first if k == 0 else last
        else:
            kept = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]), 0.5 * (first[2] + last[2]))
        points.append(kept)
        tolerances.append(tolerance - max(math.dist(legs.points[i], kept) for i in group))
    waypoints = [_one([legs.waypoints[i] for i in group]) for group in groups]
    merged_legs = Legs(points, waypoints, legs.closed, tolerances)
    while True:
        pair = _too_near(merged_legs)
        if pair is None:
            return merged_legs
        merged_legs = _joined(merged_legs, pair)


def _too_near(legs: Legs) -> int | None:
    """A corner that its short leg to the next leaves no room to be rounded, where the two can be flown as one: their
    middle is within what is left of both tolerances."""
    p = np.array(legs.points)
    ahead = np.diff(p, axis=0)
    lengths = np.linalg.norm(ahead, axis=1)
    for i in range(1, len(p) - 2):
        left = min(legs.tolerances[i], legs.tolerances[i + 1]) - 0.5 * lengths[i]
        if left < LEFT_MIN:
            continue
        for before, after in ((i - 1, i), (i, i + 1)):
            cosine = float(ahead[before] @ ahead[after] / (lengths[before] * lengths[after]))
            half = 0.5 * math.acos(min(max(cosine, -1.0), 1.0))
            room = SPLIT * min(lengths[before], lengths[after])
            if room * math.cos(half) ** 2 < RADIUS_MIN * BEND * math.sin(half):
                return i
    return None


def _one(waypoints: list[Waypoint]) -> Waypoint:
    """Waypoints as one: the leg that leads to the first, and what the payload does at all of them."""
    payload = tuple(command for waypoint in waypoints for command in waypoint.payload)
    return waypoints[0]._replace(payload=payload)


def _joined(legs: Legs, i: int) -> Legs:
    """With waypoint ``i`` and the next as one in their middle."""
    (x, y, z), (u, v, w) = legs.points[i], legs.points[i + 1]
    left = min(legs.tolerances[i], legs.tolerances[i + 1]) - 0.5 * math.dist(legs.points[i], legs.points[i + 1])
    return Legs(
        [*legs.points[:i], (0.5 * (x + u), 0.5 * (y + v), 0.5 * (z + w)), *legs.points[i + 2 :]],
        [*legs.waypoints[:i], _one(legs.waypoints[i : i + 2]), *legs.waypoints[i + 2 :]],
        legs.closed,
        [*legs.tolerances[:i], left, *legs.tolerances[i + 2 :]],
    )


def turned_round(legs: Legs) -> Legs:
    """A corner too sharp to be rounded within its tolerance is flown as two, a short leg across it between them, to the
    side that leaves the widest bends: two turns at the ends of a short leg look at each other."""
    across = sharp_corners(legs)
    chosen = _sides(legs, across)
    points: list[Vec3] = []
    waypoints: list[Waypoint] = []
    tolerances: list[float] = []
    for i, waypoint in enumerate(legs.waypoints):
        places = _both_sides(legs.points[i], chosen[i] * across[i]) if i in across else [legs.points[i]]
        points += places
        waypoints += [waypoint, waypoint._replace(payload=())][: len(places)]
        tolerances += [legs.tolerances[i]] * len(places)
    return replace(legs, points=points, waypoints=waypoints, tolerances=tolerances)


def _sides(legs: Legs, across: dict[int, Array]) -> dict[int, float]:
    """Which of ACROSS each turn is flown with: of all ways through a row of turns the one whose tightest bend is the
    widest, TURN_RADIUS being wide enough, and among those the shortest."""
    count = len(legs.points)

    def around(i: int) -> list[Vec3]:
        return [legs.points[i % count]] if legs.closed or 0 <= i < count else []

    chosen: dict[int, float] = {}
    best: list[tuple[float, float, list[float]]] = []  # for the last turn at each of ACROSS: bend, -length, choices
    for i in across:
        row: list[tuple[float, float, list[float]]] = []
        for k in ACROSS:
            here = _both_sides(legs.points[i], k * across[i])
            after = [] if i + 1 in across else around(i + 1)
            if not best:
                bend = _tightest([*around(i - 2), *around(i - 1), *here, *after], legs.tolerances[i])
                row.append((min(bend, TURN_RADIUS), -abs(k), [k]))
                continue
            ways = []
            for bend_before, short, choices in best:
                before = _both_sides(legs.points[i - 1], choices[-1] * across[i - 1])
                bend = min(bend_before, _tightest([*before, *here, *after], legs.tolerances[i]))
                ways.append((bend, short - abs(k), [*choices, k]))
            row.append(max(ways))
        best = row
        if i + 1 not in across:  # the row of turns ends here
            choices = max(best)[2]
            chosen |= zip(range(i + 1 - len(choices), i + 1), choices, strict=True)
            best = []
    return chosen


def sharp_corners(legs: Legs) -> dict[int, Array]:
    """The corners that are to be turned round: half the leg across each."""
    p = np.array(legs.points)
    ahead = np.roll(p, -1, axis=0) - p
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-9)[:, None]
    cosines = np.clip(np.sum(np.roll(ahead, 1, axis=0) * ahead, axis=1), -1.0, 1.0)
    # of the rounded corner of ``polyline`` at its tightest: tolerance / 0.598 / tan^2(turn/2)
    tolerances = np.array(legs.tolerances)
    radii = tolerances / (2.0 * PHI[-1]) / BEND * (1.0 + cosines) / np.maximum(1.0 - cosines, 1e-9)
    inner = range(len(p)) if legs.closed else range(1, len(p) - 1)
    return {
        i: max(legs.tolerances[i], HALF_LEG_MIN) * _across(ahead[i - 1], ahead[i])
        for i in inner
        if radii[i] <= RADIUS_MIN
    }


def _both_sides(point: Vec3, half: Array) -> list[Vec3]:
    x, y, z = point
    u, v, w = map(float, half)
    return [(x - u, y - v, z - w), (x + u, y + v, z + w)]


def _tightest(points: list[Vec3], tolerance: float) -> float:
    """m, the least radius of the rounded corners between ``points``, each within ``tolerance`` m of its corner."""
    return float(np.min(bend_radii(points, tolerance)))


def bend_radii(points: list[Vec3], tolerances: float | list[float]) -> Array:
    """m, the least radius of each rounded corner between ``points``, passed within ``tolerances`` (m, one or each)."""
    p = np.array(points)
    ahead = np.diff(p, axis=0)
    lengths = np.maximum(np.linalg.norm(ahead, axis=1), 1e-9)
    cosines = np.clip(np.sum(ahead[:-1] * ahead[1:], axis=1) / (lengths[:-1] * lengths[1:]), -1.0, 1.0)
    sines = np.maximum(np.sqrt(0.5 * (1.0 - cosines)), 1e-9)
    reach = np.minimum(SPLIT * np.minimum(lengths[:-1], lengths[1:]), np.array(tolerances) / (2.0 * PHI[-1] * sines))
    radii: Array = reach * 0.5 * (1.0 + cosines) / (BEND * sines)
    return radii


def _across(before: Array, after: Array) -> Array:
    """The direction half-way between two that nearly oppose each other; level, to the right, where they do."""
    middle = before + after
    length = float(np.linalg.norm(middle))
    if length > 0.05:
        return middle / length
    north, east = before[:2] if math.hypot(*before[:2]) > 1e-3 else (1.0, 0.0)
    return np.array([-east, north, 0.0]) / math.hypot(north, east)
