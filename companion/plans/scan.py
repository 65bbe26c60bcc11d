"""QGroundControl's structure scan as items: a .plan holds only its figures, not the waypoints they mean.

Round the structure at a distance from its walls, layer by layer, from a waypoint at the entrance altitude to the same
one again; the rules are those QGroundControl itself follows when it sends the scan to a vehicle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.geodesy import MapProjection
from companion.mavlink_common import (
    MAV_CMD_DO_SET_ROI_NONE,
    MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET,
    MAV_CMD_NAV_WAYPOINT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT,
    MAV_FRAME_MISSION,
)
from companion.plans.items import Item, Key

Corner = tuple[float, float]


@dataclass(frozen=True, slots=True)
class StructureScan:
    """``polygon``: the structure's walls, latitude and longitude. Heights in m above home: ``entrance``, the ``bottom``
    and the ``top`` that are scanned; ``layer_height`` of each of ``layers``. ``distance``: m from the walls."""

    polygon: tuple[Corner, ...]
    distance: float
    entrance: float
    bottom: float
    top: float
    layers: int
    layer_height: float
    from_top: bool


def scan_items(scan: StructureScan, number: int, key: Key) -> list[Item]:
    """The items of a scan; the first has the ``number`` given."""
    round_it = grown(scan.polygon, scan.distance)
    nan = math.nan
    found: list[Item] = []

    def add(command: int, frame: int, *params: float) -> None:
        found.append(Item(command, frame, params, number + len(found), key))

    def waypoint(corner: Corner, height: float) -> None:
        add(MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL_RELATIVE_ALT, 0.0, 0.0, 0.0, nan, *corner, height)

    waypoint(round_it[0], scan.entrance)
    add(MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET, MAV_FRAME_MISSION, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 90.0)
    step = -scan.layer_height if scan.from_top else scan.layer_height
    height = (scan.top if scan.from_top else scan.bottom) + 0.5 * step
    for _ in range(scan.layers):
        for corner in (*round_it, round_it[0]):
            waypoint(corner, height)
        height += step
    add(MAV_CMD_DO_SET_ROI_NONE, MAV_FRAME_MISSION, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    waypoint(round_it[0], scan.entrance)
    return found


def grown(polygon: Sequence[Corner], distance: float) -> list[Corner]:
    """The polygon with every wall moved outward by ``distance`` m. ValueError: it has no inside."""
    plane = MapProjection(*polygon[0])
    p = [plane.project(*corner) for corner in polygon]
    count = len(p)
    area = sum(p[i][0] * p[(i + 1) % count][1] - p[(i + 1) % count][0] * p[i][1] for i in range(count))
    if count < 3 or abs(area) < 1e-6:
        raise ValueError("the polygon has no inside")
    outward = math.copysign(distance, area)  # north-east turns the same way as x-y seen from below
    walls = []
    for i in range(count):
        (ax, ay), (bx, by) = p[i], p[(i + 1) % count]
        length = math.hypot(bx - ax, by - ay)
        if length < 1e-3:
            raise ValueError(f"corners {i + 1} and {(i + 1) % count + 1} of the polygon are the same")
        dx, dy = (bx - ax) / length, (by - ay) / length
        walls.append((ax + dy * outward, ay - dx * outward, dx, dy))
    corners = []
    for i in range(count):
        ax, ay, adx, ady = walls[i - 1]
        bx, by, bdx, bdy = walls[i]
        cross = adx * bdy - ady * bdx
        along = ((bx - ax) * bdy - (by - ay) * bdx) / cross if abs(cross) > 1e-9 else None
        corners.append((bx, by) if along is None else (ax + along * adx, ay + along * ady))
    return [plane.reproject(*corner) for corner in corners]
