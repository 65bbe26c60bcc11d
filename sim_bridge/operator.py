"""The operator at his ground station: what he asks for, as the commands his program sends."""

from __future__ import annotations

import math

from companion.world.events import Operator, Order
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander.commander import FORCE, Result
from sim_bridge.autopilot.commands import Command, execute
from sim_bridge.autopilot.commands.modes import (
    ARM_DISARM,
    FLIGHT_TERMINATION,
    LAND,
    RETURN_TO_LAUNCH,
    SET_MODE,
    TAKEOFF,
)
from sim_bridge.autopilot.commands.parts import GROUND_STATION_COMPONENT
from sim_bridge.strangers import MODES

GROUND_STATION_SYSTEM = 255
CUSTOM_MODE_ENABLED = 1.0
NOT_GIVEN = math.nan
COMMANDS: dict[Order, tuple[int, tuple[float, ...]]] = {
    Order.ARM: (ARM_DISARM, (1.0,)),
    Order.DISARM: (ARM_DISARM, (0.0,)),
    Order.KILL: (ARM_DISARM, (0.0, FORCE)),
    Order.TERMINATE: (FLIGHT_TERMINATION, (1.0,)),
    Order.LAND: (LAND, (NOT_GIVEN,) * 7),
    Order.RETURN: (RETURN_TO_LAUNCH, (NOT_GIVEN,) * 7),
    Order.TAKE_OFF: (TAKEOFF, (NOT_GIVEN,) * 7),
}
"""MAV_CMD and its parameters; every other order is a mode (DO_SET_MODE)."""


class _OwnLink:
    """The operator's link, of which nothing is asked here."""

    def request(self, msgid: int, argument: float) -> bool:
        return False

    def tell_interval(self, msgid: int) -> None:
        return None

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        return False


def command_of(order: Order) -> Command:
    """The command of an order, as a ground station sends it."""
    if order in COMMANDS:
        msgid, parameters = COMMANDS[order]
    else:
        mode = MODES[order]
        msgid, parameters = SET_MODE, (CUSTOM_MODE_ENABLED, float(mode.main), float(mode.sub))
    a, b, c, d, e, f, g = (*parameters, *(0.0,) * (7 - len(parameters)))
    return Command(msgid, (a, b, c, d, e, f, g), GROUND_STATION_SYSTEM, GROUND_STATION_COMPONENT)


def ask(autopilot: Autopilot, event: Operator) -> Result | None:
    """Have the vehicle do what its operator asks for; its answer."""
    return execute(command_of(event.order), autopilot, _OwnLink())
