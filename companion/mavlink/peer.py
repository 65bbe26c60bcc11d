"""Who is our vehicle: one source of bytes, one system, component 1, a multirotor. Who is not is counted, and nobody.

Every datagram comes with its source: (host, port) of a UDP socket, or one constant for a serial line. What comes from
the vehicle's source is the vehicle's link, with what PX4 forwards on it. What comes from elsewhere is only looked at
for a vehicle that is met for the first time, or again after it was silent.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import NamedTuple

from companion import mavlink_common as mav
from companion.mavlink.codec import MAGIC_V1, MAGIC_V2, Decoder, Frame
from companion.mavlink.counters import Counters
from companion.mavlink.dialect import message
from companion.mavlink.signing import Signing
from companion.mavlink_common import MAV_AUTOPILOT_INVALID, MAV_COMP_ID_AUTOPILOT1, MAV_TYPE_GCS

Source = Hashable
"""Where bytes come from and go to: (host, port), LINE, or an endpoint's number in lockstep."""
Received = tuple[bytes, Source]
"""What a port hands over: a datagram, or some bytes of a line, and its source."""
LINE = "line"
"""The one source of a serial line."""

HEARTBEAT, ODOMETRY, CURRENT_MODE = message("HEARTBEAT"), message("ODOMETRY"), message("CURRENT_MODE")
MULTIROTORS = frozenset(
    {
        mav.MAV_TYPE_QUADROTOR,
        mav.MAV_TYPE_COAXIAL,
        mav.MAV_TYPE_HEXAROTOR,
        mav.MAV_TYPE_OCTOROTOR,
        mav.MAV_TYPE_TRICOPTER,
        mav.MAV_TYPE_DODECAROTOR,
        mav.MAV_TYPE_DECAROTOR,
        mav.MAV_TYPE_GENERIC_MULTIROTOR,
    }
)
"""The MAV_TYPE of them."""

PEER_SILENT = 2.0
"""s without a byte from the vehicle's source, after which it may be met at another one: it was started again."""
WINDOW = 0.1
"""s over which what strangers send is bounded."""
LOOKED_AT, LOOKED_AT_UNMET = 8, 400
"""Datagrams of strangers that are decoded in a WINDOW: while the vehicle speaks, and while it is not known or silent.
At 10 us each 0.1 and 4 % of a core. A datagram that begins as an autopilot's heartbeat has a budget of its own."""
FRAME_MAX = 280
"""bytes of MAVLink's longest frame: more of a stranger's datagram is not looked at while the vehicle speaks."""
STRANGERS_MAX = 32
"""Sources that are told apart; what others send is counted together."""


class Vehicle(NamedTuple):
    """A vehicle by its heartbeat. ``kind``: MAV_TYPE; ``autopilot``: MAV_AUTOPILOT."""

    system: int
    kind: int
    autopilot: int

    @property
    def is_multirotor(self) -> bool:
        """Whether it can be ours."""
        return self.kind in MULTIROTORS

    def __str__(self) -> str:
        name = "multirotor" if self.is_multirotor else mav.VEHICLE_WORDS.get(self.kind, "vehicle")
        return f"{name} (system {self.system}, MAV_TYPE {self.kind})"


LOOKED_FOR = frozenset({HEARTBEAT.id, ODOMETRY.id, CURRENT_MODE.id})


@dataclass(slots=True)
class Stranger:
    """Somebody at another source: what it sent, and what vehicle it says it is."""

    decoder: Decoder
    datagrams: int = 0
    vehicle: Vehicle | None = None


