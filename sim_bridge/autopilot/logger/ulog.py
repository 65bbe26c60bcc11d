"""A ULog file in memory (docs.px4.io, "ULog File Format"): definitions first, then data in the order of time."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

MAGIC = b"ULog\x01\x12\x35\x01"
"""The file's first bytes: name and version 1."""
_HEAD = struct.Struct("<HB")
"""Size of a message's content, and its kind."""
_CODES = {"uint64_t": "Q", "float": "f"}
"""Of struct, for the types that are logged here."""


@dataclass(frozen=True)
class Topic:
    """One uORB topic. ``fields``: "type name" each, as in PX4's message definition; the first is the timestamp."""

    name: str
    fields: tuple[str, ...]

    @property
    def codes(self) -> str:
        """Its fields for struct."""
        codes = ""
        for field in self.fields:
            kind, _, count = field.split()[0].partition("[")
            codes += f"{count.rstrip(']')}{_CODES[kind]}"
        return codes

    @property
    def format(self) -> str:
        """Its definition."""
        return f"{self.name}:" + "".join(f"{field};" for field in self.fields)


class ULogFile:
    """A log of ``topics``, begun at ``time_us`` of the vehicle's clock. ``info``: texts that stand in its head."""

    def __init__(self, topics: Sequence[Topic], time_us: int, info: dict[str, str]) -> None:
        self.data = bytearray(MAGIC + struct.pack("<Q", time_us))
        self._add("B", bytes(40))
        for topic in topics:
            self._add("F", topic.format.encode("ascii"))
        for name, text in info.items():
            key = f"char[{len(text)}] {name}".encode("ascii")
            self._add("I", bytes([len(key)]) + key + text.encode("ascii"))
        for number, topic in enumerate(topics):
            self._add("A", struct.pack("<BH", 0, number) + topic.name.encode("ascii"))
        self._rows = [struct.Struct(f"<HBH{topic.codes}") for topic in topics]

    def write(self, topic: int, *values: float) -> None:
        """One row of a topic, by its number."""
        row = self._rows[topic]
        self.data += row.pack(row.size - _HEAD.size, ord("D"), topic, *values)

    def _add(self, kind: str, content: bytes) -> None:
        self.data += _HEAD.pack(len(content), ord(kind)) + content
