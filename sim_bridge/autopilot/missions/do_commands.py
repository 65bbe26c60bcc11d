"""What a mission orders besides flying somewhere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from companion.mavlink.modes import Mode
from companion.mavlink_common import (
    MAV_CMD_DO_CHANGE_SPEED,
    MAV_CMD_DO_SET_HOME,
    MAV_CMD_DO_SET_ROI,
    MAV_CMD_DO_SET_ROI_LOCATION,
    MAV_CMD_DO_SET_ROI_NONE,
    MAV_CMD_NAV_RETURN_TO_LAUNCH,
    MAV_CMD_NAV_ROI,
)
from sim_bridge.autopilot.missions.checks import altitude_of
from sim_bridge.autopilot.missions.items import Item

if TYPE_CHECKING:
    from sim_bridge.autopilot.autopilot import Autopilot

ROI_BY_PLACE = 3  # MAV_ROI_LOCATION
USE_HERE = 0.5


def carry_out(item: Item, autopilot: Autopilot) -> None:
    """Do what an item says, as far as this vehicle can: cameras and mounts it has none."""
    command = item.command
    if command == MAV_CMD_NAV_RETURN_TO_LAUNCH:
        autopilot.request_mode(Mode.RETURN)
    elif command == MAV_CMD_DO_CHANGE_SPEED:
        change_speed(item.params[1], autopilot)
    elif command == MAV_CMD_DO_SET_HOME and item.params[0] > USE_HERE:
        autopilot.home_position.set_home_here(autopilot.estimate)
    elif command == MAV_CMD_DO_SET_ROI_LOCATION or (
        command in (MAV_CMD_NAV_ROI, MAV_CMD_DO_SET_ROI) and _is_a_place(item)
    ):
        look_at(item.x, item.y, altitude_of(item, autopilot.home_altitude), autopilot)
    elif command in (MAV_CMD_DO_SET_ROI_NONE, MAV_CMD_NAV_ROI, MAV_CMD_DO_SET_ROI):
        autopilot.mission.interest = None


def change_speed(speed: float, autopilot: Autopilot) -> None:
    """The cruise speed (m/s) of the automatic modes; not positive: the usual one again."""
    autopilot.guidance.cruise_speed = speed if math.isfinite(speed) and speed > 0.0 else None


def look_at(latitude: float, longitude: float, altitude: float, autopilot: Autopilot) -> None:
    """The nose of a mission points at a place (degrees, m above the sea) from now on."""
    if math.isfinite(latitude) and math.isfinite(longitude):
        place = autopilot.projection.project(latitude, longitude)
        autopilot.mission.interest = (*place, autopilot.home.altitude - altitude)


def _is_a_place(item: Item) -> bool:
    return item.has_coordinates and int(item.params[0]) == ROI_BY_PLACE
