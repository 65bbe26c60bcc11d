"""What a client makes, asks for and publishes: the submessages about objects, and how it describes them.

An object's id is 12 bits of number and 4 bits of kind. A topic is described by its name and type (strings: u32 length
with the NUL, bytes, NUL), a reader or a writer by its topic's id. Everything in both directions.
"""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass
from typing import ClassVar, Self

from companion.xrce.messages import BEST_EFFORT, IDS, About, ids

BINARY = 3
"""The form of everything PX4's client makes but its participant."""
NAME_MAX = 256
"""bytes of a name that is read (engineering choice: PX4's longest have 60, and a namespace of as many)."""
PX4_PARTICIPANT = 0x0011
"""The participant of PX4's client: its number is 1."""


class Kind(enum.IntEnum):
    """What an object is: the last 4 bits of its id, and the kind in its CREATE."""

    PARTICIPANT = 1
    TOPIC = 2
    PUBLISHER = 3
    SUBSCRIBER = 4
    WRITER = 5
    READER = 6
    REPLIER = 8


@dataclass(frozen=True, slots=True)
class Create(About):
    """Client: an object is made. ``form``: 2 XML, 3 binary. ``representation``: see ``topic``, ``reader`` and so on."""

    kind: int
    form: int
    representation: bytes
    parent: int

    ID: ClassVar[int] = 1
    FLAGS: ClassVar[int] = 0x05  # one that is there is used again
    SHORTEST: ClassVar[int] = 12

    def body(self) -> bytes:
        what = struct.pack("<BBHI", self.kind, self.form, 0, len(self.representation))
        return IDS.pack(self.request, self.object) + what + self.representation + struct.pack(">H", self.parent)

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        kind, form, _, length = struct.unpack_from("<BBHI", payload, 4)
        end = 12 + length
        if end > len(payload):
            return None
        parent = int.from_bytes(payload[end : end + 2], "big")
        return cls(*ids(payload), kind, form, payload[12:end], parent)


@dataclass(frozen=True, slots=True)
class Status(About):
    """Agent: the answer to a CREATE. ``status``: 0 done."""

    status: int = 0

    ID: ClassVar[int] = 5
    SHORTEST: ClassVar[int] = 5

    def body(self) -> bytes:
        return IDS.pack(self.request, self.object) + bytes((self.status, 0))

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(*ids(payload), payload[4])


@dataclass(frozen=True, slots=True)
class ReadData(About):
    """Client: send the samples of this reader, on this stream, any number of them, unfiltered."""

    stream: int = BEST_EFFORT

    ID: ClassVar[int] = 8
    SHORTEST: ClassVar[int] = 5

    def body(self) -> bytes:
        return IDS.pack(self.request, self.object) + bytes((self.stream, 0, 0, 1)) + b"\xff\xff" + bytes(6)

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(*ids(payload), payload[4])


@dataclass(frozen=True, slots=True)
class _Sample(About):
    """``sample``: CDR without a header, see ``topics``."""

    sample: bytes

    def body(self) -> bytes:
        return IDS.pack(self.request, self.object) + self.sample

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(*ids(payload), payload[4:])


class WriteData(_Sample):
    """Client: a sample that it publishes."""

    __slots__ = ()
    ID: ClassVar[int] = 7


class Data(_Sample):
    """Agent: a sample for a client's reader. PX4 looks at neither the request nor who sends."""

    __slots__ = ()
    ID: ClassVar[int] = 9


def topic(request: int, number: int, name: str, type_name: str) -> Create:
    """A topic as the client makes it: no type reference, but a type."""
    text = _string(name)
    text += b"\0\x01"
    text += bytes(-len(text) % 4) + _string(type_name)
    return Create(request, number << 4 | Kind.TOPIC, Kind.TOPIC, BINARY, text, PX4_PARTICIPANT)


def reader(request: int, number: int) -> Create:
    """A reader of the topic of the same number: best effort, keep last."""
    return _end(request, number, Kind.READER, Kind.SUBSCRIBER, b"\x01\0\x02\0\x01\0\x04\0\0\0\0\0\0")


def writer(request: int, number: int) -> Create:
    """A writer of the topic of the same number."""
    return _end(request, number, Kind.WRITER, Kind.PUBLISHER, b"\x01\0\x0a\0\0\0\0\0\0")


def group(request: int, number: int, kind: Kind) -> Create:
    """The publisher or subscriber between a topic and its writer or reader."""
    return Create(request, number << 4 | kind, kind, BINARY, b"\0\0", PX4_PARTICIPANT)


def _end(request: int, number: int, kind: Kind, parent: Kind, qos: bytes) -> Create:
    made = (number << 4 | Kind.TOPIC).to_bytes(2, "big") + qos
    return Create(request, number << 4 | kind, kind, BINARY, made, number << 4 | parent)


def name_of(created: Create) -> str | None:
    """The name of a topic; None: it is none that can be read."""
    data = created.representation
    length = int.from_bytes(data[:4], "little")
    if created.kind != Kind.TOPIC or created.form != BINARY or not 1 < length <= min(NAME_MAX, len(data) - 4):
        return None
    text = data[4 : 3 + length]
    return text.decode("ascii") if text.isascii() and b"\0" not in text else None


def topic_of(created: Create) -> int | None:
    """The topic's object id that a reader or a writer names; None: it names none."""
    data = created.representation
    if created.kind not in (Kind.READER, Kind.WRITER) or created.form != BINARY or len(data) < 2:
        return None
    return int.from_bytes(data[:2], "big")


def _string(text: str) -> bytes:
    data = text.encode() + b"\0"
    return len(data).to_bytes(4, "little") + data
