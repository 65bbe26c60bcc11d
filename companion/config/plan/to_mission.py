"""A plan -> what a mission of kind plan flies: the path, the speed of its legs, its fence, what it counts from."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from companion.config.plan.yaw import leg_yaw
from companion.fence import Fence
from companion.frames import Vec3
from companion.geodesy import Home, LocalFrame
from companion.mission import GlobalOrigin, PathAction
from companion.paths.curve import Curve
from companion.paths.placement import Placement
from companion.paths.polyline import PHI, SPLIT, polyline
from companion.paths.spline import SPACING, spline
from companion.paths.tracing import LENGTH_MAX
from companion.plans.items import Key, Plan, PlanError, Problem, fence_in
from companion.plans.payload import placed_along
from companion.plans.route import route
from companion.plans.waypoints import Route, Waypoint
from companion.profiles import AutoSpeed, Yaw

NO_HOME = (
    "heights above sea level, and it is not known how high home, and so the ground, lies; say it: --home LAT,LON,METRES"
)
HOVER_SPEED = 5.0
"""m/s, QGroundControl's own default, for plans that do not say."""
FAR = 50_000.0
"""m; a waypoint farther from the first is a mistake. PX4's own distance to a mission's first waypoint is less."""
APART = 0.05
"""m; nearer waypoints are one."""
RADIUS_MIN = 0.5
"""m; a rounded corner that bends tighter is flown as two."""
LEFT_MIN = 0.1
"""m of a tolerance that are left for rounding where two waypoints are flown as one."""
BEND = 35.0 / 16.0
"""Twice the largest second derivative of ``polyline``'s blend."""
HALF_LEG_MIN = 1.2
"""m, half the leg between the two: a turn on the spot then has a radius of 0.39 m."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Planned:
    """A plan made ready. ``curve``: the path, placed. ``origin``: the planned home, which it counts from. ``yaw``: as
    the plan says, ``look_at`` in the mission's coordinates where it faces one place all the way. ``fence``: in the
    mission's coordinates. ``notes``: what of the plan is not flown. ``home``, ``mixed_heights``: see Mission."""

    curve: Curve
    origin: GlobalOrigin
    speed: AutoSpeed
    yaw: Yaw
    look_at: Vec3 | None
    fence: Fence | None
    notes: tuple[str, ...]
    home: Home | None = None
    mixed_heights: bool = False
    actions: tuple[PathAction, ...] = ()


@dataclass(frozen=True, slots=True)
class Legs:
    """``points``: north, east, down in m from the planned home. ``waypoints``: for each the leg that leads to it.
    ``tolerances``: m, how far from each the path may pass it."""

    points: list[Vec3]
    waypoints: list[Waypoint]
    closed: bool
    tolerances: list[float] = field(default_factory=list)


def planned(
    plan: Plan, tolerance: float, smooth: bool, placement: Placement, home_altitude: float | None = None,
    line_of: Callable[[Key], int] | None = None,
) -> Planned:  # fmt: skip
    """``tolerance``: m, how far from a waypoint the path may pass it. ``smooth``: a spline through the waypoints.
    ``placement``: how the mission counts. ``home_altitude``: m above the sea, told where the plan does not say.
    ``line_of``: see ``route``.
    PlanError: it cannot be flown. ValueError: its waypoints cannot be joined."""
    way = route(plan, line_of)
    home = plan.home or Home(*way.waypoints[0].place[:2], home_altitude)
    above_sea = {waypoint.place.amsl for waypoint in way.waypoints}
    if True in above_sea and home.altitude is None:
        raise PlanError([Problem(("mission", "plannedHomePosition"), NO_HOME)])
    frame = LocalFrame(home.latitude, home.longitude, home.altitude or 0.0)
    _near_enough(way, frame)
    legs = merged(_apart(way, frame), tolerance)
    if not smooth:
        legs = _turned_round(legs)
    points = [placement.to_mission(p) for p in legs.points]
    curve = spline(points, legs.closed) if smooth else polyline(points, legs.closed, legs.tolerances)
    curve = curve.placed(placement)
    arcs = _arcs(curve, legs, smooth)
    speeds = [w.speed or plan.speed or HOVER_SPEED for w in legs.waypoints]
    yaw, faced_n = leg_yaw(curve, legs.points, legs.waypoints, arcs, speeds, frame, smooth)
    fence = fence_in(plan.fence, lambda latitude, longitude: frame.to_local(latitude, longitude, frame.altitude))
    return Planned(
        curve=curve,
        origin=GlobalOrigin(
            home.latitude, home.longitude, frame.altitude if True in above_sea else 0.0, True not in above_sea
        ),
        speed=_speed(arcs, speeds, legs.closed),
        yaw=yaw,
        look_at=None if faced_n is None else placement.to_mission(faced_n),
        fence=None if fence is None else fence.moved(placement.to_mission),
        notes=_notes(plan, way, frame.altitude),
        home=home,
        mixed_heights=len(above_sea) == 2,
        actions=_actions(legs, arcs, curve.table.length),
    )


