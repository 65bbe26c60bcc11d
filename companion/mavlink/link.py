"""The conversation with one vehicle, without sockets or clocks.

Who it is, heartbeats, time synchronisation; what is asked of it is in ``requests``.

Bytes go out through ``outgoing``; every door takes ``now`` (s, our monotonic clock).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from companion.mavlink.codec import Encoder, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink.requests import COMMAND_LONG, Command, Requests, request
from companion.plain_text import printable

HEARTBEAT = message("HEARTBEAT")
COMMAND_ACK = message("COMMAND_ACK")
TIMESYNC = message("TIMESYNC")
AUTOPILOT_VERSION = message("AUTOPILOT_VERSION")
STATUSTEXT = message("STATUSTEXT")
WANTED = frozenset({HEARTBEAT.id, COMMAND_ACK.id, TIMESYNC.id, AUTOPILOT_VERSION.id, STATUSTEXT.id})

AUTOPILOT_COMPONENT = 1
ONBOARD_COMPUTER = 191
TYPE_ONBOARD_CONTROLLER = 18
TYPE_GCS = 6
AUTOPILOT_INVALID = 8
AUTOPILOT_PX4 = 12
STATE_ACTIVE = 4
CAPABILITY_ACTUATORS = 1024
"""MAV_PROTOCOL_CAPABILITY_SET_ACTUATOR_TARGET."""

HEARTBEAT_PERIOD = 1.0
TIMESYNC_PERIOD = 0.5
ROUND_TRIPS = 9
"""of which the middle one counts: one that waited in a queue says nothing, a link that has become slower does."""
COMPANION_GONE = 3.0
"""s without its heartbeat after which another companion is gone."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Who answered: MAVLink ids, autopilot kind, and what it says it can do once asked (None until then)."""

    system: int
    autopilot: int
    type: int
    capabilities: int | None = None
    version: tuple[int, int, int] | None = None

    @property
    def direct_motors(self) -> bool | None:
        """Whether it takes motor commands; None until it has said."""
        return None if self.capabilities is None else bool(self.capabilities & CAPABILITY_ACTUATORS)


@dataclass(slots=True)
class Link:
    """One companion's side of the conversation.

    ``identity``: None until an autopilot was heard. ``others``: further autopilots on the link, by system id.
    ``round_trip``: s, the median of the last few. ``texts``: what the vehicle said in words since they were last taken.
    """

    streams: tuple[Command, ...] = ()
    identity: Identity | None = None
    others: dict[int, int] = field(default_factory=dict)
    _companion_at: float = -math.inf
    round_trip: float | None = None
    _round_trips: tuple[float, ...] = ()
    texts: list[tuple[int, str]] = field(default_factory=list)
    outgoing: list[bytes] = field(default_factory=list)
    encoder: Encoder = field(default_factory=lambda: Encoder(1, ONBOARD_COMPUTER))
    requests: Requests = field(init=False)
    _heartbeat_at: float = -math.inf
    _timesync_at: float = -math.inf

    def __post_init__(self) -> None:
        self.requests = Requests(self._command)

    def send(self, fmt: Format, values: tuple[Value, ...]) -> None:
        """Queue one message."""
        self.outgoing.append(self.encoder.encode(fmt, values))

    @property
    def is_set_up(self) -> bool:
        """Whether the vehicle answered everything that is asked once, or will not."""
        return self.identity is not None and self.requests.is_set_up

    @property
    def is_px4(self) -> bool:
        """Whether the autopilot that answered is PX4."""
        return self.identity is not None and self.identity.autopilot == AUTOPILOT_PX4

    def companions(self, now: float) -> int:
        """How many others of our kind were heard of late."""
        return int(now - self._companion_at < COMPANION_GONE)

    def of_vehicle(self, frame: Frame) -> bool:
        """Whether the vehicle's autopilot sent this frame."""
        identity = self.identity
        return identity is not None and frame.system == identity.system and frame.component == AUTOPILOT_COMPONENT

    def receive(self, frame: Frame, now: float) -> tuple[Command, int] | None:
        """Take a frame in. The command that stands wanted and its MAV_RESULT, where the frame answers it."""
        if frame.format is HEARTBEAT:
            self._meet(frame, now)
        elif not self.of_vehicle(frame):
            return None
        elif frame.format is COMMAND_ACK:
            return self._acknowledged(frame, now)
        elif frame.format is TIMESYNC:
            self._synchronise(frame, now)
        elif frame.format is AUTOPILOT_VERSION:
            self._identify(frame)
        elif frame.format is STATUSTEXT:
            severity, text = frame.values[:2]
            self.texts.append((severity, printable(text.split(b"\0")[0].decode("utf-8", "replace").rstrip("\t"))))
        return None

    def on_timer(self, now: float) -> None:
        """Send what is due."""
        if now >= self._heartbeat_at + HEARTBEAT_PERIOD:
            self._heartbeat_at = now
            self.send(HEARTBEAT, (0, TYPE_ONBOARD_CONTROLLER, AUTOPILOT_INVALID, 0, STATE_ACTIVE, 3))
        if self.identity is None:
            return
        if now >= self._timesync_at + TIMESYNC_PERIOD:
            self._timesync_at = now
            self.send(TIMESYNC, (0, round(now * 1e9)))
        self.requests.on_timer(now)

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        due = [self._heartbeat_at + HEARTBEAT_PERIOD]
        if self.identity is not None:
            due += (self._timesync_at + TIMESYNC_PERIOD, self.requests.next_timer())
        return min(due)

    def _meet(self, frame: Frame, now: float) -> None:
        _, kind, autopilot, _, _, _ = frame.values
        if frame.component == ONBOARD_COMPUTER and kind == TYPE_ONBOARD_CONTROLLER:
            self._companion_at = now  # our own are never sent back to us
        if frame.component != AUTOPILOT_COMPONENT or autopilot == AUTOPILOT_INVALID or kind == TYPE_GCS:
            return
        if self.identity is None:
            self.identity = Identity(frame.system, autopilot, kind)
            self.encoder.system = frame.system
            self.requests.set_up([request(AUTOPILOT_VERSION.id), *self.streams])
            self.on_timer(now)
        elif frame.system != self.identity.system:
            self.others[frame.system] = autopilot

    def _acknowledged(self, frame: Frame, now: float) -> tuple[Command, int] | None:
        command, result, _, _, system, component = frame.values
        if (system, component) not in ((0, 0), (self.encoder.system, self.encoder.component)):
            return None
        return self.requests.acknowledged(command, result, now)

    def _identify(self, frame: Frame) -> None:
        values = AUTOPILOT_VERSION.named(frame.values)
        version = values["flight_sw_version"]
        assert self.identity is not None
        self.identity = Identity(
            self.identity.system,
            self.identity.autopilot,
            self.identity.type,
            values["capabilities"],
            (version >> 24, version >> 16 & 0xFF, version >> 8 & 0xFF),
        )

    def _synchronise(self, frame: Frame, now: float) -> None:
        tc1, ts1 = frame.values
        if tc1 == 0:
            return  # the vehicle's own request; it needs no answer
        round_trip = now - ts1 * 1e-9
        if 0.0 <= round_trip < 10.0:
            self._round_trips = (*self._round_trips[1 - ROUND_TRIPS :], round_trip)
            self.round_trip = sorted(self._round_trips)[len(self._round_trips) // 2]

    def _command(self, command: Command, confirmation: int) -> None:
        assert self.identity is not None
        target = (self.identity.system, AUTOPILOT_COMPONENT)
        self.send(COMMAND_LONG, (*command.padded, command.id, *target, confirmation))
