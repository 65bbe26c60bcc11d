"""Mission items as PX4 takes, keeps and gives them back."""

from __future__ import annotations

import math
import struct
import zlib
from typing import NamedTuple

from companion.mavlink.codec import MAGIC_V2, Frame
from companion.mavlink.dialect import Value, message
from companion.mavlink_common import (
    MAV_CMD_CONDITION_DELAY,
    MAV_CMD_DO_SET_ROI,
    MAV_CMD_NAV_DELAY,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    MAV_CMD_NAV_ROI,
    MAV_FRAME_GLOBAL,
    MAV_FRAME_GLOBAL_INT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
    MAV_FRAME_MISSION,
    MAV_ROI_LOCATION,
    MAV_ROI_NONE,
    MAV_ROI_WPINDEX,
    MAV_ROI_WPNEXT,
    MavMissionResult,
)
from sim_bridge.autopilot.missions.item_table import ITEMS, NOT_AN_ITEM

ITEM, ITEM_INT = message("MISSION_ITEM"), message("MISSION_ITEM_INT")
Four = tuple[float, float, float, float]

NOT_GIVEN = (2**31 - 1, -(2**31))
"""What whole-number coordinates say where there is none: by the specification, and what a cast of NaN gives."""

ROI = (MAV_CMD_NAV_ROI, MAV_CMD_DO_SET_ROI)
"""Their first parameter is a MAV_ROI, and is kept."""

NUMBERS = 28
"""Bytes at the beginning of an item on the wire: its seven parameters."""


class Item(NamedTuple):
    """An item. ``frame``: GLOBAL, RELATIVE (to home's height) or MISSION (no place).

    ``x``, ``y``: latitude and longitude in degrees, or parameters 5 and 6; ``z``: m, or parameter 7.
    """

    command: int
    frame: int
    autocontinue: int
    params: Four
    x: float
    y: float
    z: float

    @property
    def has_coordinates(self) -> bool:
        """Whether ``x`` and ``y`` are degrees."""
        return self.frame != MAV_FRAME_MISSION

    @property
    def has_place(self) -> bool:
        """Whether its coordinates are somewhere to fly to."""
        return self.frame != MAV_FRAME_MISSION and ITEMS.get(self.command, NOT_AN_ITEM).flown_to


