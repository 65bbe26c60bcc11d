"""Places, speeds, home."""

from __future__ import annotations

import math

from companion.frames import Vec3, quaternion_from_euler
from companion.mavlink.modes import Mode
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander import Result
from sim_bridge.autopilot.commands.parts import Command, Handler, Wire

CHANGE_SPEED, SET_HOME, CHANGE_ALTITUDE, LAND_START, GO_AROUND, REPOSITION = (
    178,
    179,
    186,
    189,
    191,
    192,
)  # MAV_CMD_DO_*
REGIONS_OF_INTEREST = (80, 195, 196, 197, 201)  # MAV_CMD_NAV_ROI, DO_SET_ROI_*
CHANGE_MODE = 1
"""MAV_DO_REPOSITION_FLAGS_CHANGE_MODE: the only one PX4 takes, and it must be there."""


def _set_home(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """Home is here, or at a place with a heading (degrees)."""
    if not autopilot.parameters["COM_HOME_EN"]:
        return Result.DENIED
    here, roll, pitch, yaw, latitude, longitude, altitude = command.parameters
    if here > 0.5:
        if not autopilot.whereabouts.position_known:
            return Result.TEMPORARILY_REJECTED
        autopilot.whereabouts.set_home_here(autopilot.estimate)
        return Result.ACCEPTED
    place = _place(autopilot, latitude, longitude, altitude)
    if place is None:
        return Result.DENIED
    if not autopilot.whereabouts.position_known:
        return Result.TEMPORARILY_REJECTED
    attitude = quaternion_from_euler(*(math.radians(x) if math.isfinite(x) else 0.0 for x in (yaw, pitch, roll)))
    autopilot.whereabouts.set_home(place, attitude, autopilot.estimate)
    return Result.ACCEPTED


def _place(autopilot: Autopilot, latitude: float, longitude: float, altitude: float) -> Vec3 | None:
    """A place on the globe in the local frame; None: one of its numbers is none."""
    if not all(map(math.isfinite, (latitude, longitude, altitude))):
        return None
    return (*autopilot.projection.project(latitude, longitude), autopilot.home.altitude - altitude)


def _reposition(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """Hold at a place. What is not a number stays as it is; nothing given at all: hold here."""
    speed, flags, _, yaw, latitude, longitude, altitude = command.parameters
    if not math.isfinite(flags) or int(flags) != CHANGE_MODE:
        return Result.UNSUPPORTED
    result = autopilot.request_mode(Mode.HOLD)
    if result is Result.ACCEPTED and autopilot.commander.armed:
        level = None
        if math.isfinite(latitude) and math.isfinite(longitude):
            level = autopilot.projection.project(latitude, longitude)
        down = autopilot.home.altitude - altitude if math.isfinite(altitude) else None
        heading = yaw if math.isfinite(yaw) else None
        autopilot.go_to(level, down, heading, speed if math.isfinite(speed) and speed > 0.0 else None)
    return result


def _change_altitude(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """Hold at another altitude (m above the sea)."""
    altitude = command.parameters[0]
    result = autopilot.request_mode(Mode.HOLD)
    if result is Result.ACCEPTED and autopilot.commander.armed and math.isfinite(altitude):
        autopilot.go_to(None, autopilot.home.altitude - altitude, None, None)
    return result


def _change_speed(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """The cruise speed (m/s) of the automatic modes; not positive: the usual one again."""
    speed = command.parameters[1]
    autopilot.guidance.cruise_speed = speed if math.isfinite(speed) and speed > 0.0 else None
    return Result.ACCEPTED


def _land_start(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return Result.CANCELLED


def _accept(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return Result.ACCEPTED


HANDLERS: dict[int, Handler] = {
    CHANGE_SPEED: _change_speed,
    SET_HOME: _set_home,
    CHANGE_ALTITUDE: _change_altitude,
    LAND_START: _land_start,
    GO_AROUND: _accept,
    REPOSITION: _reposition,
    **dict.fromkeys(REGIONS_OF_INTEREST, _accept),
}
