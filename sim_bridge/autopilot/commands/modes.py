"""Modes, arming, take-off, landing, return."""

from __future__ import annotations

import math

from companion import mavlink_common as mav
from companion.mavlink.modes import Mode
from companion.mavlink_common import (
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_FLIGHTTERMINATION,
    MAV_CMD_DO_ORBIT,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_DO_SET_STANDARD_MODE,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_LAND_LOCAL,
    MAV_CMD_NAV_RETURN_TO_LAUNCH,
    MAV_CMD_NAV_TAKEOFF,
    MavResult,
    MavSeverity,
)
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander.commander import FORCE
from sim_bridge.autopilot.commander.external_modes import EXTERNAL
from sim_bridge.autopilot.commands.parts import Command, Handler, Wire, byte, whole
from sim_bridge.autopilot.flight_modes.guidance import TakeOff
from sim_bridge.autopilot.flight_modes.orbit import orbit_from_command

ANY_SUB = {
    1: Mode.MANUAL,
    2: Mode.ALTITUDE,
    5: Mode.ACRO,
    6: Mode.OFFBOARD,
    7: Mode.STABILIZED,
    11: Mode.ALTITUDE_CRUISE,
}
"""Main modes whose sub mode is not looked at."""
AUTO_MODES = {
    0: Mode.MISSION, 2: Mode.TAKEOFF, 3: Mode.HOLD, 4: Mode.MISSION, 5: Mode.RETURN, 6: Mode.LAND, 8: Mode.FOLLOW,
    9: Mode.PRECISION_LAND, 19: Mode.GUIDED_COURSE, **{mode.sub: mode for mode in EXTERNAL},
}  # fmt: skip
"""By PX4's PX4_CUSTOM_SUB_MODE_AUTO."""
STANDARD = {
    1: Mode.POSITION, 2: Mode.ORBIT, 4: Mode.ALTITUDE, 5: Mode.RETURN, 6: Mode.MISSION, 7: Mode.LAND, 8: Mode.TAKEOFF,
}  # fmt: skip
"""MAV_STANDARD_MODE."""


def mode_asked(base: int, main: int, sub: int) -> Mode | str:
    """The mode of DO_SET_MODE's parameters, or the text PX4 refuses it with."""
    if not base & mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
        if base & mav.MAV_MODE_FLAG_AUTO_ENABLED:
            return Mode.MISSION
        if base & mav.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED:
            if base & mav.MAV_MODE_FLAG_GUIDED_ENABLED:
                return Mode.POSITION
            return Mode.STABILIZED if base & mav.MAV_MODE_FLAG_STABILIZE_ENABLED else Mode.MANUAL
        return "Unsupported base mode\t"
    if main == 3:
        return Mode.POSITION_SLOW if sub == Mode.POSITION_SLOW.sub else Mode.POSITION
    if main == 4:
        return AUTO_MODES.get(sub, "Unsupported auto mode\t")
    return ANY_SUB.get(main, "Unsupported main mode\t")


def set_mode(base: int, main: int, sub: int, autopilot: Autopilot, aloud: bool) -> MavResult:
    """A change of mode, from a command or the old message. ``aloud``: a refusal is told in words."""
    mode = mode_asked(base, main, sub)
    if isinstance(mode, str):
        autopilot.commander.say(MavSeverity.CRITICAL, mode)
        return MavResult.TEMPORARILY_REJECTED
    return autopilot.request_mode(mode, aloud=aloud)


def _set_mode(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    base, main, sub = map(byte, command.parameters[:3])
    return set_mode(base, main, sub, autopilot, command.is_operators)


def _set_standard_mode(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    mode = STANDARD.get(whole(command.parameters[0]))
    return MavResult.FAILED if mode is None else autopilot.request_mode(mode, aloud=False)


def _arm_disarm(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult | None:
    action = whole(command.parameters[0])
    if action not in (0, 1):
        autopilot.commander.say(MavSeverity.CRITICAL, f"Unsupported ARM_DISARM param: {command.parameters[0]:.3f}\t")
        return None
    force = action == 0 and whole(command.parameters[1]) == FORCE  # nobody outside arms by force
    return autopilot.commander.request_arming(action == 1, force, autopilot.t)


def _take_off(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """Over a place, to an altitude above the sea; what is not a number stays as it is, or is PX4's default."""
    latitude, longitude, altitude = command.parameters[4:]
    level = None
    if math.isfinite(latitude) and math.isfinite(longitude):
        level = autopilot.projection.project(latitude, longitude)
    return autopilot.take_off(TakeOff(level, autopilot.home.altitude - altitude if math.isfinite(altitude) else None))


def _land(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    return _change_mode_and_say(Mode.LAND, "Landing at current position\t", autopilot)


def _land_precisely(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    return _change_mode_and_say(Mode.PRECISION_LAND, "Precision landing\t", autopilot)


def _return(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    return _change_mode_and_say(Mode.RETURN, "Returning to launch\t", autopilot)


def _change_mode_and_say(mode: Mode, text: str, autopilot: Autopilot) -> MavResult:
    """Change to ``mode`` and say so, before whatever the mode itself says."""
    commander = autopilot.commander
    before = len(commander.texts)
    result = autopilot.request_mode(mode)
    if result is MavResult.ACCEPTED:
        said, commander.texts[before:] = commander.texts[before:], []
        commander.say(MavSeverity.INFO, text)
        commander.texts += said
    return result


def _orbit(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    radius, speed, yaw_behaviour, _, latitude, longitude, altitude = command.parameters
    result = autopilot.request_mode(Mode.ORBIT, aloud=False)
    if result is not MavResult.ACCEPTED:
        autopilot.commander.say(MavSeverity.CRITICAL, "Orbit command rejected")
        return result
    now, guidance = autopilot.estimate, autopilot.guidance
    centre = None
    if math.isfinite(latitude) and math.isfinite(longitude):
        down = autopilot.home.altitude - altitude if math.isfinite(altitude) else now.p_n[2]
        centre = (*autopilot.projection.project(latitude, longitude), down)
    most = autopilot.parameters["MC_ORBIT_RAD_MAX"]
    orbit = orbit_from_command(guidance.orbit, (radius, speed, yaw_behaviour), centre, now, most)
    if orbit is None:
        autopilot.commander.say(MavSeverity.CRITICAL, "Orbit radius limit exceeded\t")
    else:
        guidance.orbit = orbit
    return result


def _terminate(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    if not command.parameters[0] > 0.5 or not autopilot.commander.armed:
        return MavResult.DENIED
    return autopilot.request_mode(Mode.TERMINATION, aloud=False)


HANDLERS: dict[int, Handler] = {
    MAV_CMD_NAV_RETURN_TO_LAUNCH: _return,
    MAV_CMD_NAV_LAND: _land,
    MAV_CMD_NAV_TAKEOFF: _take_off,
    MAV_CMD_NAV_LAND_LOCAL: _land_precisely,
    MAV_CMD_DO_ORBIT: _orbit,
    MAV_CMD_DO_SET_MODE: _set_mode,
    MAV_CMD_DO_FLIGHTTERMINATION: _terminate,
    MAV_CMD_DO_SET_STANDARD_MODE: _set_standard_mode,
    MAV_CMD_COMPONENT_ARM_DISARM: _arm_disarm,
}
