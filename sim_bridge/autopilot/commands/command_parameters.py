"""Which parameters a command takes, and how COMMAND_INT gives a place, as PX4 looks at them before anything else."""

from __future__ import annotations

import math

from companion import mavlink_common as mav
from sim_bridge.autopilot.commands.parts import NOT_GIVEN
from sim_bridge.autopilot.missions.item_table import ITEMS

COMMANDS_TAKE: dict[int, int] = {command: row.takes for command, row in ITEMS.items()} | {
    mav.MAV_CMD_NAV_VTOL_TAKEOFF: 0x7C,
    mav.MAV_CMD_NAV_VTOL_LAND: 0x7F,
    mav.MAV_CMD_DO_SET_ROI_LOCATION: 0x71,
    mav.MAV_CMD_DO_SET_MISSION_CURRENT: 0x03,
    mav.MAV_CMD_DO_SET_GLOBAL_ORIGIN: 0x70,
    mav.MAV_CMD_NAV_FENCE_RETURN_POINT: 0x00,
    mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: 0x01,
    mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: 0x01,
    mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: 0x01,
    mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: 0x01,
    mav.MAV_CMD_NAV_RALLY_POINT: 0x00,
}
"""One bit a parameter: as of an item, but for these. A command that is given another is denied; those not here take
all."""
WITH_A_PLACE = frozenset({
    mav.MAV_CMD_NAV_LAND, mav.MAV_CMD_NAV_TAKEOFF, mav.MAV_CMD_NAV_LAND_LOCAL, mav.MAV_CMD_DO_ORBIT,
    mav.MAV_CMD_DO_FIGURE_EIGHT, mav.MAV_CMD_NAV_ROI, mav.MAV_CMD_NAV_VTOL_TAKEOFF, mav.MAV_CMD_DO_SET_HOME,
    mav.MAV_CMD_DO_SET_ACTUATOR, mav.MAV_CMD_DO_LAND_START, mav.MAV_CMD_DO_REPOSITION,
    mav.MAV_CMD_DO_SET_ROI_LOCATION, mav.MAV_CMD_DO_SET_ROI, mav.MAV_CMD_DO_SET_GLOBAL_ORIGIN,
    mav.MAV_CMD_PAYLOAD_PREPARE_DEPLOY, mav.MAV_CMD_EXTERNAL_POSITION_ESTIMATE,
})  # fmt: skip
"""Commands whose COMMAND_INT carries a place."""
LOCAL_FRAMES = frozenset({
    mav.MAV_FRAME_LOCAL_NED, mav.MAV_FRAME_LOCAL_ENU, mav.MAV_FRAME_LOCAL_OFFSET_NED, mav.MAV_FRAME_BODY_NED,
    mav.MAV_FRAME_BODY_OFFSET_NED, mav.MAV_FRAME_BODY_FRD, mav.MAV_FRAME_LOCAL_FRD, mav.MAV_FRAME_LOCAL_FLU,
})  # fmt: skip
"""Frames in which x and y are metres times 1e4."""


def stray(command: int, parameters: tuple[float, ...]) -> bool:
    """Whether a parameter is given that the command does not take."""
    takes = COMMANDS_TAKE.get(command)
    if takes is None:
        return False
    return any(not math.isnan(x) and x != 0.0 and not takes >> i & 1 for i, x in enumerate(parameters))


def place_given(command: int, frame: int, x: int, y: int) -> tuple[float, float]:
    """Parameters 5 and 6 of a COMMAND_INT."""
    if x == y == NOT_GIVEN:
        return (math.nan, math.nan)
    if command not in WITH_A_PLACE:
        return (float(x), float(y))
    scale = 1e-4 if frame in LOCAL_FRAMES else 1e-7
    return (x * scale, y * scale)
