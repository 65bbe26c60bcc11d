"""What PX4 refuses to fly, found when a mission comes in."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.mavlink_common import (
    MAV_CMD_DO_VTOL_TRANSITION,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_TAKEOFF,
    MAV_CMD_NAV_VTOL_LAND,
    MAV_CMD_NAV_VTOL_TAKEOFF,
    MAV_FRAME_GLOBAL_RELATIVE_ALT,
)
from sim_bridge.autopilot.missions.items import Item

VTOL = {MAV_CMD_NAV_VTOL_TAKEOFF, MAV_CMD_NAV_VTOL_LAND, MAV_CMD_DO_VTOL_TRANSITION}
"""MAV_CMD that only a VTOL flies."""


def fault_of(
    items: Sequence[Item],
    *,
    home_is_known: bool,
    home_altitude: float,
    landed: bool,
    may_be_at: Callable[[float, float, float], bool],
) -> str | None:
    """What is wrong with a mission; None: it can be flown. PX4 says what ends in a tab as a text; the rest is an event.

    ``home_altitude``: m above the sea; ``may_be_at``: whether the geofence allows a latitude, longitude (degrees) and
    altitude (m above the sea).
    """
    if not home_is_known:
        return "Not yet ready for mission, no position lock.\t"
    found_place = False
    for number, item in enumerate(items, 1):
        if item.command == MAV_CMD_NAV_LAND and number == 1 and landed:
            return "Mission rejected: starts with landing"
        if item.command == MAV_CMD_NAV_TAKEOFF:
            if altitude_of(item, 0.0) - (0.0 if item.frame == MAV_FRAME_GLOBAL_RELATIVE_ALT else home_altitude) < 1e-6:
                return "Mission rejected: Takeoff altitude below home altitude!"
            if found_place:
                return "Mission rejected: takeoff not first waypoint item"
        if item.command in VTOL:
            return "Mission rejected: Mission contains VTOL items but vehicle is not a VTOL"
        found_place |= item.has_place
    for number, item in enumerate(items, 1):
        if item.has_place and not may_be_at(item.x, item.y, altitude_of(item, home_altitude)):
            return f"Geofence violation for waypoint {number}\t"
    return None


def altitude_of(item: Item, home_altitude: float) -> float:
    """m above the sea."""
    height = item.z if math.isfinite(item.z) else 0.0
    return height + home_altitude if item.frame == MAV_FRAME_GLOBAL_RELATIVE_ALT else height
