"""The agent that PX4's ``uxrce_dds_client`` connects to: one client, one session, without sockets or clocks.

Doors: ``receive`` takes a datagram; ``write`` queues samples; ``datagrams`` gives what is to be sent; ``next_timer``
says when to call that again (all times: s, our monotonic clock). The choreography was read off PX4 main of March 2026:

    ping -> INFO, CREATE_CLIENT -> STATUS_AGENT, then CREATE after CREATE -> STATUS; READ_DATA; and samples flow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from companion.xrce import objects, topics, wire
from companion.xrce.messages import (
    IDS,
    RELIABLE,
    SESSION,
    THE_CLIENT,
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
from companion.xrce.objects import Create, Kind, ReadData, Status, WriteData
from companion.xrce.reliable import NUMBERS, Incoming, Outgoing, ahead
from companion.xrce.topics import Layout, Topic
from companion.xrce.wire import NO_SESSION, NO_STREAM, Message, WireError

TOPICS_MAX = 512
"""Topics that are remembered: PX4 has 65 (engineering choice)."""
PIECES_MAX = 4096
"""bytes of a submessage that comes in pieces: PX4's longest has 250 (engineering choice)."""


class Sample(NamedTuple):
    """What PX4 published: CDR, see ``topics``."""

    topic: Topic
    cdr: bytes


class Reader(NamedTuple):
    """A topic that PX4 reads: the object its samples go to, and the request they answer; ``ids``: both as bytes."""

    topic: Topic
    object: int
    ids: bytes


@dataclass(slots=True)
class Counters:
    """What came. ``garbage``: datagrams and frames that were no message; ``strange``: of another session or another
    client; ``lost``, ``late``: best-effort messages that did not come, or after a newer one; ``orphaned``: of a client
    whose agent is gone."""

    messages: int = 0
    garbage: int = 0
    strange: int = 0
    lost: int = 0
    late: int = 0
    orphaned: int = 0


@dataclass(slots=True)
class _Session:
    """One session's streams and objects."""

    number: int
    incoming: Incoming = field(default_factory=Incoming)
    outgoing: Outgoing = field(default_factory=Outgoing)
    sent: int = 0
    heard: int | None = None
    pieces: bytes = b""
    topics: dict[int, Topic] = field(default_factory=dict)
    readers: dict[int, Topic] = field(default_factory=dict)
    writers: dict[int, Topic] = field(default_factory=dict)


