"""PX4's client as far as connecting goes: pings, creates three objects at a time, asks for samples, publishes."""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.xrce import objects, wire
from companion.xrce.messages import (
    BEST_EFFORT,
    RELIABLE,
    SESSION,
    Acknack,
    CreateClient,
    Fragment,
    GetInfo,
    Heartbeat,
    Info,
    StatusAgent,
    Submessage,
    Timestamp,
    TimestampReply,
)
from companion.xrce.objects import Data, Kind, ReadData, Status, WriteData
from companion.xrce.reliable import Incoming, Outgoing, ahead
from companion.xrce.wire import NO_SESSION, NO_STREAM, Message

RETRY = 1.0
"""s after which a ping or a CREATE_CLIENT that was not answered is sent again."""
SYNCHRONISED = 500
"""Answers to TIMESTAMP that PX4 wants before it makes its objects (UXRCE_DDS_SYNCT 1)."""


class SmallClient:
    """``inputs``, ``outputs``: names on the wire. ``read``: the samples that came, by name; ``ready``: all was made."""

    def __init__(self, inputs: list[str], outputs: list[str], *, timesync: bool = False) -> None:
        self.read: list[tuple[str, bytes]] = []
        self.ready = False
        self._names = {number + 0x800: name for number, name in enumerate(inputs)}
        self._names.update({number + 0x10: name for number, name in enumerate(outputs)})
        self._incoming, self._outgoing = Incoming(), Outgoing()
        self._stage, self._try_at, self._request, self._sent = "ping", -math.inf, 10, 0
        self._open: set[int] = set()
        self._left = list(self._names)
        self._stamps = 0 if timesync else SYNCHRONISED
        self._answers: list[Message] = []

    def publish(self, name: str, cdr: bytes) -> None:
        number = next(number for number, each in self._names.items() if each == name)
        self._answers.append(Message(SESSION, BEST_EFFORT, self._sent, (WriteData(0, number << 4 | Kind.WRITER, cdr),)))
        self._sent = ahead(self._sent + 1, 0)

    def receive(self, data: bytes) -> None:
        message = wire.decode(data)
        if message.stream == RELIABLE:
            self._take(self._incoming.receive(message.sequence, message.submessages))
            self._say(self._incoming.acknack())
        else:
            self._take(message.submessages)

    def _take(self, submessages: list[Submessage] | tuple[Submessage, ...]) -> None:
        for each in submessages:
            match each:
                case Info() if self._stage == "ping":
                    self._stage, self._try_at = "create", -math.inf
                case StatusAgent() if self._stage == "create":
                    self._stage = "objects"
                case Status():
                    self._open.discard(each.request)
                case Acknack():
                    self._outgoing.take_acknack(each)
                case Heartbeat():
                    self._say(self._incoming.acknack(each.last))
                case TimestampReply():
                    self._stamps += 1
                case Data():
                    self.read.append((self._names[each.object >> 4], each.sample))

    def datagrams(self, now: float) -> list[bytes]:
        if self._stage in ("ping", "create"):
            if now >= self._try_at:
                self._try_at = now + RETRY
                what = GetInfo(10, 0xFFFD) if self._stage == "ping" else CreateClient(b"\0\0\0\x08")
                self._answers.append(Message(NO_SESSION, NO_STREAM, 0, (what,)))
        elif self._stamps < SYNCHRONISED:
            if now >= self._try_at:
                self._try_at = now + 0.012
                self._say(Timestamp(bytes(8)))
        elif not self._open:
            self._make()
        messages, self._answers = self._answers, []
        reliable, heartbeat = self._outgoing.due(now)
        messages += [Message(SESSION, RELIABLE, number, (each,)) for number, each in reliable]
        if heartbeat is not None:
            messages.append(Message(SESSION, NO_STREAM, 0, (heartbeat,)))
        return [wire.encode(each) for each in messages]

    def _make(self) -> None:
        if not self._left:
            self.ready = True
            return
        number = self._left.pop(0)
        kinds = (Kind.SUBSCRIBER, objects.reader) if number >= 0x800 else (Kind.PUBLISHER, objects.writer)
        first = self._request = self._request + 4
        made: list[Submessage] = [
            objects.topic(first, number, self._names[number], "px4_msgs::msg::dds_::Something_"),
            objects.group(first + 1, number, kinds[0]),
            kinds[1](first + 2, number),
        ]
        self._open = {first, first + 1, first + 2}
        if number >= 0x800:
            made.append(ReadData(first + 3, number << 4 | Kind.READER))
        for each in made:
            self._outgoing.send(each)

    def _say(self, submessage: Submessage) -> None:
        self._answers.append(Message(SESSION, NO_STREAM, 0, (submessage,)))


def fragments(submessage: Submessage, size: int) -> Iterable[Fragment]:
    """The pieces, of at most ``size`` bytes, of a submessage that does not fit into a slot."""
    data = wire.encode_submessage(submessage)
    return (Fragment(data[at : at + size], at + size >= len(data)) for at in range(0, len(data), size))
