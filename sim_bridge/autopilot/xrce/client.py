"""The life of PX4's XRCE client, as its own program goes: ping, session, time, objects, publish and listen, again.

The program is a generator that stops wherever PX4's would wait. While it waits on the line, what comes is read at once;
while it publishes, what comes waits for its next turn, which its own publications begin.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable, Generator
from typing import Protocol

from companion.xrce.messages import (
    RELIABLE,
    THE_AGENT,
    THE_CLIENT,
    Delete,
    GetInfo,
    Info,
    StatusAgent,
    Submessage,
    Timestamp,
    TimestampReply,
)
from companion.xrce.objects import PX4_PARTICIPANT, Create, Data, Kind, ReadData, Status, group, reader, topic, writer
from companion.xrce.topics import Topic
from sim_bridge.autopilot.xrce.service import replier
from sim_bridge.autopilot.xrce.session import Session
from sim_bridge.autopilot.xrce.topic_table import FIRST_READER, Row, TopicTable

US = 1_000_000
"""us a second."""
PING_REQUEST = 10
"""The request a ping has."""
ANSWER_WITHIN = 1.0
"""s for an answer while the session is set up and for a ping."""
ATTEMPTS = 10
"""How often a session is asked for before the next ping."""
PAUSE = 1.0
"""s after a session that could not be set up."""
SYNC_PAUSE = 0.01
"""s between two questions for the time while the clock has not converged."""
SYNC_SAMPLES = 500
"""Answers in time until the clock has converged (Timesync's CONVERGENCE_WINDOW)."""
SYNC_ROUND_TRIP = 0.01
"""s: an answer that takes longer is not used."""
SYNC_TIMEOUTS = 10
"""Questions without an answer in a row after which the session is given up."""
SYNC_PERIOD = 1.0
"""s between two questions once the clock has converged."""
TURN = 0.01
"""s that the client sleeps at most while it publishes, and that it waits for the time then."""
RATE_PERIOD = 1.0
"""s over which it looks whether data flow both ways, and between two pings where they do not."""
DONE = (0, 1)
"""Statuses of an object that is there: made, or made before with the same meaning."""
MISSED = 3
"""Pings without an answer until the session is given up."""
QUEUE = 256
"""datagrams that wait on the client's socket (Linux keeps about so many small ones)."""

PARTICIPANT = "<dds><participant><rtps><name>/px4_micro_xrce_dds</name></rtps></participant></dds>"
"""What PX4 calls itself (UXRCE_DDS_PTCFG 0)."""
XML = 2
"""The form of a participant's representation."""
Waits = Generator[None, None, bool]
"""A part of the program, and how it ended."""


class Vehicle(Protocol):
    """What the client asks of the vehicle it belongs to."""

    @property
    def key(self) -> int:
        """Its number among the agent's clients."""

    @property
    def synchronises(self) -> bool:
        """Whether it waits for the agent's clock (UXRCE_DDS_SYNCT)."""

    @property
    def clock_us(self) -> int:
        """us since it was switched on."""

    def is_due(self, now_us: int) -> bool:
        """Whether a topic is to be published."""

    def take_samples(self, now_us: int, offset_us: int) -> list[tuple[Row, bytes]]:
        """The samples that are. ``offset_us``: from its clock to the agent's."""

    def take(self, topic: Topic, sample: bytes, offset_us: int) -> None:
        """A sample came."""

    def notice_time(self, observed_us: int, offset_us: int, round_trip_us: int) -> None:
        """The agent has told the time."""


class Client:
    """One client. ``session.outbox``: what to send; ``serves``: topics are published and read."""

    def __init__(self, table: TopicTable, vehicle: Vehicle) -> None:
        self.session = Session()
        self.serves = False
        self._table, self._vehicle = table, vehicle
        self._topics = {row.number << 4 | Kind.READER: row.topic for row in table.taken}
        self._inbox: deque[bytes] = deque(maxlen=QUEUE)
        self._listens = False
        self._now_us = 0
        self._statuses: dict[int, int] = {}
        self._read_next: list[Submessage] = []
        self._answered = self._begun = self._told_time = False
        self._samples = self._offset_us = 0
        self._received = 0
        self._life = self._live()

    def receive(self, datagram: bytes) -> None:
        """A datagram came, now."""
        self._inbox.append(datagram)
        if self._listens:
            next(self._life)

    def step(self, now_us: int) -> None:
        """It is ``now_us``."""
        self._now_us = now_us
        next(self._life)

    def _live(self) -> Generator[None, None, None]:
        while True:
            while not (yield from self._ask(lambda: self.session.ping(GetInfo(PING_REQUEST, THE_AGENT)))):
                pass
            stands = (yield from self._begin()) and (yield from self._make_everything())
            if stands:
                self.serves = True
                yield from self._serve()
                self.serves = False
            if self._begun:
                self.session.say(Delete(2, THE_CLIENT))
            self._begun = False
            self._samples = self._offset_us = 0
            if not stands:
                yield from self._sleep(PAUSE)

    def _begin(self) -> Waits:
        """A session is asked for, and the participant made."""
        for _ in range(ATTEMPTS):
            if (yield from self._ask(lambda: self.session.begin(self._vehicle.key))):
                break
        else:
            return False
        self._begun = True
        xml = PARTICIPANT.encode() + b"\0"
        return (
            yield from self._create([Create(self.session.request(), PX4_PARTICIPANT, Kind.PARTICIPANT, XML, xml, 0)])
        )

    def _make_everything(self) -> Waits:
        """The clock converges and the objects are made, in the order of the release."""
        clock = self._vehicle.synchronises
        if clock and self._table.waits_first and not (yield from self._converge()):
            return False
        if not (yield from self._make_objects()):
            return False
        return not clock or self._table.waits_first or (yield from self._converge())

    def _make_objects(self) -> Waits:
        request = self.session.request
        self._read_next = []
        for row in self._table.taken:
            made = [
                topic(request(), row.number, row.topic.wire_name(), row.type_name),
                group(request(), row.number, Kind.SUBSCRIBER),
                reader(request(), row.number),
            ]
            if not (yield from self._create(made)):
                return False
            self._read_next = [ReadData(request(), row.number << 4 | Kind.READER)]
        for row in self._table.given:
            made = [
                topic(request(), row.number, row.topic.wire_name(), row.type_name),
                group(request(), row.number, Kind.PUBLISHER),
                writer(request(), row.number),
            ]
            if not (yield from self._create(made)):
                return False
        service = replier(request(), FIRST_READER)
        if not (yield from self._create([service])):
            return False
        return self.session.demand([ReadData(request(), service.object, RELIABLE)])

    def _create(self, made: list[Create]) -> Waits:
        """Objects are made, and their readers of the time before asked to read; whether the agent says yes to all."""
        self._statuses = {}
        if not self.session.demand([*self._read_next, *made]):
            return False
        self._read_next = []
        wanted = {each.request for each in made}
        yield from self._listen(ANSWER_WITHIN, lambda: wanted <= self._statuses.keys())
        return all(self._statuses.get(each) in DONE for each in wanted)

    def _converge(self) -> Waits:
        """Ask for the time until enough answers came quickly enough: on a slow line for ever."""
        missed = 0
        while self._samples < SYNC_SAMPLES:
            missed = 0 if (yield from self._synchronise(ANSWER_WITHIN)) else missed + 1
            if missed > SYNC_TIMEOUTS:
                return False
            if self._samples < SYNC_SAMPLES:
                yield from self._sleep(SYNC_PAUSE)
        return True

    def _synchronise(self, seconds: float) -> Waits:
        self._told_time = False
        seconds_of_clock, us = divmod(self._vehicle.clock_us, US)
        self.session.say(Timestamp(struct.pack("<iI", seconds_of_clock, us * 1000)))
        return (yield from self._listen(seconds, lambda: self._told_time))

    def _serve(self) -> Generator[None, None, None]:
        """Publish and read, until the agent is silent for too long."""
        asked_at = rated_at = pinged_at = self._now_us
        asked_at -= round(SYNC_PERIOD * US)
        missed, flows, self._received, self._answered = 0, False, 0, False
        while missed < MISSED:
            until = self._now_us + round(TURN * US)
            while self._now_us < until and not self._vehicle.is_due(self._now_us):
                yield
            for row, sample in self._vehicle.take_samples(self._now_us, self._offset_us):
                self.session.publish(row.number << 4 | Kind.WRITER, sample)
            while self._inbox:
                self._read(self._inbox.popleft())
            asks = self._vehicle.synchronises and self._now_us - asked_at >= SYNC_PERIOD * US
            if asks and (yield from self._synchronise(TURN)) and self._samples >= SYNC_SAMPLES:
                asked_at = self._now_us
            if self._now_us - rated_at > RATE_PERIOD * US:
                rated_at, flows, self._received = self._now_us, self._received > 0, 0
            if flows:
                missed, pinged_at = 0, self._now_us
            elif self._now_us - pinged_at > RATE_PERIOD * US:
                pinged_at = self._now_us
                missed = 0 if self._answered else missed + 1
                yield from self._ask(lambda: self.session.say(GetInfo(PING_REQUEST, THE_AGENT)))
            yield  # the next turn begins with what is published after this one

    def _ask(self, ask: Callable[[], None]) -> Waits:
        """Whether the agent answers what it is asked."""
        self._answered = False
        ask()
        return (yield from self._listen(ANSWER_WITHIN, lambda: self._answered))

    def _listen(self, seconds: float, met: Callable[[], bool]) -> Waits:
        """Read what comes until a condition is met, so many seconds at most; whether it was."""
        until = self._now_us + round(seconds * US)
        self._listens = True
        while True:
            while self._inbox and not met():
                self._read(self._inbox.popleft())
            if met() or self._now_us >= until:
                self._listens = False
                return met()
            self.session.remind(self._now_us)
            yield

    def _sleep(self, seconds: float) -> Generator[None, None, None]:
        until = self._now_us + round(seconds * US)
        while self._now_us < until:
            yield

    def _read(self, datagram: bytes) -> None:
        for said in self.session.take(datagram):
            if isinstance(said, Data):
                if said.object in self._topics and self.serves:
                    self._received += len(said.sample)
                    self._vehicle.take(self._topics[said.object], said.sample, self._offset_us)
            elif isinstance(said, Status):
                self._statuses[said.request] = said.status
            elif isinstance(said, TimestampReply):
                self._take_time(said)
            elif isinstance(said, Info):
                self._answered = self._answered or said.alive or not self._begun
            elif isinstance(said, StatusAgent):
                self._answered = True

    def _take_time(self, said: TimestampReply) -> None:
        """The agent's clock, as PX4's Timesync takes it, without its smoothing."""
        self._told_time = True
        now_us = self._vehicle.clock_us
        asked_us, agents_us = (_us(each) for each in (said.originated, said.received))
        if agents_us <= 0:
            return
        round_trip, observed = now_us - asked_us, (asked_us + now_us - 2 * agents_us) // 2
        if round_trip < SYNC_ROUND_TRIP * US:
            self._samples += 1
            self._offset_us = -observed
        self._vehicle.notice_time(observed, -self._offset_us, round_trip)


def _us(time: bytes) -> int:
    """us of a time as it stands on the wire."""
    seconds, nanoseconds = struct.unpack("<iI", time)
    return int(seconds) * US + int(nanoseconds) // 1000
