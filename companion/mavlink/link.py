"""The conversation with one vehicle, without sockets or clocks.

Who it is, heartbeats, commands with acknowledgement and retry, stream intervals, time synchronisation.

Bytes go out through ``outgoing``; every door takes ``now`` (s, our monotonic clock).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from companion.mavlink.codec import Encoder, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.vehicle import Mode

HEARTBEAT = message("HEARTBEAT")
COMMAND_LONG = message("COMMAND_LONG")
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

ARM_DISARM = 400
TAKE_OFF = 22
LAND = 21
SET_MODE = 176
SET_MESSAGE_INTERVAL = 511
REQUEST_MESSAGE = 512
CUSTOM_MODE_ENABLED = 1.0

HEARTBEAT_PERIOD = 1.0
TIMESYNC_PERIOD = 0.5
ROUND_TRIPS = 9
"""of which the middle one counts: one that waited in a queue says nothing, a link that has become slower does."""
RETRY_UNANSWERED = 0.5
RETRY_REFUSED = 1.0
RETRY_ACCEPTED = 5.0
"""s until a command that stays wanted is sent again: unanswered, refused, accepted without effect."""

SET_UP_TRIES = 10
COMPANION_GONE = 3.0
"""s without its heartbeat after which another companion is gone."""


@dataclass(frozen=True, slots=True)
class Command:
    """A COMMAND_LONG: its id and seven parameters."""

    id: int
    parameters: tuple[float, ...] = ()

    @property
    def padded(self) -> tuple[float, ...]:
        """Seven parameters, zero where not given."""
        return self.parameters + (0.0,) * (7 - len(self.parameters))


UNUSED = (math.nan,) * 7


def set_mode(mode: Mode) -> Command:
    """Asks for a flight mode."""
    return Command(SET_MODE, (CUSTOM_MODE_ENABLED, float(mode.main), float(mode.sub)))


ARM = Command(ARM_DISARM, (1.0,))
DISARM = Command(ARM_DISARM, (0.0,))
AUTO_TAKE_OFF = Command(TAKE_OFF, UNUSED)
AUTO_LAND = Command(LAND, UNUSED)


def request(msgid: int) -> Command:
    """Asks for a message once."""
    return Command(REQUEST_MESSAGE, (float(msgid),))


def stream(msgid: int, rate: float) -> Command:
    """Asks for a message at ``rate`` Hz."""
    return Command(SET_MESSAGE_INTERVAL, (float(msgid), float(round(1e6 / rate))))


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
class _Pending:
    command: Command
    sent_at: float
    tries: int = 1
    result: int | None = None


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
    _wanted: _Pending | None = None
    _set_up: list[Command] = field(default_factory=list)
    _setting_up: _Pending | None = None
    _heartbeat_at: float = -math.inf
    _timesync_at: float = -math.inf

    def send(self, fmt: Format, values: tuple[Value, ...]) -> None:
        """Queue one message."""
        self.outgoing.append(self.encoder.encode(fmt, values))

    @property
    def is_set_up(self) -> bool:
        """Whether the vehicle answered everything that is asked once, or will not."""
        return self.identity is not None and not self._set_up

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
            self.texts.append((severity, text.split(b"\0")[0].decode("utf-8", "replace").rstrip("\t")))
        return None

    def want(self, command: Command | None, now: float) -> None:
        """What is asked of the vehicle from now on. Sent at once when new, and again until it is no longer wanted."""
        pending = self._wanted
        if command is None:
            self._wanted = None
        elif pending is None or pending.command != command:
            self._wanted = _Pending(command, now)
            self._command(command, 0)
        else:
            waited = now - pending.sent_at
            wait = (
                RETRY_UNANSWERED
                if pending.result is None
                else RETRY_ACCEPTED
                if pending.result in (0, 5)
                else RETRY_REFUSED
            )
            if waited >= wait:
                confirmation = pending.tries if pending.result is None else 0
                self._wanted = _Pending(command, now, pending.tries + 1)
                self._command(command, min(confirmation, 255))

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
        if self._setting_up is None and self._set_up:
            self._setting_up = _Pending(self._set_up[0], now)
            self._command(self._set_up[0], 0)
        elif self._setting_up is not None and now >= self._setting_up.sent_at + RETRY_UNANSWERED:
            tries = self._setting_up.tries
            if tries >= SET_UP_TRIES:
                self._next_set_up(now)
                return
            self._setting_up = _Pending(self._set_up[0], now, tries + 1)
            self._command(self._set_up[0], min(tries, 255))

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        due = [self._heartbeat_at + HEARTBEAT_PERIOD]
        if self.identity is not None:
            due.append(self._timesync_at + TIMESYNC_PERIOD)
            if self._setting_up is not None:
                due.append(self._setting_up.sent_at + RETRY_UNANSWERED)
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
            self._set_up = [request(AUTOPILOT_VERSION.id), *self.streams]
            self.on_timer(now)
        elif frame.system != self.identity.system:
            self.others[frame.system] = autopilot

    def _acknowledged(self, frame: Frame, now: float) -> tuple[Command, int] | None:
        command, result, _, _, system, component = frame.values
        if (system, component) not in ((0, 0), (self.encoder.system, self.encoder.component)):
            return None
        if self._setting_up is not None and command == self._setting_up.command.id:
            # the autopilot answers in order, so the answer is to the one that was sent last
            if result != 1 or self._setting_up.tries > 3:
                self._next_set_up(now)
            return None
        pending = self._wanted
        if pending is not None and command == pending.command.id and pending.result is None:
            pending.result = result
            return pending.command, result
        return None

    def _next_set_up(self, now: float) -> None:
        self._set_up.pop(0)
        self._setting_up = None
        self.on_timer(now)

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