def _actions(legs: Legs, arcs: list[float], length: float) -> tuple[PathAction, ...]:
    """What the payload does along the path."""
    stops = [(s, waypoint.payload) for s, waypoint in zip(arcs, legs.waypoints, strict=False)]
    return tuple(PathAction(s, *command) for s, command in placed_along(stops, length))


def _notes(plan: Plan, way: Route, home: float) -> tuple[str, ...]:
    notes = list(way.notes)
    if len({waypoint.place.amsl for waypoint in way.waypoints}) == 2:
        notes.append(f"its heights above home count from {home:.1f} m above sea level, those above the sea are kept")
    if plan.rally:
        notes.append("its rally points are the autopilot's own business")
    return tuple(notes)


def _near_enough(way: Route, frame: LocalFrame) -> None:
    """PlanError: names the item at which the path becomes longer than a path may be, or lies in another country."""
    first = before = way.waypoints[0].place.seen_from(frame)
    length = 0.0
    for waypoint in way.waypoints:
        point = waypoint.place.seen_from(frame)
        length += math.dist(before, point)
        away, before = math.dist(first, point), point
        if away > FAR:
            said = f"it lies {away / 1000.0:.0f} km from where the path begins; expected {FAR / 1000.0:g} at most"
        elif length > LENGTH_MAX:
            said = f"the path is {length / 1000.0:.0f} km long here; expected {LENGTH_MAX / 1000.0:g} at most"
        else:
            continue
        raise PlanError([Problem(waypoint.key, f"item {waypoint.number}: {said}")])


def _apart(way: Route, frame: LocalFrame) -> Legs:
    """The waypoints without those that only say the place of the one before again."""
    points: list[Vec3] = []
    kept: list[Waypoint] = []
    for waypoint in way.waypoints:
        point = waypoint.place.seen_from(frame)
        if not points or math.dist(points[-1], point) >= APART:
            points.append(point)
            kept.append(waypoint)
        else:
            kept[-1] = kept[-1]._replace(payload=kept[-1].payload + waypoint.payload)
    closed = way.closed
    if closed and len(points) > 1 and math.dist(points[0], points[-1]) < APART:
        points.pop()
        kept.pop()
    if len(points) < 2:
        raise ValueError("has all its waypoints at one place")
    return Legs(points, kept, closed and len(points) > 2)


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


def _turned_round(legs: Legs) -> Legs:
    """A corner too sharp to be rounded within its tolerance is flown as two, a short leg across it between them."""
    p = np.array(legs.points)
    ahead = np.roll(p, -1, axis=0) - p
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-9)[:, None]
    cosines = np.clip(np.sum(np.roll(ahead, 1, axis=0) * ahead, axis=1), -1.0, 1.0)
    # of the rounded corner of ``polyline`` at its tightest: tolerance / 0.598 / tan^2(turn/2)
    tolerances = np.array(legs.tolerances)
    radii = tolerances / (2.0 * PHI[-1]) / BEND * (1.0 + cosines) / np.maximum(1.0 - cosines, 1e-9)
    kept: list[float] = []
    points: list[Vec3] = []
    waypoints: list[Waypoint] = []
    last = len(p) - 1
    for i, (point, waypoint) in enumerate(zip(legs.points, legs.waypoints, strict=True)):
        if (not legs.closed and i in (0, last)) or radii[i] > RADIUS_MIN:
            points.append(point)
            waypoints.append(waypoint)
            kept.append(legs.tolerances[i])
            continue
        half = max(legs.tolerances[i], HALF_LEG_MIN)
        for sign in (-half, half):
            x, y, z = p[i] + sign * _across(ahead[i - 1], ahead[i])
            points.append((float(x), float(y), float(z)))
            waypoints.append(waypoint if sign < 0.0 else waypoint._replace(payload=()))
            kept.append(legs.tolerances[i])
    return replace(legs, points=points, waypoints=waypoints, tolerances=kept)


def _across(before: Array, after: Array) -> Array:
    """The direction half-way between two that nearly oppose each other; level, to the right, where they do."""
    middle = before + after
    length = float(np.linalg.norm(middle))
    if length > 0.05:
        return middle / length
    north, east = before[:2] if math.hypot(*before[:2]) > 1e-3 else (1.0, 0.0)
    return np.array([-east, north, 0.0]) / math.hypot(north, east)


def _arcs(curve: Curve, legs: Legs, smooth: bool) -> list[float]:
    """m, where along the path each waypoint is; of a closed path the first is at 0."""
    steps = np.linalg.norm(np.diff(np.array(legs.points), axis=0), axis=1) ** (SPACING if smooth else 1.0)
    parameters = np.concatenate([[0.0], np.cumsum(steps)])
    return [0.0, *(curve.arc(float(u)) for u in parameters[1:])]


def _speed(arcs: list[float], speeds: list[float], closed: bool) -> AutoSpeed:
    """Never faster than the plan says, and slower where the vehicle must be."""
    legs = [*speeds[1:], speeds[0]] if closed else speeds[1:]
    caps: list[tuple[float, float]] = []
    for begin, speed in zip(arcs, legs, strict=False):
        if not caps or caps[-1][1] != speed:
            caps.append((begin, speed))
    return AutoSpeed(speed_max=max(legs), caps=tuple(caps) if len(caps) > 1 else ())