@dataclass(slots=True)
class Peers:
    """``heard``: the vehicle's source, None until it is met. ``to``: where our messages go; None: nowhere. ``called``:
    the only source it can be met at first, where the link was told one. ``flying``: the flight has begun. ``heard_at``:
    s, the last byte from the vehicle's source. ``signing``: what is not signed by it is not looked at."""

    heard: Source | None = None
    to: Source | None = None
    called: Source | None = None
    flying: bool = False
    system: int | None = None
    signing: Signing | None = None
    heard_at: float = -math.inf
    strangers: dict[Source, Stranger] = field(default_factory=dict)
    uncounted: int = 0
    bystanders: dict[str, int] = field(default_factory=dict)
    _rival: tuple[str, float] | None = None
    _window_ends: float = -math.inf
    _left: int = 0
    _heartbeats_left: int = 0

    def call(self, source: Source) -> None:
        """Talk to ``source`` from the start, and believe no other. A line has no other."""
        self.called = self.to = source
        if source == LINE:
            self.heard = source

    @property
    def rival(self) -> str | None:
        """A second candidate that was heard before the flight, in words: both speak. One that has fallen silent may be
        the same vehicle, started again."""
        if self._rival is None or self.heard_at <= self._rival[1]:
            return None
        return self._rival[0]

    @property
    def foreign(self) -> int:
        """Datagrams that came from elsewhere and had no effect."""
        return self.uncounted + sum(stranger.datagrams for stranger in self.strangers.values())

    def knock(self, data: bytes, source: Source, now: float) -> bool:
        """A datagram that is not from the vehicle's source. True where it makes its source the vehicle's, met now or
        met again: then it counts as the vehicle's. Its effect is nothing otherwise."""
        stranger = self.strangers.get(source)
        if stranger is None:
            if len(self.strangers) >= STRANGERS_MAX:
                self.uncounted += 1
                return False
            stranger = self.strangers[source] = Stranger(Decoder(wanted=LOOKED_FOR, signing=self.signing))
        stranger.datagrams += 1
        away = self.heard is None or now - self.heard_at > PEER_SILENT
        if not self._is_looked_at(data, now, away):
            return False
        replayed = 0 if self.signing is None else self.signing.refused.replayed
        frames = stranger.decoder.piece(data if away else data[:FRAME_MAX], now)
        if self.signing is not None and self.heard is self.to is None and self.signing.refused.replayed > replayed:
            self.to = source  # it has the key and its clock is behind: our own messages set it
        for frame in frames:
            if frame.component != MAV_COMP_ID_AUTOPILOT1:
                continue
            vehicle = vehicle_of(frame)
            if vehicle is not None:
                stranger.vehicle = vehicle
            if self._is_met(source, vehicle, away):
                self._meet(source, frame.system, now)
                return True
            self._compete(source, stranger.vehicle, frame, now)
        return False

    def words(self) -> list[str]:
        """Who was heard that is not our vehicle, a line each."""
        lines = [
            f"{stranger.vehicle or 'somebody'} at {source_words(source)}: {stranger.datagrams} datagrams without effect"
            for source, stranger in list(self.strangers.items())  # another thread may ask
        ]
        if self.uncounted:
            lines.append(f"others: {self.uncounted} datagrams without effect")
        if self.signing is not None and self.signing.refused.total:
            lines.append(f"{self.signing.refused}: without effect")
        return lines + [
            f"{who} on the vehicle's link: {count} heartbeats" for who, count in list(self.bystanders.items())
        ]

    def heard_words(self, own: Counters) -> str:
        """What was heard while no vehicle was met, and what to do. ``own``: of the called source."""
        vehicles = self._vehicles()
        if vehicles:
            return f"only what it cannot fly: {', '.join(vehicles)}; expected a multirotor"
        counters = [own, *(stranger.decoder.counters for stranger in self.strangers.values())]
        if self.signing is not None and self.signing.refused.total:
            return (
                f"{self.signing.refused}; give the vehicle this key with: companion vehicle sign, or fly without "
                "--signing-key if it does not sign"
            )
        messages = sum(each.frames + each.unknown for each in counters)
        garbage = sum(each.garbage_bytes for each in counters)
        return (
            f"{messages} MAVLink messages and {garbage} bytes of garbage, but no autopilot's heartbeat; is it on, and "
            "does it send here?"
        )

    def _vehicles(self) -> list[str]:
        """The vehicles that were heard and are not ours, in words."""
        elsewhere = [
            f"{stranger.vehicle} at {source_words(source)}"
            for source, stranger in list(self.strangers.items())
            if stranger.vehicle is not None
        ]
        return elsewhere + list(self.bystanders)

    def bystander(self, who: str) -> None:
        """Count a heartbeat on the vehicle's own link of somebody who is not the vehicle."""
        self.bystanders[who] = self.bystanders.get(who, 0) + 1

    def _is_looked_at(self, data: bytes, now: float, away: bool) -> bool:
        """Spend what strangers may cost."""
        if now >= self._window_ends:
            self._window_ends = now + WINDOW
            self._left = LOOKED_AT_UNMET if away else LOOKED_AT
            self._heartbeats_left = LOOKED_AT
        if self._left > 0:
            self._left -= 1
            return True
        if self._heartbeats_left > 0 and begins_as_heartbeat(data):
            self._heartbeats_left -= 1
            return True
        return False

    def _is_met(self, source: Source, vehicle: Vehicle | None, away: bool) -> bool:
        if vehicle is None or not vehicle.is_multirotor or not away:
            return False
        if self.heard is None:
            return self.called is None or source == self.called
        return vehicle.system == self.system

    def _meet(self, source: Source, system: int, now: float) -> None:
        """A vehicle that comes back in flight is listened to and nothing more: its setpoints went elsewhere."""
        del self.strangers[source]
        self.to = None if self.flying else source
        self.heard, self.heard_at, self.system = source, now, system
        self._rival = None
        self._window_ends = -math.inf  # from now on strangers may cost less

    def _compete(self, source: Source, vehicle: Vehicle | None, frame: Frame, now: float) -> None:
        """Remember a second candidate before the flight: a multirotor, or states under the very id of ours."""
        if self.flying or self.heard is None or self._rival is not None:
            return
        same = frame.system == self.system and (vehicle is None or vehicle.is_multirotor)
        if same or (vehicle is not None and vehicle.is_multirotor):
            self._rival = (f"system {frame.system} at {source_words(source)}", now)


def vehicle_of(frame: Frame) -> Vehicle | None:
    """Which vehicle's autopilot a heartbeat comes from; None for other components, ground stations and messages."""
    if frame.format is not HEARTBEAT or frame.component != MAV_COMP_ID_AUTOPILOT1:
        return None
    _, kind, autopilot, _, _, _ = frame.values
    return (
        None if autopilot == MAV_AUTOPILOT_INVALID or kind == MAV_TYPE_GCS else Vehicle(frame.system, kind, autopilot)
    )


def begins_as_heartbeat(data: bytes) -> bool:
    """Whether a datagram begins with an autopilot's HEARTBEAT, as far as its header says."""
    if len(data) >= 12 and data[0] == MAGIC_V2:
        return data[6] == MAV_COMP_ID_AUTOPILOT1 and data[7:10] == b"\0\0\0"
    return len(data) >= 8 and data[0] == MAGIC_V1 and data[4] == MAV_COMP_ID_AUTOPILOT1 and data[5] == 0


def source_words(source: Source) -> str:
    """A source for a person."""
    return ":".join(map(str, source)) if isinstance(source, tuple) else f"endpoint {source}" if source != LINE else LINE
