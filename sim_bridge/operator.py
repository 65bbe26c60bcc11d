"""The operator at his ground station: what he asks for, as the commands his program sends."""

from __future__ import annotations

import math

from companion.mavlink_common import (
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_FLIGHTTERMINATION,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_RETURN_TO_LAUNCH,
    MAV_CMD_NAV_TAKEOFF,
    MAV_COMP_ID_MISSIONPLANNER,
    MavResult,
)
from companion.world.events import Operator, Order
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander.commander import FORCE
from sim_bridge.autopilot.commands import Command, execute
from sim_bridge.strangers import MODES

GROUND_STATION_SYSTEM = 255
"""QGroundControl's system id."""
CUSTOM_MODE_ENABLED = 1.0
"""MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, DO_SET_MODE's first parameter."""
NOT_GIVEN = math.nan
COMMANDS: dict[Order, tuple[int, tuple[float, ...]]] = {
    Order.ARM: (MAV_CMD_COMPONENT_ARM_DISARM, (1.0,)),
    Order.DISARM: (MAV_CMD_COMPONENT_ARM_DISARM, (0.0,)),
    Order.KILL: (MAV_CMD_COMPONENT_ARM_DISARM, (0.0, FORCE)),
    Order.TERMINATE: (MAV_CMD_DO_FLIGHTTERMINATION, (1.0,)),
    Order.LAND: (MAV_CMD_NAV_LAND, (NOT_GIVEN,) * 7),
    Order.RETURN: (MAV_CMD_NAV_RETURN_TO_LAUNCH, (NOT_GIVEN,) * 7),
    Order.TAKE_OFF: (MAV_CMD_NAV_TAKEOFF, (NOT_GIVEN,) * 7),
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
        msgid, parameters = MAV_CMD_DO_SET_MODE, (CUSTOM_MODE_ENABLED, float(mode.main), float(mode.sub))
    a, b, c, d, e, f, g = (*parameters, *(0.0,) * (7 - len(parameters)))
    return Command(msgid, (a, b, c, d, e, f, g), GROUND_STATION_SYSTEM, MAV_COMP_ID_MISSIONPLANNER)


def ask(autopilot: Autopilot, event: Operator) -> MavResult | None:
    """Have the vehicle do what its operator asks for; its answer."""
    return execute(command_of(event.order), autopilot, _OwnLink())
