"""Bytes <-> messages of DDS-XRCE, as PX4's client and an agent exchange them. Both directions.

A message is a header (session, stream, sequence) and submessages, each at a multiple of 4 bytes from its start.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from companion.vehicle import CompanionError
from companion.xrce.messages import (
    BEST_EFFORT,
    Acknack,
    CreateClient,
    Delete,
    Fragment,
    GetInfo,
    Heartbeat,
    Info,
    StatusAgent,
    Submessage,
    Timestamp,
    TimestampReply,
)
from companion.xrce.objects import Create, Data, ReadData, Status, WriteData

NO_SESSION = 0x80
"""The session number of a client that has none yet. Lower numbers have a key in each header; PX4 never uses one."""
NO_STREAM = 0x00
"""Pings, acknowledgements, time, and what begins and ends a session."""
LITTLE_ENDIAN, LAST_FRAGMENT = 0x01, 0x02
"""Flags that are looked at."""

_HEADER = struct.Struct("<BBH")
KINDS: tuple[type[Submessage], ...] = (
    CreateClient, Create, GetInfo, Delete, StatusAgent, Status, Info, WriteData, ReadData, Data, Acknack, Heartbeat,
    Fragment, Timestamp, TimestampReply,
)  # fmt: skip
"""Every kind of submessage that is read."""
_READ = {kind.ID: (kind.SHORTEST, kind.read) for kind in KINDS}


class WireError(CompanionError):
    """Bytes that are no message of this protocol."""


class Message(NamedTuple):
    """One datagram. ``sequence``: of its stream, 0 to 65535."""

    session: int
    stream: int
    sequence: int
    submessages: tuple[Submessage, ...]


def encode(message: Message) -> bytes:
    """The bytes of a message, each submessage filled up to a multiple of 4."""
    head = _HEADER.pack(message.session, message.stream, message.sequence)
    return head + b"".join(map(encode_submessage, message.submessages))


def encode_submessage(submessage: Submessage) -> bytes:
    """Header, payload and filling: what a message holds, and what fragments carry pieces of."""
    body = submessage.body()
    flags = submessage.FLAGS
    if isinstance(submessage, Fragment) and submessage.last:
        flags |= LAST_FRAGMENT
    return _HEADER.pack(submessage.ID, flags, len(body)) + body + bytes(-len(body) % 4)


def encode_samples(session: int, sequence: int, samples: Iterable[tuple[bytes, bytes]]) -> bytes:
    """The best-effort message of DATA for these readers (request and object id, 4 bytes; CDR), as ``encode`` makes it
    of values: each setpoint waits for this."""
    parts = [_HEADER.pack(session, BEST_EFFORT, sequence)]
    for reader, cdr in samples:
        size = len(cdr) + len(reader)
        parts += (_HEADER.pack(Data.ID, Data.FLAGS, size), reader, cdr, bytes(-size % 4))
    return b"".join(parts)


def decode(data: bytes) -> Message:
    """The message in a datagram; submessages that are not known here are left out. WireError: it is none, or one of its
    submessages is cut short or makes no sense: half a message is not acted on."""
    if len(data) < _HEADER.size:
        raise WireError(f"{len(data)} bytes are no message")
    session, stream, sequence = _HEADER.unpack_from(data)
    if session < NO_SESSION:
        raise WireError(f"session {session} has a key in its headers")
    return Message(session, stream, sequence, tuple(decode_submessages(data, _HEADER.size)))


def decode_submessages(data: bytes, at: int = 0) -> Iterator[Submessage]:
    """The submessages in ``data`` from ``at`` on. WireError: one is cut short or makes no sense."""
    while at < len(data):
        begin = at + _HEADER.size
        if begin > len(data):
            raise WireError("a submessage is cut short")
        number, flags, length = _HEADER.unpack_from(data, at)
        end = begin + length
        if end > len(data):
            raise WireError(f"submessage {number} is cut short")
        if not flags & LITTLE_ENDIAN:
            raise WireError(f"submessage {number} is big endian")
        at = end + -end % 4
        if number in _READ:
            yield _decode(number, flags, data[begin:end])


def _decode(number: int, flags: int, payload: bytes) -> Submessage:
    shortest, read = _READ[number]
    value = read(payload) if len(payload) >= shortest else None
    if value is None:
        raise WireError(f"the payload of submessage {number} makes no sense")
    return Fragment(payload, last=True) if number == Fragment.ID and flags & LAST_FRAGMENT else value