def read(frame: Frame) -> Item | MavMissionResult:
    """The item of a MISSION_ITEM or MISSION_ITEM_INT, or what PX4 refuses it with."""
    said = frame.format.named(frame.values)
    whole = frame.format is ITEM_INT
    command, kind = said["command"], said["frame"]
    row = ITEMS.get(command, NOT_AN_ITEM)
    params: Four = (said["param1"], said["param2"], said["param3"], said["param4"])
    x, y, z = said["x"], said["y"], said["z"]
    if kind in (MAV_FRAME_GLOBAL, MAV_FRAME_GLOBAL_RELATIVE_ALT) or (
        whole and kind in (MAV_FRAME_GLOBAL_INT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
    ):
        stray = _stray(command, params, (x, y) if whole else (float(x), float(y)), z, whole)
        if stray:
            return MavMissionResult(MavMissionResult.INVALID_PARAM1 + stray - 1)
        if not row.with_place:
            return MavMissionResult.UNSUPPORTED
        if command in ROI and int(_finite(params[0])) not in (MAV_ROI_NONE, MAV_ROI_LOCATION):
            return MavMissionResult.INVALID_PARAM1
        stored = (
            MAV_FRAME_GLOBAL_RELATIVE_ALT
            if kind in (MAV_FRAME_GLOBAL_RELATIVE_ALT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
            else MAV_FRAME_GLOBAL
        )
        scale = 1e-7 if whole else 1.0
        return Item(command, stored, said["autocontinue"], _stored_parameters(command, params), x * scale, y * scale, z)
    if kind != MAV_FRAME_MISSION:
        return MavMissionResult.UNSUPPORTED_FRAME
    fifth, sixth = (math.nan if whole and value in NOT_GIVEN else float(value) for value in (x, y))
    stray = _stray(command, params, (fifth, sixth), z, False)
    if stray:
        return MavMissionResult(MavMissionResult.INVALID_PARAM1 + stray - 1)
    if not row.without_place:
        return MavMissionResult.UNSUPPORTED
    if command in ROI and int(_finite(params[0])) not in (MAV_ROI_NONE, MAV_ROI_WPNEXT, MAV_ROI_WPINDEX):
        return MavMissionResult.INVALID_PARAM1
    kept = MAV_CMD_NAV_DELAY if command == MAV_CMD_CONDITION_DELAY else command
    return Item(kept, MAV_FRAME_MISSION, said["autocontinue"], params, _single(x), _single(y), z)


def of_a_fence(item: Item) -> Item:
    """An item as it is kept in a fence, where heights and the way on mean nothing."""
    return item._replace(frame=MAV_FRAME_GLOBAL if item.has_coordinates else item.frame, autocontinue=0)


def values(item: Item, whole: bool, others: dict[str, Value]) -> tuple[Value, ...]:
    """The wire values of an item. ``others``: target, seq, current and mission type."""
    frame, x, y = item.frame, item.x, item.y
    if frame != MAV_FRAME_MISSION and whole:
        frame = MAV_FRAME_GLOBAL_RELATIVE_ALT_INT if frame == MAV_FRAME_GLOBAL_RELATIVE_ALT else MAV_FRAME_GLOBAL_INT
        x, y = x * 1e7, y * 1e7
    p1, p2, p3, p4 = item.params
    return (ITEM_INT if whole else ITEM).values(
        command=item.command, frame=frame, autocontinue=item.autocontinue, param1=p1, param2=p2, param3=p3, param4=p4,
        x=_int32(x) if whole else x, y=_int32(y) if whole else y, z=item.z, **others,
    )  # fmt: skip


def checksum(frame: Frame, before: int) -> int:
    """The list's id after one more item: PX4's CRC-32 over what came on the wire, without its inversions."""
    said = frame.format.named(frame.values)
    head = struct.pack("<BHB", said["frame"], said["command"], said["autocontinue"])
    payload = 10 if frame.raw[0] == MAGIC_V2 else 6
    body = frame.raw[payload : payload + min(NUMBERS, frame.raw[1])].ljust(NUMBERS, b"\0")
    return zlib.crc32(head + body, before ^ 0xFFFFFFFF) ^ 0xFFFFFFFF


def _stray(command: int, params: Four, place: tuple[Value, Value], z: float, whole: bool) -> int:
    """The first parameter, counted from 1, that is given and not taken; 0: none."""
    takes = ITEMS.get(command, NOT_AN_ITEM).takes
    given = [not math.isnan(value) and value != 0.0 for value in params]
    given += [value not in NOT_GIVEN if whole else not math.isnan(value) and value != 0.0 for value in place]
    given.append(not math.isnan(z) and z != 0.0)
    for i, is_given in enumerate(given):
        if is_given and not takes >> i & 1:
            return i + 1
    return 0


def _stored_parameters(command: int, params: Four) -> Four:
    """The first four parameters of a command with a place, as PX4 gives them back."""
    kept = [0.0, 0.0, 0.0, 0.0]
    row = ITEMS.get(command, NOT_AN_ITEM)
    for i in row.kept:
        kept[i] = float(params[i] > 0.0) if i in row.flags else params[i]
    if command in (MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION):
        kept[0] = float(int(_finite(params[0]) + 0.5) & 0xFFFF)
    if row.has_yaw:
        kept[3] = params[3] % 360.0 if math.isfinite(params[3]) else math.nan
    if command in ROI:
        kept[0] = params[0]
    return (kept[0], kept[1], kept[2], kept[3])


def _single(value: float) -> float:
    """Rounded to single precision, in which PX4 keeps these."""
    (rounded,) = struct.unpack("<f", struct.pack("<f", value))
    return float(rounded)


def _finite(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _int32(value: float) -> int:
    """A cast, as PX4's processor makes it."""
    return round(value) if math.isfinite(value) and -(2.0**31) <= round(value) < 2.0**31 else -(2**31)
