"""A mission as a ground station's plan: as many waypoints as its curve needs to be drawn as it is flown."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from companion.fence import Fence, Polygon
from companion.geodesy import Home, LocalFrame
from companion.mavlink_common import (
    MAV_CMD_DO_CHANGE_SPEED,
    MAV_CMD_DO_JUMP,
    MAV_CMD_NAV_WAYPOINT,
    MAV_FRAME_GLOBAL,
    MAV_FRAME_GLOBAL_RELATIVE_ALT,
    MAV_FRAME_MISSION,
)
from companion.mission import GlobalOrigin, Mission
from companion.paths.arc import ArcTable
from companion.plans.items import FenceArea, Item, Plan
from companion.profiles import TangentYaw

BETWEEN = 9
"""Places of the curve between two waypoints at which its distance from the straight leg is looked at."""
FIRST_PARTS = 8
"""legs a path is first divided into."""
SPEED_STEP = 0.05
"""The share by which the speed must change to be worth an item."""
SPEED_SPAN, LEG_MIN = 0.2, 1.0
"""The share by which the speed may change along one leg, unless that is shorter than so many m."""
ACCEPTANCE = 1.0
"""m; where a waypoint says 0, PX4 takes 10."""
FOR_EVER = -1.0
"""DO_JUMP's repeat: without an end."""


def waypoint_plan(mission: Mission, home: LocalFrame, tolerance: float) -> Plan:
    """``mission``: placed in the local frame whose origin is ``home``, its speed known. ``tolerance``: m, the farthest
    that the legs between the waypoints stray from the path. Written from where it begins in the order it is flown.
    ValueError, ArithmeticError: speed or yaw is not defined."""
    table = mission.table
    backward = mission.direction < 0.0
    arcs = waypoint_arcs(mission, tolerance)
    legs = arcs[::-1] if backward else arcs
    amsl = isinstance(mission.origin, GlobalOrigin) and not mission.origin.above_home
    nan, items = math.nan, list[Item]()

    def add(command: int, frame: int, *params: float) -> None:
        items.append(Item(command, frame, params, len(items) + 1, ("mission", "items", len(items))))

    first_speed = abs(mission.alpha(0.5 * (legs[0] + legs[1])))
    speed = first_speed
    for i, s in enumerate(legs):
        latitude, longitude, altitude = home.to_global(table.at(s)[0])
        heading = nan if isinstance(mission.yaw, TangentYaw) else math.degrees(mission.beta(s)) % 360.0
        height = altitude if amsl else altitude - home.altitude
        place = (round(latitude, 9), round(longitude, 9), round(height, 3))
        add(
            MAV_CMD_NAV_WAYPOINT,
            MAV_FRAME_GLOBAL if amsl else MAV_FRAME_GLOBAL_RELATIVE_ALT,
            0.0,
            ACCEPTANCE,
            0.0,
            heading,
            *place,
        )
        following = abs(mission.alpha(0.5 * (s + legs[i + 1]))) if i + 1 < len(legs) else speed
        if abs(following - speed) > SPEED_STEP * speed:
            speed = following
            add(MAV_CMD_DO_CHANGE_SPEED, MAV_FRAME_MISSION, 1.0, round(speed, 2), -1.0, 0.0, 0.0, 0.0, 0.0)
    if table.closed:
        repeats = FOR_EVER if mission.laps is None else float(math.ceil(mission.laps) - 1)
        if repeats != 0.0:
            add(MAV_CMD_DO_JUMP, MAV_FRAME_MISSION, 1.0, repeats, 0.0, 0.0, 0.0, 0.0, 0.0)
    fence = mission.fence_n
    areas = () if fence is None else _areas(fence, home)
    return Plan(tuple(items), Home(home.latitude, home.longitude, home.altitude), round(first_speed, 2), areas)


def waypoint_arcs(mission: Mission, tolerance: float) -> list[float]:
    """m, rising from end to end: where along the path waypoints must be for straight legs to stay within ``tolerance``
    m of it, and for one speed a leg to tell of its speed."""
    table = mission.table

    def short(legs: NDArray[np.float64]) -> NDArray[np.bool_]:
        speeds = np.array([[abs(mission.alpha(float(s))) for s in leg] for leg in legs])
        steady = np.abs(speeds[:, 1] - speeds[:, 0]) <= SPEED_SPAN * speeds.min(axis=1)
        lengths = legs[:, 1] - legs[:, 0]
        enough: NDArray[np.bool_] = (_strays(table, legs) <= tolerance) & (steady | (lengths < LEG_MIN))
        return enough

    edges = np.linspace(0.0, table.length, FIRST_PARTS + 1)
    pending = np.stack([edges[:-1], edges[1:]], axis=1)
    kept = [0.0]
    while len(pending):
        middle = pending.mean(axis=1)
        far = ~short(pending)
        kept += pending[~far, 1].tolist()
        halved, at = pending[far], middle[far]
        pending = np.concatenate([np.stack([halved[:, 0], at], axis=1), np.stack([at, halved[:, 1]], axis=1)])
    return _thinned(sorted(kept), short)


def _strays(table: ArcTable, legs: NDArray[np.float64]) -> NDArray[np.float64]:
    """m, how far the curve strays from the straight leg between each pair of arc lengths."""
    shares = np.linspace(0.0, 1.0, BETWEEN + 2)
    points = np.array([[table.at(float(a + (b - a) * share))[0] for share in shares] for a, b in legs])
    if legs[-1, 1] >= table.length and table.closed:
        points[-1, -1] = table.at(0.0)[0]
    chords = points[:, -1] - points[:, 0]
    lengths = np.maximum(np.linalg.norm(chords, axis=1), 1e-12)
    offsets = points - points[:, :1]
    along = np.clip(np.einsum("ijk,ik->ij", offsets, chords) / lengths[:, None] ** 2, 0.0, 1.0)
    strays: NDArray[np.float64] = np.linalg.norm(offsets - along[..., None] * chords[:, None], axis=-1).max(axis=1)
    return strays


def _thinned(arcs: list[float], short: Callable[[NDArray[np.float64]], NDArray[np.bool_]]) -> list[float]:
    """Without the waypoints that a straight leg does as well without."""
    kept = [arcs[0]]
    for here, following in itertools.pairwise(arcs[1:]):
        if not short(np.array([[kept[-1], following]]))[0]:
            kept.append(here)
    return [*kept, arcs[-1]]


def _areas(fence: Fence, home: LocalFrame) -> tuple[FenceArea, ...]:
    def corner(at: tuple[float, float]) -> tuple[float, float]:
        latitude, longitude, _ = home.to_global((*at, 0.0))
        return (round(latitude, 9), round(longitude, 9))

    return tuple(
        FenceArea(tuple(map(corner, area.corners)), None, area.inside)
        if isinstance(area, Polygon)
        else FenceArea((corner(area.center),), area.radius, area.inside)
        for area in fence.areas
    )
