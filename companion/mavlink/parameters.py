"""The vehicle's parameters over MAVLink: read by name, set and set back, without sockets or clocks.

PX4 sends integers as their bits in the field of a float. A name it does not know is answered by PARAM_ERROR, by older
versions not at all; both leave None.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from companion.mavlink.codec import MAGIC_V2, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import (
    MAV_PARAM_TYPE_INT8,
    MAV_PARAM_TYPE_INT16,
    MAV_PARAM_TYPE_INT32,
    MAV_PARAM_TYPE_REAL32,
    MAV_PARAM_TYPE_UINT8,
    MAV_PARAM_TYPE_UINT16,
    MAV_PARAM_TYPE_UINT32,
)
from companion.vehicle import Tuning

READ, SET, VALUE, ERROR = (
    message("PARAM_REQUEST_READ"), message("PARAM_SET"), message("PARAM_VALUE"), message("PARAM_ERROR"),
)  # fmt: skip
RAW_SET = Format(SET.id, SET.name, "<4sBB16sB", dict.fromkeys(SET.fields, 0), SET.crc_extra)
"""PARAM_SET with its value as bytes: an integer's bits in a float may be a NaN that arithmetic would change."""
WANTED = frozenset({VALUE.id, ERROR.id})

INT_TYPES = {
    MAV_PARAM_TYPE_UINT8: "B", MAV_PARAM_TYPE_INT8: "b", MAV_PARAM_TYPE_UINT16: "H", MAV_PARAM_TYPE_INT16: "h",
    MAV_PARAM_TYPE_UINT32: "I", MAV_PARAM_TYPE_INT32: "i",
}  # fmt: skip
"""MAV_PARAM_TYPE to struct's codes."""
RETRY_AFTER = 0.25
"""s without an answer to a parameter's request (engineering choice)."""
TRIES = 8
"""A name that nobody answers is given up after this many requests, RETRY_AFTER s apart."""

TUNING: dict[str, str] = {
    "roll_p": "MC_ROLL_P",
    "pitch_p": "MC_PITCH_P",
    "yaw_p": "MC_YAW_P",
    "roll_rate_p": "MC_ROLLRATE_P",
    "roll_rate_k": "MC_ROLLRATE_K",
    "yaw_rate_p": "MC_YAWRATE_P",
    "yaw_rate_i": "MC_YAWRATE_I",
    "yaw_rate_k": "MC_YAWRATE_K",
    "smoothing": "MC_REF_W_N",
    "hover_thrust": "MPC_THR_HOVER",
    "thrust_curve": "THR_MDL_FAC",
    "offboard_loss_time": "COM_OF_LOSS_T",
    "offboard_loss_action": "COM_OBL_RC_ACT",
    "fail_roll": "FD_FAIL_R",
    "fail_pitch": "FD_FAIL_P",
    "battery_low": "BAT_LOW_THR",
    "battery_critical": "BAT_CRIT_THR",
    "fence_radius": "GF_MAX_HOR_DIST",
    "fence_height": "GF_MAX_VER_DIST",
}
"""Which parameter each field of ``Tuning`` is."""
IN_DEGREES = frozenset({"fail_roll", "fail_pitch"})


class ParameterValue(NamedTuple):
    """A parameter as the vehicle holds it. ``kind``: MAV_PARAM_TYPE."""

    value: float
    kind: int


@dataclass(slots=True)
class _Asked:
    at: float
    tries: int
    wanted: float | None  # to be set; None: only to be read


@dataclass(slots=True)
class Parameters:
    """What one vehicle's parameters are. ``send`` queues a message; ``values``: None for a name it does not know."""

    send: Callable[[Format, tuple[Value, ...]], None]
    values: dict[str, ParameterValue | None] = field(default_factory=dict)
    _asked: dict[str, _Asked] = field(default_factory=dict)
    _system: int = 0

    @property
    def settled(self) -> bool:
        """Whether everything asked for is answered or given up."""
        return not self._asked

    def value(self, name: str) -> float | None:
        """The value as last told; an integer's is whole."""
        known = self.values.get(name)
        return None if known is None else known.value

    def ask(self, names: Iterable[str], system: int, now: float) -> None:
        """Read parameters of a vehicle."""
        self._system = system
        for name in names:
            self._request(name, None, 1, now)

    def change(self, name: str, value: float, now: float) -> None:
        """Set a parameter that was read before; asked for until the vehicle tells the new value."""
        known = self.values.get(name)
        if known is not None and not _same(known, value):
            self._request(name, value, 1, now)

    def receive(self, frame: Frame) -> None:
        """Take in PARAM_VALUE and PARAM_ERROR of the vehicle."""
        fmt = frame.format
        if fmt is VALUE:
            name, parameter = _decode(frame)
            asked = self._asked.get(name)
            if parameter is None or (asked is None and name not in self.values):
                return  # nobody asked
            self.values[name] = parameter
            if asked is not None and (asked.wanted is None or _same(parameter, asked.wanted)):
                del self._asked[name]
        elif fmt is ERROR:
            name = _text(ERROR.named(frame.values)["param_id"])
            asked = self._asked.pop(name, None)
            if asked is not None and asked.wanted is None:
                self.values[name] = None

    def on_timer(self, now: float) -> None:
        """Ask again what was not answered."""
        for name, asked in list(self._asked.items()):
            if now < asked.at + RETRY_AFTER:
                continue
            if asked.tries < TRIES:
                self._request(name, asked.wanted, asked.tries + 1, now)
            else:
                del self._asked[name]
                if asked.wanted is None:
                    self.values.setdefault(name, None)

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        if not self._asked:
            return math.inf
        return min(asked.at + RETRY_AFTER for asked in self._asked.values())

    def tuning(self) -> Tuning:
        """What of it matters to the law and the guards, in our units."""
        values: dict[str, float] = {}
        for name, parameter in TUNING.items():
            value = self.value(parameter)
            if value is not None:
                values[name] = math.radians(value) if name in IN_DEGREES else value
        return Tuning(**values)  # type: ignore[arg-type]  # integers are whole already

    def _request(self, name: str, wanted: float | None, tries: int, now: float) -> None:
        self._asked[name] = _Asked(now, tries, wanted)
        target = (self._system, 1)
        if wanted is None:
            self.send(READ, READ.values(
                target_system=target[0], target_component=target[1], param_id=name, param_index=-1
            ))  # fmt: skip
            return
        known = self.values[name]
        assert known is not None
        raw = struct.pack("<f", wanted) if known.kind == MAV_PARAM_TYPE_REAL32 else struct.pack("<i", round(wanted))
        self.send(RAW_SET, (raw, *target, name.encode("ascii"), known.kind))


def _decode(frame: Frame) -> tuple[str, ParameterValue | None]:
    """Name and value of a PARAM_VALUE, by its own type; None for a type PX4 does not use and for what is no number."""
    _, _, _, name, kind = frame.values
    payload = 10 if frame.raw[0] == MAGIC_V2 else 6
    raw = frame.raw[payload : payload + 4]
    code = "f" if kind == MAV_PARAM_TYPE_REAL32 else INT_TYPES.get(kind)
    if code is None:
        return _text(name), None
    (value,) = struct.unpack("<" + code, raw[: struct.calcsize(code)])
    return _text(name), ParameterValue(value, kind) if math.isfinite(value) else None


def _same(parameter: ParameterValue, value: float) -> bool:
    return math.isclose(parameter.value, value, rel_tol=1e-6, abs_tol=1e-9)


def _text(raw: bytes | str) -> str:
    return raw if isinstance(raw, str) else raw.split(b"\0")[0].decode("ascii", "replace")
