"""The submessages that hold a session together: payload bytes <-> value, both directions.

Little endian; object and request ids big endian. ``body`` gives the payload of a submessage; ``read`` takes one of at
least ``SHORTEST`` bytes, and gives None where it makes no sense. Source: OMG DDS-XRCE 1.0, and the bytes PX4 sends.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import ClassVar, Self

SESSION = 0x81
"""PX4's session number."""
BEST_EFFORT, RELIABLE = 0x01, 0x80
"""PX4's streams: whatever comes; each message once and in order."""
THE_AGENT = 0xFFFD
"""The object a ping asks for."""
THE_CLIENT = 0xFFFE
"""The object whose deletion ends the session."""
COOKIE = b"XRCE"
"""With it a CREATE_CLIENT and its answer begin."""
CLIENT_VERSION, AGENT_VERSION = b"\x01\x00\x01\x0f", b"\x01\x00\x0f\x0f"
"""XRCE 1.0 and a vendor: eProsima's client; an agent that is not eProsima's, as PX4 has been flown with."""

IDS = struct.Struct(">HH")
"""Request and object id."""


def ids(payload: bytes) -> tuple[int, int]:
    """The request and the object a payload begins with."""
    return int.from_bytes(payload[:2], "big"), int.from_bytes(payload[2:4], "big")


@dataclass(frozen=True, slots=True)
class Submessage:
    """One of them. ``FLAGS``: little endian, and what else its header says."""

    ID: ClassVar[int]
    FLAGS: ClassVar[int] = 0x01
    SHORTEST: ClassVar[int]

    def body(self) -> bytes:
        """The payload."""
        raise NotImplementedError

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        """The value of a payload; None: it makes no sense."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class About(Submessage):
    """Says something about an ``object``; an answer repeats the ``request``."""

    request: int
    object: int

    SHORTEST: ClassVar[int] = 4

    def body(self) -> bytes:
        return IDS.pack(self.request, self.object)

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(*ids(payload))


@dataclass(frozen=True, slots=True)
class CreateClient(Submessage):
    """Client: a session begins. ``key``: 4 bytes. ``mtu``: bytes of its longest message."""

    key: bytes
    session: int = SESSION
    mtu: int = 508

    ID: ClassVar[int] = 0
    SHORTEST: ClassVar[int] = 16

    def body(self) -> bytes:
        return COOKIE + CLIENT_VERSION + self.key + struct.pack("<BBH", self.session, 0, self.mtu)

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        session, _, mtu = struct.unpack_from("<BBH", payload, 12)
        return cls(payload[8:12], session, mtu) if payload[:4] == COOKIE else None


@dataclass(frozen=True, slots=True)
class StatusAgent(Submessage):
    """Agent: the session stands (``status`` 0)."""

    status: int = 0

    ID: ClassVar[int] = 4
    SHORTEST: ClassVar[int] = 11

    def body(self) -> bytes:
        return bytes((self.status, 0)) + COOKIE + AGENT_VERSION + b"\0"

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(payload[0])


class GetInfo(About):
    """Client: a ping. Is an agent there, does the session live?"""

    __slots__ = ()
    ID: ClassVar[int] = 2

    def body(self) -> bytes:
        return IDS.pack(self.request, self.object) + b"\x02\0\0\0"


@dataclass(frozen=True, slots=True)
class Info(About):
    """Agent: the answer to a ping. ``alive``: the session lives; inside a session the client counts no other answer."""

    alive: bool

    ID: ClassVar[int] = 6
    SHORTEST: ClassVar[int] = 6

    def body(self) -> bytes:
        return IDS.pack(self.request, self.object) + bytes((0, self.alive, 0, 1, 13, 0, 1, 0, 0, 0, 0, 0))

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(*ids(payload), bool(payload[5]))


class Delete(About):
    """Client: an object ends; with THE_CLIENT the session."""

    __slots__ = ()
    ID: ClassVar[int] = 3


@dataclass(frozen=True, slots=True)
class Acknack(Submessage):
    """Both: what there is of the other's reliable stream: all before ``first``; bit i of ``missing``: not first + i."""

    first: int
    missing: int = 0
    stream: int = RELIABLE

    ID: ClassVar[int] = 10
    SHORTEST: ClassVar[int] = 5

    def body(self) -> bytes:
        return struct.pack("<H", self.first) + struct.pack(">HB", self.missing, self.stream)

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(int.from_bytes(payload[:2], "little"), int.from_bytes(payload[2:4], "big"), payload[4])


@dataclass(frozen=True, slots=True)
class Heartbeat(Submessage):
    """Both: what of our own reliable stream may be asked for again, ``first`` to ``last``."""

    first: int
    last: int
    stream: int = RELIABLE

    ID: ClassVar[int] = 11
    SHORTEST: ClassVar[int] = 5

    def body(self) -> bytes:
        return struct.pack("<HHB", self.first, self.last, self.stream)

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(*struct.unpack_from("<HHB", payload))


@dataclass(frozen=True, slots=True)
class Fragment(Submessage):
    """Both: a piece of a submessage, header included, that is longer than a slot of the stream."""

    piece: bytes
    last: bool = False

    ID: ClassVar[int] = 13
    SHORTEST: ClassVar[int] = 0

    def body(self) -> bytes:
        return self.piece

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(payload)


@dataclass(frozen=True, slots=True)
class Timestamp(Submessage):
    """Client: what time is it? ``time``: its own since boot, 8 bytes as on the wire (i32 s, u32 ns)."""

    time: bytes

    ID: ClassVar[int] = 14
    SHORTEST: ClassVar[int] = 8

    def body(self) -> bytes:
        return self.time

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(payload[:8])


@dataclass(frozen=True, slots=True)
class TimestampReply(Submessage):
    """Agent: when this was sent, when the question came, what the question said; 8 bytes each."""

    transmitted: bytes
    received: bytes
    originated: bytes

    ID: ClassVar[int] = 15
    SHORTEST: ClassVar[int] = 24

    def body(self) -> bytes:
        return self.transmitted + self.received + self.originated

    @classmethod
    def read(cls, payload: bytes) -> Self | None:
        return cls(payload[:8], payload[8:16], payload[16:24])
