"""What the vehicle answers to commands: MAV_CMD -> MAV_RESULT, as PX4 does.

command_parameters  which parameters a command takes, and how COMMAND_INT gives a place
parts               a command, what it may do to its link, numbers
modes               modes, arming, take-off, landing, return
navigation          places, speeds, missions, home
services            streams, requests, parameters, calibration and what a vehicle without the device says

Some commands PX4 leaves to a module that is not there: those get no answer at all.
"""

from __future__ import annotations

from companion.mavlink_common import MavResult
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commands import modes, navigation, services
from sim_bridge.autopilot.commands.command_parameters import place_given, stray
from sim_bridge.autopilot.commands.modes import set_mode
from sim_bridge.autopilot.commands.parts import Command, Handler, Wire, is_integer_max

__all__ = ["Command", "Wire", "execute", "is_integer_max", "place_given", "set_mode", "stray"]

_HANDLERS: dict[int, Handler] = modes.HANDLERS | navigation.HANDLERS | services.HANDLERS


def execute(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult | None:
    """Do what a command says, as far as it can be done, and tell the result. None: it gets no answer."""
    if command.id in services.UNANSWERED:
        return None
    handler = _HANDLERS.get(command.id)
    return MavResult.UNSUPPORTED if handler is None else handler(command, autopilot, wire)
