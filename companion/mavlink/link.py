"""The conversation with one vehicle, without sockets or clocks.

Who it is, heartbeats, time synchronisation; what is asked of it is in ``requests``.

Bytes go out through ``outgoing``; every door takes ``now`` (s, our monotonic clock).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from companion.mavlink.clock import VehicleClock
from companion.mavlink.codec import Encoder, Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink.peer import HEARTBEAT, Peers, vehicle_of
from companion.mavlink.requests import COMMAND_LONG, Command, Requests, request
from companion.mavlink.signing import Signing
from companion.mavlink_common import (
    MAV_AUTOPILOT_INVALID,
    MAV_AUTOPILOT_PX4,
    MAV_COMP_ID_AUTOPILOT1,
    MAV_COMP_ID_CAMERA,
    MAV_COMP_ID_ONBOARD_COMPUTER,
    MAV_PROTOCOL_CAPABILITY_SET_ACTUATOR_TARGET,
    MAV_STATE_ACTIVE,
    MAV_TYPE_ONBOARD_CONTROLLER,
)
from companion.plain_text import printable

COMMAND_ACK = message("COMMAND_ACK")
TIMESYNC = message("TIMESYNC")
AUTOPILOT_VERSION = message("AUTOPILOT_VERSION")
STATUSTEXT = message("STATUSTEXT")
WANTED = frozenset({HEARTBEAT.id, COMMAND_ACK.id, TIMESYNC.id, AUTOPILOT_VERSION.id, STATUSTEXT.id})

HEARTBEAT_PERIOD = 1.0
"""s, by the MAVLink specification."""
TIMESYNC_PERIOD = 0.25
ROUND_TRIPS = 9
"""of which the middle one counts: one that waited in a queue says nothing, a link that has become slower does."""
AT_LEAST = 3
"""The last of them, of which the least counts where that is more: a link that goes on becoming slower."""
COMPANION_GONE = 3.0
"""s without its heartbeat after which another companion is gone."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Who answered: MAVLink ids, autopilot kind, and what it says of itself once asked (None until then).

    ``uid``: of the hardware, hexadecimal; None where it does not say."""

    system: int
    autopilot: int
    type: int
    capabilities: int | None = None
    version: tuple[int, int, int] | None = None
    uid: str | None = None

    @property
    def direct_motors(self) -> bool | None:
        """Whether it takes motor commands; None until it has said."""
        return (
            None if self.capabilities is None else bool(self.capabilities & MAV_PROTOCOL_CAPABILITY_SET_ACTUATOR_TARGET)
        )


@dataclass(slots=True)
class Link:
    """One companion's side of the conversation.

    ``identity``: None until a multirotor's autopilot was heard. ``others``: further ones on its own link, by system id.
    ``peers``: which source is the vehicle's. ``replaced``: uids of another vehicle that answered under the same id.
    ``round_trip``: s, the median of the last few, more where it grows.
    ``clock``: how late its states are. ``texts``: what the vehicle said
    in words since they were last taken.
    """

    streams: tuple[Command, ...] = ()
    identity: Identity | None = None
    others: dict[int, int] = field(default_factory=dict)
    peers: Peers = field(default_factory=Peers)
    replaced: tuple[str, str] | None = None
    _companion_at: float = -math.inf
    round_trip: float | None = None
    clock: VehicleClock = field(default_factory=VehicleClock)
    _round_trips: tuple[float, ...] = ()
    texts: list[tuple[int, str]] = field(default_factory=list)
    outgoing: list[bytes] = field(default_factory=list)
    encoder: Encoder = field(default_factory=lambda: Encoder(1, MAV_COMP_ID_ONBOARD_COMPUTER))
    requests: Requests = field(init=False)
    _heartbeat_at: float = -math.inf
    _timesync_at: float = -math.inf

    def __post_init__(self) -> None:
        self.requests = Requests(self._command)

    def sign(self, signing: Signing) -> None:
        """From now on what we send is signed, and others are looked at only where they sign."""
        self.encoder.signing = self.peers.signing = signing

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
        return self.identity is not None and self.identity.autopilot == MAV_AUTOPILOT_PX4

    def companions(self, now: float) -> int:
        """How many others of our kind were heard of late, in the vehicle's own system."""
        return int(now - self._companion_at < COMPANION_GONE)

    def of_vehicle(self, frame: Frame) -> bool:
        """Whether the vehicle's autopilot sent this frame."""
        identity = self.identity
        return identity is not None and frame.system == identity.system and frame.component == MAV_COMP_ID_AUTOPILOT1

    def _of_camera(self, frame: Frame) -> bool:
        """Whether the vehicle's camera sent this frame."""
        identity = self.identity
        return identity is not None and frame.system == identity.system and frame.component == MAV_COMP_ID_CAMERA

    def receive(self, frame: Frame, now: float) -> tuple[Command, int] | None:
        """Take a frame in. The command that stands wanted and its MAV_RESULT, where the frame answers it."""
        fmt = frame.format
        if fmt.id not in WANTED:
            return None
        if fmt is HEARTBEAT:
            self._meet(frame, now)
        elif fmt is COMMAND_ACK and self._of_camera(frame):
            return self._match_acknowledgement(frame, now)
        elif not self.of_vehicle(frame):
            return None
        elif fmt is COMMAND_ACK:
            return self._match_acknowledgement(frame, now)
        elif fmt is TIMESYNC:
            self._synchronise(frame, now)
        elif fmt is AUTOPILOT_VERSION:
            self._identify(frame)
        elif fmt is STATUSTEXT:
            severity, text = frame.values[:2]
            self.texts.append((severity, printable(text.split(b"\0")[0].decode("utf-8", "replace").rstrip("\t"))))
        return None

    def on_timer(self, now: float) -> None:
        """Send what is due."""
        if self.encoder.signing is not None:
            self.encoder.signing.advance(now)
        if now >= self._heartbeat_at + HEARTBEAT_PERIOD:
            self._heartbeat_at = now
            self.send(HEARTBEAT, (0, MAV_TYPE_ONBOARD_CONTROLLER, MAV_AUTOPILOT_INVALID, 0, MAV_STATE_ACTIVE, 3))
        if self.identity is None:
            return
        if now >= self._timesync_at + TIMESYNC_PERIOD:
            self._timesync_at = now
            self.send(TIMESYNC, (0, round(now * 1e9)))
        self.requests.on_timer(now)

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        heartbeat_at = self._heartbeat_at + HEARTBEAT_PERIOD
        if self.identity is None:
            return heartbeat_at
        return min(heartbeat_at, self._timesync_at + TIMESYNC_PERIOD, self.requests.next_timer())

    def on_new_source(self, now: float) -> None:
        """The vehicle was met at another source: it may have been started again, so everything is asked once more."""
        if self.identity is not None and not self.peers.flying:
            self._introduce(now)

    def _meet(self, frame: Frame, now: float) -> None:
        identity, vehicle = self.identity, vehicle_of(frame)
        if vehicle is None:
            if frame.component == MAV_COMP_ID_ONBOARD_COMPUTER and frame.values[1] == MAV_TYPE_ONBOARD_CONTROLLER:
                self._hear_companion(frame.system, now)
        elif identity is None and vehicle.is_multirotor:
            self.identity = Identity(frame.system, vehicle.autopilot, vehicle.kind)
            self.peers.system = self.encoder.system = frame.system
            self._introduce(now)
        elif identity is None or frame.system != identity.system:
            self.peers.bystander(str(vehicle))
            if vehicle.is_multirotor:
                self.others[frame.system] = vehicle.autopilot

    def _hear_companion(self, system: int, now: float) -> None:
        """Another companion flies our vehicle, or one of another system is forwarded. Our own are never sent back."""
        if self.identity is not None and system == self.identity.system:
            self._companion_at = now
        else:
            self.peers.bystander(f"a companion of system {system}")

    def _introduce(self, now: float) -> None:
        self.requests.set_up([request(AUTOPILOT_VERSION.id), *self.streams])
        self.on_timer(now)

    def _match_acknowledgement(self, frame: Frame, now: float) -> tuple[Command, int] | None:
        command, result, _, _, system, component = frame.values
        if (system, component) not in ((0, 0), (self.encoder.system, self.encoder.component)):
            return None
        return self.requests.match_acknowledgement(command, result, now, frame.component)

    def _identify(self, frame: Frame) -> None:
        values = AUTOPILOT_VERSION.named(frame.values)
        version = values["flight_sw_version"]
        assert self.identity is not None
        uid = _uid(values)
        if uid is not None and self.identity.uid not in (None, uid):
            self.replaced = (str(self.identity.uid), uid)
            return
        self.identity = replace(
            self.identity,
            capabilities=values["capabilities"],
            version=(version >> 24, version >> 16 & 0xFF, version >> 8 & 0xFF),
            uid=uid,
        )

    def _synchronise(self, frame: Frame, now: float) -> None:
        tc1, ts1 = frame.values
        if tc1 == 0:
            return  # the vehicle's own request; it needs no answer
        round_trip = now - ts1 * 1e-9
        if 0.0 <= round_trip < 10.0:
            self._round_trips = (*self._round_trips[1 - ROUND_TRIPS :], round_trip)
            self.clock.synchronise(ts1 * 1e-9, tc1 * 1e-9, now)
            middle = sorted(self._round_trips)[len(self._round_trips) // 2]
            self.round_trip = max(middle, min(self._round_trips[-AT_LEAST:]))

    def _command(self, command: Command, confirmation: int) -> None:
        assert self.identity is not None
        target = (self.identity.system, command.component)
        self.send(COMMAND_LONG, (*command.padded, command.id, *target, confirmation))


def _uid(values: dict[str, Value]) -> str | None:
    """The hardware's number in AUTOPILOT_VERSION: the long one where it is given."""
    if any(values["uid2"]):
        return bytes(values["uid2"]).hex()
    return f"{values['uid']:016x}" if values["uid"] else None
