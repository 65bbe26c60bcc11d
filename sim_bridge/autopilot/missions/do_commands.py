"""What a mission orders besides flying somewhere."""

from __future__ import annotations

import math

from companion.geodesy import MapProjection
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
from companion.world import Home
from sim_bridge.autopilot.commander.commander import Commander
from sim_bridge.autopilot.commander.home_position import HomePosition
from sim_bridge.autopilot.flight_modes.guidance import Guidance
from sim_bridge.autopilot.missions.checks import altitude_of
from sim_bridge.autopilot.missions.flight import MissionFlight
from sim_bridge.autopilot.missions.items import Item
from sim_bridge.sensors import Estimate

ROI_BY_PLACE = 3  # MAV_ROI_LOCATION
USE_HERE = 0.5
"""DO_SET_HOME's first parameter: beyond it, here."""


class DoCommands:
    """Carries them out, as far as this vehicle can: cameras and mounts it has none."""

    def __init__(
        self, commander: Commander, mission: MissionFlight, guidance: Guidance, home: HomePosition, ground: Home,
        projection: MapProjection,
    ) -> None:  # fmt: skip
        self._commander, self._mission, self._guidance, self._home = commander, mission, guidance, home
        self._ground, self._projection = ground, projection

    def carry_out(self, item: Item, now: Estimate, t: float) -> None:
        """Do what an item says."""
        command = item.command
        if command == MAV_CMD_NAV_RETURN_TO_LAUNCH:
            self._commander.request_mode(Mode.RETURN, t)
        elif command == MAV_CMD_DO_CHANGE_SPEED:
            self.change_speed(item.params[1])
        elif command == MAV_CMD_DO_SET_HOME and item.params[0] > USE_HERE:
            self._home.set_home_here(now)
        elif command == MAV_CMD_DO_SET_ROI_LOCATION or (
            command in (MAV_CMD_NAV_ROI, MAV_CMD_DO_SET_ROI) and _is_a_place(item)
        ):
            self.look_at(item.x, item.y, altitude_of(item, self._home.altitude))
        elif command in (MAV_CMD_DO_SET_ROI_NONE, MAV_CMD_NAV_ROI, MAV_CMD_DO_SET_ROI):
            self._mission.interest = None

    def change_speed(self, speed: float) -> None:
        """The cruise speed (m/s) of the automatic modes; not positive: the usual one again."""
        self._guidance.cruise_speed = speed if math.isfinite(speed) and speed > 0.0 else None

    def look_at(self, latitude: float, longitude: float, altitude: float) -> None:
        """The nose of a mission points at a place (degrees, m above the sea) from now on."""
        if math.isfinite(latitude) and math.isfinite(longitude):
            place = self._projection.project(latitude, longitude)
            self._mission.interest = (*place, self._ground.altitude - altitude)


def _is_a_place(item: Item) -> bool:
    return item.has_coordinates and int(item.params[0]) == ROI_BY_PLACE
