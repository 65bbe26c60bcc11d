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
    MAV_CMD_DO_SET_ROI_LOCATION,
    MAV_CMD_NAV_DELAY,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    MAV_CMD_NAV_ROI,
    MAV_FRAME_GLOBAL,
    MAV_FRAME_GLOBAL_INT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
    MAV_FRAME_MISSION,
    MavMissionResult,
)

ITEM, ITEM_INT = message("MISSION_ITEM"), message("MISSION_ITEM_INT")
Four = tuple[float, float, float, float]

NOT_GIVEN = (2**31 - 1, -(2**31))
"""What whole-number coordinates say where there is none: by the specification, and what a cast of NaN gives."""

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
        return self.frame != MAV_FRAME_MISSION and self.command in _PLACES


_PLACES = {16, 17, 19, 21, 22, 31, 84, 85}
"""MAV_CMD of items that say where to fly."""
_WITH_A_PLACE = {
    16, 17, 19, 21, 22, 31, 80, 84, 85, 195, 201, 212, 400, 4501, 5000, 5001, 5002, 5003, 5004, 5100,
}  # fmt: skip
_WITHOUT_A_PLACE = {
    20, 80, 93, 112, 177, 178, 179, 187, 189, 196, 197, 200, 201, 202, 203, 204, 205, 206, 211, 212, 214, 260, 400, 530,
    532, 534, 1000, 1001, 2000, 2001, 2003, 2500, 2501, 3000, 42600,
}  # fmt: skip
TAKES: dict[int, int] = {
    16: 0x7B, 17: 0x7C, 19: 0x7F, 20: 0x00, 21: 0x7B, 22: 0x79, 31: 0x7B, 80: 0x77, 84: 0x78, 85: 0x7C, 93: 0x0F,
    112: 0x01, 114: 0x01, 176: 0x07, 177: 0x03, 178: 0x07, 179: 0x7F, 189: 0x70, 195: 0x70, 196: 0x01, 197: 0x01,
    201: 0x07, 206: 0x0F, 211: 0x03, 212: 0x03, 214: 0x07, 224: 0x00, 400: 0x03, 420: 0x0F, 530: 0x03, 532: 0x07,
    534: 0x07, 611: 0x00, 2000: 0x0F, 2001: 0x01, 2003: 0x0F, 2500: 0x07, 2501: 0x03, 3000: 0x03, 4501: 0x00,
    5000: 0x70, 5001: 0x31, 5002: 0x31, 5003: 0x31, 5004: 0x31, 5100: 0x70, 42600: 0x0F,
}  # fmt: skip
"""Which parameters a command takes, one bit each; another that is given is refused. Commands not here take all."""
_KEEPS: dict[int, tuple[int, ...]] = {
    16: (0, 1), 17: (2,), 19: (0, 1, 2, 3), 21: (0, 1), 31: (0, 1, 3), 5001: (0,), 5002: (0,), 5003: (0,), 5004: (0,),
}  # fmt: skip
"""Which of the first four parameters of a command with a place are kept; yaw apart."""
NOT_A_MISSION = {5001, 5002, 5003, 5004, 5100}
"""MAV_CMD of fences and rally points."""
_YAWS = {16, 17, 21, 22, 84, 85}
"""MAV_CMD of items whose fourth parameter is a heading."""
_FLAGS = {19: (1, 3), 31: (0, 3)}
"""Parameters that are kept as yes or no."""


def read(frame: Frame) -> Item | MavMissionResult:
    """The item of a MISSION_ITEM or MISSION_ITEM_INT, or what PX4 refuses it with."""
    said = frame.format.named(frame.values)
    whole = frame.format is ITEM_INT
    command, kind = said["command"], said["frame"]
    params: Four = (said["param1"], said["param2"], said["param3"], said["param4"])
    x, y, z = said["x"], said["y"], said["z"]
    if kind in (MAV_FRAME_GLOBAL, MAV_FRAME_GLOBAL_RELATIVE_ALT) or (
        whole and kind in (MAV_FRAME_GLOBAL_INT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
    ):
        stray = _stray(command, params, (x, y) if whole else (float(x), float(y)), z, whole)
        if stray:
            return MavMissionResult(MavMissionResult.INVALID_PARAM1 + stray - 1)
        if command not in _WITH_A_PLACE or (command in (80, 201) and int(_finite(params[0])) not in (0, 3)):
            return MavMissionResult.UNSUPPORTED if command not in _WITH_A_PLACE else MavMissionResult.INVALID_PARAM1
        stored = (
            MAV_FRAME_GLOBAL_RELATIVE_ALT
            if kind in (MAV_FRAME_GLOBAL_RELATIVE_ALT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
            else MAV_FRAME_GLOBAL
        )
        scale = 1e-7 if whole else 1.0
        return Item(command, stored, said["autocontinue"], _kept(command, params), x * scale, y * scale, z)
    if kind != MAV_FRAME_MISSION:
        return MavMissionResult.UNSUPPORTED_FRAME
    fifth, sixth = (math.nan if whole and value in NOT_GIVEN else float(value) for value in (x, y))
    stray = _stray(command, params, (fifth, sixth), z, False)
    if stray:
        return MavMissionResult(MavMissionResult.INVALID_PARAM1 + stray - 1)
    if command not in _WITHOUT_A_PLACE:
        return MavMissionResult.UNSUPPORTED
    if command in (80, 201) and int(_finite(params[0])) not in (0, 1, 2):
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
    takes = TAKES.get(command)
    if takes is None:
        return 0
    given = [not math.isnan(value) and value != 0.0 for value in params]
    given += [value not in NOT_GIVEN if whole else not math.isnan(value) and value != 0.0 for value in place]
    given.append(not math.isnan(z) and z != 0.0)
    for i, is_given in enumerate(given):
        if is_given and not takes >> i & 1:
            return i + 1
    return 0


def _kept(command: int, params: Four) -> Four:
    """The first four parameters of a command with a place, as PX4 gives them back."""
    kept = [0.0, 0.0, 0.0, 0.0]
    for i in _KEEPS.get(command, ()):
        flag = i in _FLAGS.get(command, ())
        kept[i] = float(params[i] > 0.0) if flag else params[i]
    if command in (MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION):
        kept[0] = float(int(_finite(params[0]) + 0.5) & 0xFFFF)
    if command in _YAWS:
        kept[3] = params[3] % 360.0 if math.isfinite(params[3]) else math.nan
    if command in (MAV_CMD_NAV_ROI, MAV_CMD_DO_SET_ROI, MAV_CMD_DO_SET_ROI_LOCATION):
        kept[0] = params[0] if command != MAV_CMD_DO_SET_ROI_LOCATION else 0.0
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
