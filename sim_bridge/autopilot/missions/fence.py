"""Geofences: inside or outside. Places are (north, east) in m of the local frame, heights m above home."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from companion.mavlink_common import (
    MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
)
from sim_bridge.autopilot.missions.items import Item

Place = tuple[float, float]


class Area(NamedTuple):
    """A polygon, or with ``radius`` (m) a circle about its one corner. ``keeps_in``: else it keeps out."""

    corners: tuple[Place, ...]
    radius: float | None
    keeps_in: bool

    def allows(self, place: Place) -> bool:
        """Whether one may be there."""
        return self._contains(place) is self.keeps_in

    def _contains(self, place: Place) -> bool:
        if self.radius is not None:
            (north, east) = self.corners[0]
            return math.hypot(place[0] - north, place[1] - east) < self.radius
        inside = False
        for (n0, e0), (n1, e1) in zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True):
            if (e0 >= place[1]) != (e1 >= place[1]) and place[0] <= (n1 - n0) * (place[1] - e0) / (e1 - e0) + n0:
                inside = not inside
        return inside


def areas_of(items: Sequence[Item], project: Callable[[float, float], Place]) -> tuple[Area, ...]:
    """The areas a list of fence items describes. ``project``: degrees to a place."""
    areas = []
    at = 0
    while at < len(items):
        item = items[at]
        if item.command in (MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION):
            centre = project(item.x, item.y)
            areas.append(Area((centre,), item.params[0], item.command == MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION))
            at += 1
        elif item.command in (MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION):
            count = max(1, int(item.params[0]))
            corners = tuple(project(corner.x, corner.y) for corner in items[at : at + count])
            areas.append(Area(corners, None, item.command == MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION))
            at += count
        else:
            at += 1
    return tuple(areas)


def allowed(areas: Sequence[Area], place: Place) -> bool:
    """Whether every area allows a place."""
    return all(area.allows(place) for area in areas)
