"""Places, speeds, home."""

from __future__ import annotations

import math

from companion.frames import Vec3, quaternion_from_euler
from companion.mavlink.modes import Mode
from companion.mavlink_common import (
    MAV_CMD_DO_CHANGE_ALTITUDE,
    MAV_CMD_DO_CHANGE_SPEED,
    MAV_CMD_DO_GO_AROUND,
    MAV_CMD_DO_LAND_START,
    MAV_CMD_DO_REPOSITION,
    MAV_CMD_DO_SET_GLOBAL_ORIGIN,
    MAV_CMD_DO_SET_HOME,
    MAV_CMD_DO_SET_MISSION_CURRENT,
    MAV_CMD_DO_SET_ROI,
    MAV_CMD_DO_SET_ROI_LOCATION,
    MAV_CMD_DO_SET_ROI_NONE,
    MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET,
    MAV_CMD_MISSION_START,
    MAV_CMD_NAV_ROI,
    MavResult,
    MavSeverity,
)
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commands.parts import Command, Handler, Wire, accept
from sim_bridge.autopilot.missions.store import Kind

REGIONS_OF_INTEREST = (
    MAV_CMD_NAV_ROI,
    MAV_CMD_DO_SET_ROI_LOCATION,
    MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET,
    MAV_CMD_DO_SET_ROI_NONE,
    MAV_CMD_DO_SET_ROI,
)
CHANGE_MODE = 1
"""MAV_DO_REPOSITION_FLAGS_CHANGE_MODE; without it only a vehicle that holds already moves."""


def _set_home(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """Home is here, or at a place with a heading (degrees)."""
    if not autopilot.parameters["COM_HOME_EN"]:
        return MavResult.DENIED
    here, roll, pitch, yaw, latitude, longitude, altitude = command.parameters
    if here > 0.5:
        if not autopilot.home_position.position_known:
            return MavResult.TEMPORARILY_REJECTED
        autopilot.home_position.set_home_here(autopilot.estimate)
        return MavResult.ACCEPTED
    place = _place(autopilot, latitude, longitude, altitude)
    if place is None:
        return MavResult.DENIED
    if not autopilot.home_position.position_known:
        return MavResult.TEMPORARILY_REJECTED
    attitude = quaternion_from_euler(*(math.radians(x) if math.isfinite(x) else 0.0 for x in (yaw, pitch, roll)))
    autopilot.home_position.set_home(place, attitude, autopilot.estimate)
    return MavResult.ACCEPTED


def _place(autopilot: Autopilot, latitude: float, longitude: float, altitude: float) -> Vec3 | None:
    """A place on the globe in the local frame; None: one of its numbers is none."""
    if not all(map(math.isfinite, (latitude, longitude, altitude))):
        return None
    return (*autopilot.projection.project(latitude, longitude), autopilot.home.altitude - altitude)


def _reposition(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """Hold at a place. What is not a number stays as it is; nothing given at all: hold here."""
    speed, flags, _, yaw, latitude, longitude, altitude = command.parameters
    if math.isfinite(flags) and int(flags) & CHANGE_MODE:
        result = autopilot.request_mode(Mode.HOLD)
    else:
        result = MavResult.ACCEPTED if autopilot.commander.mode is Mode.HOLD else MavResult.DENIED
    if result is MavResult.ACCEPTED and autopilot.commander.armed:
        level = None
        if math.isfinite(latitude) and math.isfinite(longitude):
            level = autopilot.projection.project(latitude, longitude)
        down = autopilot.home.altitude - altitude if math.isfinite(altitude) else None
        heading = yaw if math.isfinite(yaw) else None
        autopilot.go_to(level, down, heading, speed if math.isfinite(speed) and speed > 0.0 else None)
    return result


def _change_altitude(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """Hold at another altitude (m above the sea), where it holds already."""
    altitude = command.parameters[0]
    holds = autopilot.commander.mode is Mode.HOLD
    result = MavResult.ACCEPTED if holds else MavResult.TEMPORARILY_REJECTED
    if result is MavResult.ACCEPTED and autopilot.commander.armed and math.isfinite(altitude):
        autopilot.go_to(None, autopilot.home.altitude - altitude, None, None)
    return result


def _change_speed(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    autopilot.mission_watch.do_commands.change_speed(command.parameters[1])
    return MavResult.ACCEPTED


def _update_failsafe(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """A region of interest: a place, or none. It counts while a mission is flown."""
    *_, latitude, longitude, altitude = command.parameters
    if command.id == MAV_CMD_DO_SET_ROI_LOCATION:
        autopilot.mission_watch.do_commands.look_at(latitude, longitude, altitude)
    else:
        autopilot.mission.interest = None
    return MavResult.ACCEPTED


def _start_mission(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """Arm and fly the mission from an item on; -1: from the current one."""
    commander, first = autopilot.commander, command.parameters[0]
    if commander.failsafe_flags.auto_mission_missing:
        commander.say(MavSeverity.CRITICAL, "Mission start denied! No valid mission\t")
        return MavResult.DENIED
    if not -1.0 <= first < len(autopilot.missions.items[Kind.MISSION]):
        return MavResult.DENIED
    result = autopilot.request_mode(Mode.MISSION)
    if result is MavResult.ACCEPTED:
        result = commander.request_arming(True, False, autopilot.t, by="mission start")
    if result is MavResult.ACCEPTED and first >= 0.0:
        autopilot.missions.set_current(int(first))
    return result


def _set_mission_current(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    index, resets = command.parameters[:2]
    if not index >= -1.0 or not math.isfinite(index) or resets not in (0.0, 1.0):
        return MavResult.DENIED
    if autopilot.commander.failsafe_flags.auto_mission_missing:
        return MavResult.FAILED
    if resets:
        autopilot.mission.forget_jumps()
    return MavResult.ACCEPTED if index < 0.0 or autopilot.missions.set_current(int(index)) else MavResult.FAILED


def _land_start(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    return MavResult.CANCELLED


HANDLERS: dict[int, Handler] = {
    MAV_CMD_DO_CHANGE_SPEED: _change_speed,
    MAV_CMD_DO_SET_HOME: _set_home,
    MAV_CMD_DO_SET_GLOBAL_ORIGIN: accept,
    MAV_CMD_DO_CHANGE_ALTITUDE: _change_altitude,
    MAV_CMD_DO_LAND_START: _land_start,
    MAV_CMD_DO_GO_AROUND: accept,
    MAV_CMD_DO_REPOSITION: _reposition,
    MAV_CMD_MISSION_START: _start_mission,
    MAV_CMD_DO_SET_MISSION_CURRENT: _set_mission_current,
    **dict.fromkeys(REGIONS_OF_INTEREST, _update_failsafe),
}
