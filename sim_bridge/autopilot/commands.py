"""What the vehicle answers to commands: MAV_CMD -> MAV_RESULT, as PX4 does."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

from companion.mavlink.modes import Mode
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander import FORCE, Result, Severity
from sim_bridge.autopilot.messages import BUILDERS
from sim_bridge.autopilot.streams import STOPPED

RETURN_TO_LAUNCH, LAND, TAKEOFF = 20, 21, 22  # MAV_CMD_NAV_*
SET_MODE, REBOOT, ARM_DISARM = 176, 246, 400
GET_MESSAGE_INTERVAL, SET_MESSAGE_INTERVAL, REQUEST_MESSAGE = 510, 511, 512
MESSAGE_INTERVAL = 244
CUSTOM_MODE_ENABLED = 0x01
NOT_GIVEN = 2**31 - 1
"""What COMMAND_INT says for a coordinate that is not given."""
NOT_GIVEN_CAST = 2.0**31
"""The same after a cast to float. A COMMAND_LONG with it in its fifth or sixth parameter is denied."""

_MAINS = {mode.main for mode in Mode} - {0}
_MODES = {mode.value: mode for mode in Mode if mode is not Mode.UNKNOWN}


class Command(NamedTuple):
    """A command: its id, its seven parameters (NaN where not given), and who sent it."""

    id: int
    parameters: tuple[float, float, float, float, float, float, float]
    system: int
    component: int


class Wire(Protocol):
    """What a command can do to the link it came by."""

    def send(self, msgid: int) -> None:
        """Send a message that has a builder, now."""

    def tell_interval(self, msgid: int) -> None:
        """Send MESSAGE_INTERVAL for a message."""

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        """Change a stream's interval. False: it cannot be."""


def execute(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """Do what a command says, as far as it can be done, and tell the result."""
    handler = _HANDLERS.get(command.id)
    return Result.UNSUPPORTED if handler is None else handler(command, autopilot, wire)


def mode_asked(main: int, sub: int) -> Mode | str:
    """The mode of DO_SET_MODE's parameters, or the text PX4 refuses it with."""
    mode = _MODES.get((main, sub))
    if mode is not None:
        return mode
    return "Unsupported auto mode\t" if main in _MAINS else "Unsupported main mode\t"


def set_mode(base_mode: int, main: int, sub: int, autopilot: Autopilot) -> Result:
    """A change of mode, from a command or the old message."""
    if not base_mode & CUSTOM_MODE_ENABLED:
        autopilot.commander.say(Severity.CRITICAL, "Unsupported main mode\t")
        return Result.TEMPORARILY_REJECTED
    mode = mode_asked(main, sub)
    if isinstance(mode, str):
        autopilot.commander.say(Severity.CRITICAL, mode)
        return Result.TEMPORARILY_REJECTED
    return autopilot.request_mode(mode)


def _whole(value: float) -> int:
    """A parameter that means a whole number; -1 where it is none."""
    return round(value) if math.isfinite(value) and abs(value) < 2**53 else -1


def _set_mode(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    base, main, sub = map(_whole, command.parameters[:3])
    return set_mode(base, main, max(sub, 0), autopilot)


def _arm_disarm(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    action = _whole(command.parameters[0])
    if action not in (0, 1):
        autopilot.commander.say(Severity.CRITICAL, f"Unsupported ARM_DISARM param: {command.parameters[0]:.3f}\t")
        return Result.UNSUPPORTED
    return autopilot.commander.request_arming(action == 1, command.parameters[1] == FORCE, autopilot.t)


def _take_off(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    altitude = command.parameters[6]
    autopilot.guidance.takeoff_to = autopilot.home.altitude - altitude if math.isfinite(altitude) else None
    return autopilot.request_mode(Mode.TAKEOFF)


def _land(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return autopilot.request_mode(Mode.LAND)


def _return(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return autopilot.request_mode(Mode.RETURN)


def _set_message_interval(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    msgid, interval, *others, target = command.parameters
    unused = (others[0], others[1], target)
    if not math.isfinite(interval) or any(math.isfinite(value) and round(value) != 0 for value in unused):
        return Result.FAILED
    interval_us = min(_whole(interval), 2**31) if interval >= 0.0 else STOPPED
    return Result.ACCEPTED if wire.set_interval(_whole(msgid), interval_us) else Result.FAILED


def _get_message_interval(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    wire.tell_interval(_whole(command.parameters[0]))
    return Result.ACCEPTED


def _request_message(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    msgid = _whole(command.parameters[0])
    if msgid == MESSAGE_INTERVAL:
        wire.tell_interval(_whole(command.parameters[1]))
        return Result.ACCEPTED
    if msgid not in BUILDERS:
        return Result.DENIED
    wire.send(msgid)
    return Result.ACCEPTED


def _reboot(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return Result.DENIED


_HANDLERS: dict[int, Callable[[Command, Autopilot, Wire], Result]] = {
    RETURN_TO_LAUNCH: _return,
    LAND: _land,
    TAKEOFF: _take_off,
    SET_MODE: _set_mode,
    REBOOT: _reboot,
    ARM_DISARM: _arm_disarm,
    GET_MESSAGE_INTERVAL: _get_message_interval,
    SET_MESSAGE_INTERVAL: _set_message_interval,
    REQUEST_MESSAGE: _request_message,
}
