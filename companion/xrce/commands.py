"""Setpoints -> samples for PX4, and the gate before them: section 6 of what kills a vehicle at this level, as code.

PX4 holds the last motor commands for as long as offboard_control_mode comes, and takes commands of anybody in any mode.
Therefore mode and command go out in one message or not at all; a command only where PX4 itself says, over both of its
links, that it flies on it; and before that the mode alone, which is what PX4 wants to see before OFFBOARD.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from companion.vehicle import OutputLevel, Setpoint
from companion.xrce.agent import Agent, Reader, Sample
from companion.xrce.command_message import FLAG, MODE, TOPICS, CommandMessage
from companion.xrce.flight_mode import FlightMode
from companion.xrce.topics import Layout, Topic, TopicError

CONTROL_MODE_LASTS = 0.7
"""s that a vehicle_control_mode counts: PX4 publishes it at 2 Hz, and within 22 ms of a change (xrce.md, section 6)."""
KEPT_BACK_USUALLY = 10
"""Commands kept back where one link says it before the other, at the beginning and the end (engineering choice)."""
CONTROL_MODE = "vehicle_control_mode"


@dataclass(slots=True)
class Commands:
    """What goes to PX4 at one ``level`` over ``agent``.

    ``tap``: called with the time, whether it goes to PX4, and the bytes of each datagram. ``refusal``: why this PX4
    cannot be commanded over it. ``flight_mode``: ours, flown in the place of OFFBOARD; None: OFFBOARD. ``sent``:
    commands so far; ``kept_back``: those that the gate kept back while PX4 said that it flies in that mode. ``raises``:
    whether what fails in here is raised; False once the last resort has begun, whose setpoints go out all the same.
    """

    level: OutputLevel
    agent: Agent = field(default_factory=Agent)
    tap: Callable[[float, bool, bytes], None] | None = None
    refusal: str | None = None
    flight_mode: FlightMode | None = None
    sent: int = 0
    kept_back: int = 0
    raises: bool = True
    _in_offboard: bool = False
    _follows: bool = False
    _said_at: float = -math.inf
    _message: CommandMessage | None = None

    def receive(self, data: bytes, now: float) -> None:
        """Take in a datagram. Nothing is acted on: what PX4 says opens and closes the gate."""
        try:
            if self.tap is not None:
                self.tap(now, False, data)
            for sample in self.agent.receive(data, now):
                self._take(sample, now)
        except Exception:
            if self.raises:
                raise

    def datagrams(self, now: float) -> list[bytes]:
        """What is to be sent at ``now``."""
        datagrams: list[bytes] = []
        try:
            if self.flight_mode is not None and self.refusal is None:
                self._try(lambda mode: mode.write(self.agent, now))
            datagrams = self.agent.datagrams(now)
            if self.tap is not None:
                for data in datagrams:
                    self.tap(now, True, data)
        except Exception:
            if self.raises:
                raise
        return datagrams

    def next_timer(self) -> float:
        """s, when ``datagrams`` has something without anything coming in."""
        return self.agent.next_timer()

    @property
    def is_calm(self) -> bool:
        """Whether commands go out and nothing else is under way: PX4's client need not be answered at once."""
        return not self.agent.keeps_time and self.agent.next_timer() == math.inf

    def tell(self, can_run: bool, over: bool, completed: bool) -> None:
        """Where the flight stands, for a flight mode of ours: it may be selected; it is over, and how."""
        if self.flight_mode is not None:
            self.flight_mode.can_run = can_run
            if over:
                self.flight_mode.finish(completed=completed)

    def _take(self, sample: Sample, now: float) -> None:
        """Take in what PX4 says of its controllers at ``now`` (s)."""
        if sample.topic.name == CONTROL_MODE and (layout := self._layout(sample.topic)) is not None:
            said = layout.decode(sample.cdr)
            if said is not None:
                self._said_at = now
                self._in_offboard = said["flag_control_offboard_enabled"]
                self._follows = follows(said, self.level)
        elif self.flight_mode is not None:
            self._try(lambda mode: mode.take(self.agent, sample, now))

    def _try(self, step: Callable[[FlightMode], None]) -> None:
        """A step of our flight mode; a version of its topics that is not known here is a refusal."""
        try:
            if self.flight_mode is not None:
                step(self.flight_mode)
        except TopicError as error:
            self.refusal = str(error)

    @property
    def missing(self) -> str | None:
        """What is waited for from PX4's client, in words that follow "for the vehicle to say"; None: nothing."""
        if self.agent.is_adopted:
            return (
                "that its XRCE client has begun a new session: it still is in that of an agent that is gone, such as a "
                "companion before a restart, and begins anew within 15 s; until then it is only listened to"
            )
        lacking = self._lacking
        if lacking is None:
            return None
        return f"that its XRCE client has {lacking} (UXRCE_DDS_CFG set, this address its agent's, PX4 1.15 or later?)"

    @property
    def _lacking(self) -> str | None:
        """The first topic that PX4's client does not read, or publish, yet; None: everything is there."""
        lacking = None if self.flight_mode is None else self.flight_mode.missing(self.agent)
        if lacking is not None:
            return lacking
        for name in (MODE, *TOPICS[self.level]):
            reader = self.agent.reading.get(name)
            if reader is None or self._layout(reader.topic) is None:
                return name
        return None if self._said_at > -math.inf else CONTROL_MODE

    def send(self, setpoint: Setpoint, t_boot: float, now: float, says_so: bool) -> bool:
        """Queue a setpoint with the time (s, the vehicle's) of its state; whether the command is in what goes out.
        ``says_so``: the vehicle has just said over MAVLink that it is in OFFBOARD, or in our own mode."""
        mode, fresh = self.flight_mode, now - self._said_at <= CONTROL_MODE_LASTS
        flies = self._in_offboard if mode is None else mode.is_selected(now)
        done = fresh and flies and self._follows and says_so and self._write(setpoint, t_boot)
        if done and mode is not None:
            mode.notice_command(now)
        if mode is None and fresh and not flies:
            self._write_mode()
        self.agent.keeps_time = not done  # see there
        self.sent += done
        self.kept_back += flies and not done
        return done

    def rehearse(self, setpoint: Setpoint, t_boot: float) -> None:
        """Encode a command, and forget it: the next finds code and data in the caches."""
        self._encoded(setpoint, t_boot)

    def words(self) -> list[str]:
        """What was lost or refused so far, for people."""
        found, counters = [], self.agent.counters
        if counters.lost or counters.late or counters.garbage or counters.strange:
            found.append(
                f"XRCE: beside {counters.messages} messages of PX4's client, {counters.lost} were lost and "
                f"{counters.late} late, {counters.garbage} datagrams made no sense and {counters.strange} came from "
                "another session or client; they were skipped"
            )
        if counters.orphaned:
            found.append(
                f"XRCE: {counters.orphaned} messages of PX4's client came in a session whose agent was gone; they were "
                "only counted"
            )
        if self.agent.sessions > 1:
            found.append(f"XRCE: PX4's client began {self.agent.sessions} sessions; look at the line between the two")
        if self.kept_back > KEPT_BACK_USUALLY:
            found.append(
                f"XRCE: {self.kept_back} commands were kept back, {self.sent} sent: PX4 did not say over both of its "
                "links, and of late, that it flies on them"
            )
        return found

    def _write(self, setpoint: Setpoint, t_boot: float) -> bool:
        """Queue mode and command as one message. False: PX4 does not read all of it; then none is sent."""
        data = self._encoded(setpoint, t_boot)
        if data is not None:
            self.agent.queue(data)
        return data is not None

    def _write_mode(self) -> None:
        """Queue the mode alone, which is all that PX4 wants to see before OFFBOARD."""
        reader = self.agent.reading.get(MODE)
        layout = None if reader is None else self._layout(reader.topic)
        if layout is not None:
            self.agent.write([(MODE, layout.encode(**{FLAG[self.level]: True}))])

    def _encoded(self, setpoint: Setpoint, t_boot: float) -> bytes | None:
        """The next message with a setpoint; None: PX4 does not read all of it, or its session is over."""
        place, reading = self.agent.place, self.agent.reading
        topics = TOPICS[self.level]
        readers = [reading.get(name) for name in ((MODE, *topics) if self.flight_mode is None else topics)]
        if place is None:
            return None
        message = self._message
        if message is None or message.session != place[0] or message.readers != readers:
            message = self._message = self._compiled(place[0], readers)
        return None if message is None else message.encode(place[1], setpoint, round(t_boot * 1e6))

    def _compiled(self, session: int, readers: Sequence[Reader | None]) -> CommandMessage | None:
        """The message for these readers; None: one is not there, or in a version that is not known here."""
        there = [each for each in readers if each is not None]
        layouts = [layout for each in there if (layout := self._layout(each.topic)) is not None]
        return CommandMessage(self.level, session, there, layouts) if len(layouts) == len(readers) else None

    def _layout(self, topic: Topic) -> Layout | None:
        """A topic's layout. None: this PX4's is not known here, which is remembered as a refusal."""
        try:
            return self.agent.layout(topic)
        except TopicError as error:
            self.refusal = str(error)
            return None


def follows(control_mode: dict[str, Any], level: OutputLevel) -> bool:
    """Whether PX4's controllers take setpoints of a level: what stands above it is off, what stands below it is on."""
    said = {name.removeprefix("flag_control_").removesuffix("_enabled"): value for name, value in control_mode.items()}
    match level:
        case OutputLevel.MOTORS:
            return not said["allocation"]
        case OutputLevel.TORQUES:
            return bool(said["allocation"]) and not said["rates"]
        case OutputLevel.RATES:
            return bool(said["rates"]) and not said["attitude"]
        case OutputLevel.ATTITUDE:
            return bool(said["attitude"]) and not any(said[name] for name in ("position", "velocity", "altitude"))
