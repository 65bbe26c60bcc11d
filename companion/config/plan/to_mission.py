"""A plan -> what a mission of kind plan flies: the path, the speed of its legs, its fence, what it counts from."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from companion.config.plan.corners import Legs, merged
from companion.config.plan.room import flyable, too_near
from companion.config.plan.yaw import leg_yaw
from companion.fence import Fence
from companion.frames import Vec3
from companion.geodesy import Home, LocalFrame
from companion.mission import GlobalOrigin, PathAction
from companion.paths.curve import Curve
from companion.paths.placement import Placement
from companion.paths.polyline import polyline
from companion.paths.spline import SPACING, spline
from companion.paths.tracing import LENGTH_MAX
from companion.plans.items import Key, Plan, PlanError, Problem, fence_in
from companion.plans.payload import placed_along
from companion.plans.route import route_of
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


@dataclass(frozen=True)
class PlannedPath:
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


def prepare_plan(
    plan: Plan, tolerance: float, smooth: bool, placement: Placement, home_altitude: float | None = None,
    line_of: Callable[[Key], int] | None = None,
) -> PlannedPath:  # fmt: skip
    """``tolerance``: m, how far from a waypoint the path may pass it. ``smooth``: a spline through the waypoints.
    ``placement``: how the mission counts. ``home_altitude``: m above the sea, told where the plan does not say.
    ``line_of``: see ``route_of``.
    PlanError: it cannot be flown. ValueError: its waypoints cannot be joined."""
    way = route_of(plan, line_of)
    home = plan.home or Home(*way.waypoints[0].place[:2], home_altitude)
    above_sea = {waypoint.place.amsl for waypoint in way.waypoints}
    if True in above_sea and home.altitude is None:
        raise PlanError([Problem(plan.home_key, NO_HOME)])
    frame = LocalFrame(home.latitude, home.longitude, home.altitude or 0.0)
    _near_enough(way, frame)
    legs = merged(_apart(way, frame), tolerance)
    if not smooth:
        legs = flyable(legs)
    points = [placement.to_mission(p) for p in legs.points]
    curve = spline(points, legs.closed) if smooth else polyline(points, legs.closed, legs.tolerances)
    curve = curve.placed(placement)
    arcs = _arcs(curve, legs, smooth)
    speeds = [w.speed or plan.speed or HOVER_SPEED for w in legs.waypoints]
    yaw, faced_n = leg_yaw(curve, legs.points, legs.waypoints, arcs, speeds, frame, smooth)
    fence = fence_in(plan.fence, lambda latitude, longitude: frame.to_local(latitude, longitude, frame.altitude))
    return PlannedPath(
        curve=curve,
        origin=GlobalOrigin(
            home.latitude, home.longitude, frame.altitude if True in above_sea else 0.0, True not in above_sea
        ),
        speed=_speed(arcs, speeds, legs.closed),
        yaw=yaw,
        look_at=None if faced_n is None else placement.to_mission(faced_n),
        fence=None if fence is None else fence.moved(placement.to_mission),
        notes=(*_notes(plan, way, frame.altitude), *(() if smooth or not (near := too_near(legs)) else (near,))),
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