@dataclass(slots=True)
class Agent:
    """One client's agent.

    ``reading``: by name, the topics that PX4 reads now. ``versioned``: whether its topics have versions (see
    ``topics.layout``). ``sessions``: how many there were. ``heard_at``: s, the last message of a client: of the
    session, or one that begins it. ``keeps_time``: TIMESTAMP is answered.
    Where it is not, once a session stands, the client asks in every turn and waits for the answer on the socket, where
    it takes commands at once rather than up to 10 ms later; its clock offset stays as it was (xrce.md, section 5).
    ``is_adopted``: the client speaks in the session of an agent that is gone, such as this one before a restart. It is
    counted and no more: what its objects are called was said when that session began, and what was commanded last in it
    is not known. It is told that its session is gone, and begins anew after three pings.
    """

    reading: dict[str, Reader] = field(default_factory=dict)
    versioned: bool = False
    sessions: int = 0
    heard_at: float = -math.inf
    keeps_time: bool = True
    is_adopted: bool = False
    counters: Counters = field(default_factory=Counters)
    _session: _Session | None = None
    _samples: list[Sample] = field(default_factory=list)
    _answers: list[bytes] = field(default_factory=list)
    _acknack: Acknack | None = None

    @property
    def connected(self) -> bool:
        """Whether there is a session."""
        return self._session is not None

    def receive(self, data: bytes, now: float) -> list[Sample]:
        """Take a datagram in; what PX4 published in it. Never raises: what makes no sense is counted."""
        try:
            message = wire.decode(data)
        except WireError:
            self.counters.garbage += 1
            return []
        self.counters.messages += 1
        session = self._session
        if message.session == NO_SESSION or session is None or message.session != session.number:
            self._outside(message, now)
        else:
            self.heard_at = now
            if message.stream == RELIABLE:
                self._read(session.incoming.receive(message.sequence, message.submessages))
                self._acknack = session.incoming.acknack()
            elif message.stream == NO_STREAM or self._is_next(session, message.sequence):
                self._read(message.submessages)
        samples, self._samples = self._samples, []
        return samples

    def layout(self, topic: Topic) -> Layout:
        """The layout of one of this client's topics. TopicError: it is not known here."""
        return topics.layout(topic, versioned=self.versioned)

    @property
    def place(self) -> tuple[int, int] | None:
        """Session and sequence number of the next message of samples; None: there is no session."""
        return None if self._session is None else (self._session.number, self._session.sent)

    def queue(self, message: bytes) -> None:
        """Queue a message of samples that was made for the next ``place``."""
        assert self._session is not None
        self._answers.append(message)
        self._session.sent = ahead(self._session.sent + 1, 0)

    def write(self, samples: Sequence[tuple[str, bytes]]) -> bool:
        """Queue samples, topic and CDR, as one message. False: PX4 does not read all of them; then none is sent."""
        readers = [self.reading.get(topic) for topic, _ in samples]
        if self._session is None or None in readers or not samples:
            return False
        data = [(reader.ids, cdr) for reader, (_, cdr) in zip(readers, samples, strict=True) if reader is not None]
        self.queue(wire.encode_samples(self._session.number, self._session.sent, data))
        return True

    def datagrams(self, now: float) -> list[bytes]:
        """What is to be sent at ``now``."""
        messages, self._answers = self._answers, []
        session, acknack, self._acknack = self._session, self._acknack, None
        if session is not None and (acknack is not None or session.outgoing.busy):
            reliable, heartbeat = session.outgoing.due(now)
            messages += (wire.encode(Message(session.number, RELIABLE, number, (each,))) for number, each in reliable)
            for each in (acknack, heartbeat):
                if each is not None:
                    messages.append(wire.encode(Message(session.number, NO_STREAM, 0, (each,))))
        return messages

    def next_timer(self) -> float:
        """s, when ``datagrams`` has something without anything coming in; inf: never."""
        return math.inf if self._session is None else self._session.outgoing.next_at

    def _outside(self, message: Message, now: float) -> None:
        """A client that has no session yet, or one that we do not know (any more)."""
        orphaned = self._session is None and message.session != NO_SESSION
        self.is_adopted = orphaned
        for each in message.submessages:
            if isinstance(each, GetInfo | CreateClient):
                self.heard_at = now
            if isinstance(each, GetInfo):
                self._answer(Info(each.request, each.object, alive=False), message.session)
            elif isinstance(each, CreateClient) and each.session >= NO_SESSION:
                self._session = _Session(each.session)
                self.reading, self.versioned = {}, False
                self.sessions += 1
                self._answer(StatusAgent(), each.session)
            elif orphaned:
                self.counters.orphaned += 1
            else:
                self.counters.strange += 1

    def _read(self, submessages: Sequence[Submessage]) -> None:
        for each in submessages:
            session = self._session
            if session is None:
                return  # it ended with the one before
            match each:
                case WriteData():
                    topic = session.writers.get(each.object)
                    if topic is not None:
                        self._samples.append(Sample(topic, each.sample))
                case Create():
                    self._create(session, each)
                    session.outgoing.send(Status(each.request, each.object))
                case ReadData():
                    read = session.readers.get(each.object)
                    if read is not None:
                        self.reading[read.name] = Reader(read, each.object, IDS.pack(each.request, each.object))
                case Timestamp() if self.keeps_time:
                    self._answer(TimestampReply(each.time, each.time, each.time), session.number)
                case GetInfo():
                    self._answer(Info(each.request, each.object, alive=True), session.number)
                case Acknack():
                    session.outgoing.take_acknack(each)
                case Heartbeat():
                    self._acknack = session.incoming.acknack(each.last)
                case Fragment():
                    self._collect(session, each)
                case Delete():
                    self._delete(session, each)
                case CreateClient():
                    self._outside(Message(session.number, NO_STREAM, 0, (each,)), self.heard_at)

    def _create(self, session: _Session, made: Create) -> None:
        """Remember what a topic, a reader or a writer is called."""
        name = objects.name_of(made)
        topic = None if name is None else topics.parse(name)
        if topic is not None and len(session.topics) < TOPICS_MAX:
            session.topics[made.object] = topic
            self.versioned = self.versioned or topic.version > 0
        of = objects.topic_of(made)
        if of in session.topics:
            ends = session.readers if made.kind == Kind.READER else session.writers
            ends[made.object] = session.topics[of]

    def _collect(self, session: _Session, fragment: Fragment) -> None:
        """Put a submessage together that comes in pieces."""
        session.pieces += fragment.piece
        if len(session.pieces) > PIECES_MAX:
            session.pieces = b""
            self.counters.garbage += 1
        elif fragment.last:
            whole, session.pieces = session.pieces, b""
            try:
                self._read([each for each in wire.decode_submessages(whole) if not isinstance(each, Fragment)])
            except WireError:
                self.counters.garbage += 1

    def _delete(self, session: _Session, what: Delete) -> None:
        if what.object == THE_CLIENT:
            self._session, self.reading = None, {}
            self._answer(Status(what.request, what.object), session.number)
        else:
            session.outgoing.send(Status(what.request, what.object))

    def _answer(self, submessage: Submessage, session: int = SESSION) -> None:
        self._answers.append(wire.encode(Message(session, NO_STREAM, 0, (submessage,))))

    def _is_next(self, session: _Session, number: int) -> bool:
        """Whether a best-effort message is newer than those that came. A late one says what is no longer so."""
        if session.heard is not None:
            gap = ahead(number, session.heard)
            if not 0 < gap < NUMBERS // 2:
                self.counters.late += 1
                return False
            self.counters.lost += gap - 1
        session.heard = number
        return True
