"""The parameter protocol on one link: read, set, list, and the second telling of what was set.

A set is answered at once; a little later every link tells every value that changed, the asker's too.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from companion.mavlink.codec import MAGIC_V2, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import (
    MAV_PARAM_TYPE_INT32,
    MAV_PARAM_TYPE_REAL32,
    MAV_PARAM_TYPE_UINT32,
)
from sim_bridge.autopilot.parameters import Parameters

READ, LIST, SET = message("PARAM_REQUEST_READ"), message("PARAM_REQUEST_LIST"), message("PARAM_SET")
_ERROR = message("PARAM_ERROR")
_VALUE = message("PARAM_VALUE")
_RAW_VALUE = Format(_VALUE.id, _VALUE.name, "<4sHH16sB", dict.fromkeys(_VALUE.fields, 0), _VALUE.crc_extra)
"""PARAM_VALUE with its value as bytes: an integer's bits in a float may be a NaN that arithmetic would change."""
HASH = "_HASH_CHECK"
HASH_INDEX = 65535
"""The index of a parameter outside the list."""
DOES_NOT_EXIST = 1  # MAV_PARAM_ERROR_DOES_NOT_EXIST
READ_ONLY = 5  # MAV_PARAM_ERROR_READ_ONLY
TYPE_UNSUPPORTED = 6  # MAV_PARAM_ERROR_TYPE_UNSUPPORTED
TYPE_MISMATCH = 7  # MAV_PARAM_ERROR_TYPE_MISMATCH
BURST = 10
"""How many values of a list go out together."""
BROADCAST_AFTER_US = 10_000
"""us from a set to the telling on all links."""


class ParameterLink:
    """One link's side, of the vehicle with system id ``system``. ``send``: queues a message."""

    def __init__(
        self, parameters: Parameters, system: int, send: Callable[[Format, tuple[Value, ...]], None]
    ) -> None:  # fmt: skip
        self._parameters = parameters
        self._system = system
        self._send = send
        self._listed: int | None = None  # the index that is told next; -1 the hash
        self._told = 0  # how many of the changes have been told
        self._changed_at_us: int | None = None

    def poll(self, now_us: int) -> None:
        """Send the next of a list and what has changed. To be called every 10 ms."""
        if self._listed is not None:
            self._list()
        changes = self._parameters.changes
        if len(changes) > self._told:
            if self._changed_at_us is None:
                self._changed_at_us = now_us
            elif now_us - self._changed_at_us >= BROADCAST_AFTER_US:
                for name in dict.fromkeys(changes[self._told :]):
                    self.tell(name)
                self._told = len(changes)
                self._changed_at_us = None

    def send_requested(self, frame: Frame) -> None:
        """PARAM_REQUEST_READ: by name, or by index where that is not negative."""
        if not self._is_ours(frame):
            return
        index: int = frame.values[_at(READ, "param_index")]
        if index >= 0:
            names = self._parameters.names
            if index < len(names):
                self.tell(names[index])
            else:
                self._refuse(frame, DOES_NOT_EXIST, "", index)
            return
        name = _name(frame.values[_at(READ, "param_id")])
        if name == HASH:
            self._tell_hash()
        elif name in self._parameters:
            self.tell(name)
        else:
            self._refuse(frame, DOES_NOT_EXIST, name)

    def list(self, frame: Frame) -> None:
        """PARAM_REQUEST_LIST: the hash and then everything; a second request starts over without the hash."""
        if self._is_ours(frame):
            self._listed = -1 if self._listed is None else 0

    def change(self, frame: Frame) -> None:
        """PARAM_SET: the type must be the parameter's own; any value is taken."""
        if not self._is_ours(frame):
            return
        name, kind = _name(frame.values[_at(SET, "param_id")]), frame.values[_at(SET, "param_type")]
        if name == HASH:  # "I have them all": the list ends
            self._listed = None
            self._refuse(frame, READ_ONLY, name)
        elif name not in self._parameters:
            self._refuse(frame, DOES_NOT_EXIST, name)
        elif kind not in (MAV_PARAM_TYPE_INT32, MAV_PARAM_TYPE_REAL32):
            self._refuse(frame, TYPE_UNSUPPORTED, name)
        elif (kind == MAV_PARAM_TYPE_INT32) != self._parameters.is_integer(name):
            self._refuse(frame, TYPE_MISMATCH, name)
        else:
            self._parameters.unpack(name, _value_bytes(frame))
            self.tell(name)

    def _list(self) -> None:
        names = self._parameters.names
        for _ in range(BURST):
            if self._listed is None:
                return
            if self._listed < 0:
                self._tell_hash()
            else:
                self.tell(names[self._listed])
            self._listed = self._listed + 1 if self._listed + 1 < len(names) else None

    def tell(self, name: str) -> None:
        """Send a value."""
        parameters = self._parameters
        kind = MAV_PARAM_TYPE_INT32 if parameters.is_integer(name) else MAV_PARAM_TYPE_REAL32
        self._value(name, parameters.packed(name), kind, parameters.index[name])

    def _tell_hash(self) -> None:
        self._value(HASH, struct.pack("<I", self._parameters.hash), MAV_PARAM_TYPE_UINT32, HASH_INDEX)

    def _value(self, name: str, raw: bytes, kind: int, index: int) -> None:
        self._send(_RAW_VALUE, (raw, len(self._parameters.names), index, name.encode("ascii"), kind))

    def _refuse(self, frame: Frame, error: int, name: str, index: int = -1) -> None:
        self._send(_ERROR, _ERROR.values(
            target_system=frame.system, target_component=frame.component, param_id=name, param_index=index, error=error,
        ))  # fmt: skip

    def _is_ours(self, frame: Frame) -> bool:
        """Unlike commands, parameter messages must name the system."""
        values, where = frame.values, frame.format.where
        return values[where["target_system"]] == self._system and values[where["target_component"]] in (0, 1)


def _at(fmt: Format, field: str) -> int:
    where = fmt.where[field]
    assert isinstance(where, int)
    return where


def _value_bytes(frame: Frame) -> bytes:
    """The first field of a PARAM_SET as it came, for the same reason."""
    payload = 10 if frame.raw[0] == MAGIC_V2 else 6
    return frame.raw[payload : payload + 4]


def _name(raw: bytes) -> str:
    return raw.split(b"\0")[0].decode("ascii", "replace")
