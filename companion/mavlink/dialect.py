"""The messages we can read and write: pymavlink's generated tables, and the few messages of PX4 they lack.

pymavlink's wheel is generated from ArduPilot's fork of the definitions. It has no EVENT, PARAM_ERROR, ESC_STATUS and
others, its SET_ATTITUDE_TARGET lacks the extension field ``thrust_body`` and its mission messages the opaque ids; those
are declared below from the MAVLink specification, and their CRC extras are computed by its rule.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Mapping
from typing import Any

from fastcrc.crc16 import mcrf4xx
from pymavlink.dialects.v20 import development as _pymavlink

Value = Any  # int | float | bytes: what struct yields. A union here would put a cast on every arithmetic line.

_TYPE_CODES = {
    "char": "c",
    "uint8_t": "B",
    "int8_t": "b",
    "uint16_t": "H",
    "int16_t": "h",
    "uint32_t": "I",
    "int32_t": "i",
    "uint64_t": "Q",
    "int64_t": "q",
    "float": "f",
    "double": "d",
}


FLOAT32_MAX = 3.4028234663852886e38
"""The largest finite number of IEEE 754 binary32."""
_ONE_KIND = re.compile(r"(\d*)([a-zA-Z])")


class Format:
    """One message on the wire.

    ``fields`` are in wire order. ``values`` means the flat tuple that struct packs and unpacks: one entry a scalar, one
    entry an array element, one ``bytes`` a string. ``where`` gives each field's index, or slice for an array, in it.
    """

    __slots__ = (
        "codes",
        "crc_extra",
        "crc_extra_byte",
        "fields",
        "id",
        "name",
        "pack",
        "size",
        "unpack",
        "where",
        "zero",
    )

    def __init__(self, msgid: int, name: str, layout: str, fields: Mapping[str, int], crc_extra: int) -> None:
        packer = struct.Struct(layout)
        self.id = msgid
        self.name = name
        self.size = packer.size
        self.crc_extra = crc_extra
        self.crc_extra_byte = bytes([crc_extra])
        self.pack = packer.pack
        self.unpack = packer.unpack
        self.fields = tuple(fields)
        self.where: dict[str, int | slice] = {}
        at = 0
        for field, length in fields.items():
            self.where[field] = slice(at, at + length) if length else at
            at += length or 1
        self.zero = packer.unpack(bytes(packer.size))
        self.codes = "".join(
            code if code == "s" else code * int(count or 1) for count, code in _ONE_KIND.findall(layout)
        )

    def values(self, **fields: Value) -> tuple[Value, ...]:
        """The flat values with ``fields`` set and the rest zero. Strings may be ``str``. KeyError: no such field."""
        flat = list(self.zero)
        for field, value in fields.items():
            where = self.where[field]
            if isinstance(where, slice):
                if len(value) != where.stop - where.start:
                    raise ValueError(f"{self.name}.{field} takes {where.stop - where.start} values, not {len(value)}")
                flat[where] = value
            else:
                flat[where] = value.encode() if isinstance(value, str) else value
        return tuple(flat)

    def clamped(self, values: tuple[Value, ...]) -> tuple[Value, ...]:
        """The values, each the nearest that its type on the wire can hold; NaN is 0 where that is an integer. Not for
        the hot path: ``pack`` says where it is needed."""
        return tuple(_clamped(code, value) for code, value in zip(self.codes, values, strict=True))

    def named(self, values: tuple[Value, ...]) -> dict[str, Value]:
        """The values by field name, arrays as tuples, strings as ``str`` without padding. Not for the hot path."""
        result: dict[str, Value] = {}
        for field in self.fields:
            value: Value = values[self.where[field]]
            result[field] = value.split(b"\0")[0].decode("utf-8", "replace") if isinstance(value, bytes) else value
        return result

    def __repr__(self) -> str:
        return f"<{self.name} {self.id}>"


def _clamped(code: str, value: Value) -> Value:
    if code in "sc":
        return value
    if code in "fd":
        if code == "d" or value != value or -FLOAT32_MAX <= value <= FLOAT32_MAX:
            return value
        return math.copysign(FLOAT32_MAX, value) if math.isfinite(value) else value
    bits = 8 * struct.calcsize(f"<{code}")
    low, high = (0, (1 << bits) - 1) if code.isupper() else (-(1 << bits - 1), (1 << bits - 1) - 1)
    if value != value:
        return 0
    return low if value <= low else high if value >= high else round(value)


def _declare(msgid: int, name: str, fields: str, extensions: str = "") -> Format:
    """A Format from a declaration in XML order, e.g. ``"uint32_t id, uint8_t arguments[40]"``.

    The wire order is by falling size of the type, extensions last and as declared; the CRC extra is that of the name
    and the non-extension fields (MAVLink serialisation guide).
    """

    def parse(text: str) -> list[tuple[str, str, int]]:
        parsed = []
        for item in filter(None, (part.strip() for part in text.split(","))):
            type_name, _, field = item.partition(" ")
            field, _, length = field.strip().partition("[")
            parsed.append((type_name, field, int(length.rstrip("]") or 0)))
        return parsed

    ordered = sorted(parse(fields), key=lambda f: -struct.calcsize(_TYPE_CODES[f[0]]))
    seed = f"{name} "
    for type_name, field, length in ordered:
        seed += f"{type_name} {field} " + (chr(length) if length else "")
    crc = mcrf4xx(seed.encode("latin-1"))
    everything = ordered + parse(extensions)
    layout = "<" + "".join(
        f"{length}s" if type_name == "char" and length else f"{length or ''}{_TYPE_CODES[type_name]}"
        for type_name, _, length in everything
    )
    lengths = {field: 0 if type_name == "char" else length for type_name, field, length in everything}
    return Format(msgid, name, layout, lengths, (crc & 0xFF) ^ (crc >> 8))


def _from_pymavlink(message: Any) -> Format:
    fields = {}
    for field, length, array_length in zip(
        message.ordered_fieldnames, message.lengths, message.array_lengths, strict=True
    ):
        fields[field] = 0 if array_length == 0 or length == 1 else length
    return Format(message.id, message.msgname, message.unpacker.format, fields, message.crc_extra)


FORMATS: dict[int, Format] = {msgid: _from_pymavlink(message) for msgid, message in _pymavlink.mavlink_map.items()}
for _format in (
    _declare(
        8,
        "LINK_NODE_STATUS",
        "uint64_t timestamp, uint8_t tx_buf, uint8_t rx_buf, uint32_t tx_rate, uint32_t rx_rate, "
        "uint16_t rx_parse_err, uint16_t tx_overflows, uint16_t rx_overflows, uint32_t messages_sent, "
        "uint32_t messages_received, uint32_t messages_lost",
    ),
    _declare(
        42,
        "MISSION_CURRENT",
        "uint16_t seq",
        extensions="uint16_t total, uint8_t mission_state, uint8_t mission_mode, uint32_t mission_id, "
        "uint32_t fence_id, uint32_t rally_points_id",
    ),
    _declare(
        44,
        "MISSION_COUNT",
        "uint8_t target_system, uint8_t target_component, uint16_t count",
        extensions="uint8_t mission_type, uint32_t opaque_id",
    ),
    _declare(
        47,
        "MISSION_ACK",
        "uint8_t target_system, uint8_t target_component, uint8_t type",
        extensions="uint8_t mission_type, uint32_t opaque_id",
    ),
    _declare(
        82,
        "SET_ATTITUDE_TARGET",
        "uint32_t time_boot_ms, uint8_t target_system, uint8_t target_component, uint8_t type_mask, float q[4], "
        "float body_roll_rate, float body_pitch_rate, float body_yaw_rate, float thrust",
        extensions="float thrust_body[3]",
    ),
    _declare(
        290,
        "ESC_INFO",
        "uint8_t index, uint64_t time_usec, uint16_t counter, uint8_t count, uint8_t connection_type, uint8_t info, "
        "uint16_t failure_flags[4], uint32_t error_count[4], int16_t temperature[4]",
    ),
    _declare(
        291,
        "ESC_STATUS",
        "uint8_t index, uint64_t time_usec, int32_t rpm[4], float voltage[4], float current[4]",
    ),
    _declare(
        300,
        "PROTOCOL_VERSION",
        "uint16_t version, uint16_t min_version, uint16_t max_version, uint8_t spec_version_hash[8], "
        "uint8_t library_version_hash[8]",
    ),
    _declare(
        345,
        "PARAM_ERROR",
        "uint8_t target_system, uint8_t target_component, char param_id[16], int16_t param_index, uint8_t error",
    ),
    _declare(
        380,
        "TIME_ESTIMATE_TO_TARGET",
        "int32_t safe_return, int32_t land, int32_t mission_next_item, int32_t mission_end, int32_t commanded_action",
    ),
    _declare(
        395,
        "COMPONENT_INFORMATION",
        "uint32_t time_boot_ms, uint32_t general_metadata_file_crc, char general_metadata_uri[100], "
        "uint32_t peripherals_metadata_file_crc, char peripherals_metadata_uri[100]",
    ),
    _declare(397, "COMPONENT_METADATA", "uint32_t time_boot_ms, uint32_t file_crc, char uri[100]"),
    _declare(
        410,
        "EVENT",
        "uint8_t destination_component, uint8_t destination_system, uint32_t id, uint32_t event_time_boot_ms, "
        "uint16_t sequence, uint8_t log_levels, uint8_t arguments[40]",
    ),
    _declare(411, "CURRENT_EVENT_SEQUENCE", "uint16_t sequence, uint8_t flags"),
    _declare(
        412,
        "REQUEST_EVENT",
        "uint8_t target_system, uint8_t target_component, uint16_t first_sequence, uint16_t last_sequence",
    ),
    _declare(
        413,
        "RESPONSE_EVENT_ERROR",
        "uint8_t target_system, uint8_t target_component, uint16_t sequence, uint16_t sequence_oldest_available, "
        "uint8_t reason",
    ),
    _declare(
        514,
        "ESTIMATOR_SENSOR_FUSION_STATUS",
        "uint8_t intended[9], uint8_t active[9], float test_ratio[9]",
    ),
):
    FORMATS[_format.id] = _format

BY_NAME: dict[str, Format] = {fmt.name: fmt for fmt in FORMATS.values()}


def message(name: str) -> Format:
    """The Format called ``name``. KeyError if there is none."""
    return BY_NAME[name]
