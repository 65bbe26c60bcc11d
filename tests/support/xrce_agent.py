"""The least an agent can say to PX4's XRCE client, for the stand-in's tests: a derivation of its own, from the bytes
and the choreography that were captured. Knows nothing of what the companion's own agent does."""

from __future__ import annotations

import random
import struct
from typing import Any

from companion.mavlink.modes import Mode
from companion.world import World
from companion.xrce.messages import (
    Acknack,
    CreateClient,
    Delete,
    GetInfo,
    Heartbeat,
    Info,
    StatusAgent,
    Submessage,
    Timestamp,
    TimestampReply,
)
from companion.xrce.objects import Create, Data, Kind, Status, WriteData, name_of, topic_of
from companion.xrce.wire import Message, decode, encode
from sim_bridge.autopilot.xrce import Release
from sim_bridge.world_events import XRCE
from tests.support.plant_client import Client

NOBODY = float("nan")
"""A motor that is not there."""


class XrceClient(Client):
    """A companion with an agent, at the stand-in's two sides. ``dead``: the agent says and hears nothing.

    ``said``: what the vehicle's XRCE client sent, decoded; ``samples``: what it published, by topic; ``ended``: whether
    it has ended a session.
    """

    def __init__(
        self, vehicle: str = "sih", world: World | None = None, *, release: Release = Release.MAIN, synct: int = 0,
        loss: float = 0.0, **options: Any,
    ) -> None:  # fmt: skip
        super().__init__(vehicle, world, xrce=release, **options)
        assert self.bridge.xrce is not None
        self.client = self.bridge.xrce
        self.bridge.autopilot.parameters["UXRCE_DDS_SYNCT"] = synct
        self.dead = False
        self.answers_time = True
        self.said: list[tuple[float, Message]] = []
        self.samples: dict[str, list[tuple[float, bytes]]] = {}
        self.readers: dict[str, int] = {}
        self.ended = False
        self._loss, self._chance = loss, random.Random(1).random
        self._reset()

    def _reset(self) -> None:
        self._topics: dict[int, str] = {}
        self._next, self._first, self._published = 0, 0, 0
        self._kept: dict[int, bytes] = {}
        self._expected, self._early = 0, dict[int, Message]()

    def listen(self) -> None:
        arrived = self.bridge.datagrams()
        while arrived:
            self.remember([(endpoint, data) for endpoint, data in arrived if endpoint != XRCE])
            for endpoint, data in arrived:
                if endpoint == XRCE:
                    self.said.append((self.bridge.now, decode(data)))
                    self.ended = self.ended or any(isinstance(s, Delete) for s in self.said[-1][1].submessages)
                    if not self.dead and self._chance() >= self._loss:
                        self._answer(self.said[-1][1])
            arrived = self.bridge.datagrams()

    def _answer(self, message: Message) -> None:
        if message.stream == 0x80:
            self._take_reliable(message)
            return
        for said in message.submessages:
            if isinstance(said, GetInfo):
                self._tell(message.session, Info(said.request, said.object, True))
            elif isinstance(said, CreateClient):
                self._reset()
                self._tell(0x81, StatusAgent())
            elif isinstance(said, Timestamp) and self.answers_time:
                self._tell(0x81, TimestampReply(said.time, said.time, said.time))
            elif isinstance(said, Acknack):
                self._first = said.first
                for bit in range(16):
                    if said.missing >> bit & 1 and said.first + bit in self._kept:
                        self._send(self._kept[said.first + bit])
            elif isinstance(said, Heartbeat):
                missing = [n for n in range(self._expected, said.last + 1) if n not in self._early]
                self._tell(0x81, Acknack(self._expected, sum(1 << n - self._expected for n in missing)))
            elif isinstance(said, WriteData):
                topic = self._topics.get(said.object & 0xFFF0 | Kind.TOPIC, "?")
                self.samples.setdefault(topic, []).append((self.bridge.now, said.sample))

    def _take_reliable(self, message: Message) -> None:
        if message.sequence >= self._expected:
            self._early[message.sequence] = message
        while self._expected in self._early:
            for said in self._early.pop(self._expected).submessages:
                if isinstance(said, Create):
                    self._note(said)
                    self._kept[self._next] = encode(
                        Message(0x81, 0x80, self._next, (Status(said.request, said.object),))
                    )
                    self._send(self._kept[self._next])
                    self._next += 1
            self._expected += 1
        self._tell(0x81, Acknack(self._expected))

    def _note(self, made: Create) -> None:
        name, topic = name_of(made), topic_of(made)
        if name is not None:
            self._topics[made.object] = name.rsplit("/", 1)[1]
        if made.kind == Kind.READER and topic in self._topics:
            self.readers[self._topics[topic]] = made.object

    def _tell(self, session: int, said: Submessage) -> None:
        self._send(encode(Message(session, 0, 0, (said,))))

    def remind(self) -> None:
        """What the agent says ten times a second on a line that loses."""
        if self._first < self._next:
            self._tell(0x81, Heartbeat(self._first, self._next - 1))

    def _send(self, datagram: bytes) -> None:
        if not self.dead and self._chance() >= self._loss:
            self.bridge.receive(datagram, XRCE)

    def write(self, *samples: tuple[str, bytes]) -> None:
        """Samples to the vehicle's topics, all in one datagram."""
        data = [Data(0, self.readers[name], sample) for name, sample in samples]
        self._send(encode(Message(0x81, 1, self._published, tuple(data))))
        self._published = (self._published + 1) % 65536

    def skip_to(self, number: int) -> None:
        """Go on with another sequence number."""
        self._published = number

    def connect(self, at_most: float = 5.0) -> float:
        """Let time pass until the session stands; how long it took."""
        return self.run_until(lambda: self.client.serves, at_most)

    def in_offboard(self, *samples: tuple[str, bytes]) -> None:
        """Into OFFBOARD, on these samples."""
        self.write(*samples)
        self.run(0.02)
        assert self.mode(Mode.OFFBOARD) == 0
        self.run(0.05)


def offboard_mode(level: str, stamp: int = 0) -> tuple[str, bytes]:
    """offboard_control_mode with one of its flags set; "": none."""
    flags = ("position", "velocity", "acceleration", "attitude", "body_rate", "thrust_and_torque", "direct_actuator")
    return "offboard_control_mode", struct.pack("<Q7?", stamp, *(flag == level for flag in flags))


def motors(*shares: float) -> tuple[str, bytes]:
    """actuator_motors."""
    return "actuator_motors", struct.pack("<QQH2x12f", 0, 0, 0, *shares, *(NOBODY,) * (12 - len(shares)))


def thrust(share: float) -> tuple[str, bytes]:
    """vehicle_thrust_setpoint."""
    return "vehicle_thrust_setpoint", struct.pack("<QQ3f", 0, 0, 0.0, 0.0, -share)


def torque(x: float, y: float, z: float) -> tuple[str, bytes]:
    """vehicle_torque_setpoint."""
    return "vehicle_torque_setpoint", struct.pack("<QQ3f", 0, 0, x, y, z)


def rates(p: float, q: float, r: float, share: float) -> tuple[str, bytes]:
    """vehicle_rates_setpoint."""
    return "vehicle_rates_setpoint", struct.pack("<Q6f?", 0, p, q, r, 0.0, 0.0, -share, False)


def registration(name: str, request: int = 7) -> tuple[str, bytes]:
    """register_ext_component_request (version 1) for a mode with its arming checks."""
    flags = (True, True, False, False, 0, False, False)
    return "register_ext_component_request_v1", struct.pack("<QQ25sxH4?B2?", 0, request, name.encode(), 1, *flags)


def unregistration(name: str, check: int, mode: int) -> tuple[str, bytes]:
    """unregister_ext_component."""
    return "unregister_ext_component", struct.pack("<Q25s3b", 0, name.encode(), check, mode, -1)


def check_reply(request: int, check: int, can_run: bool = True) -> tuple[str, bytes]:
    """arming_check_reply (version 1) without events, requiring rates, attitude and a local position."""
    head = struct.pack("<Q3B4?B", 0, request, check, 0, False, False, False, can_run, 0)
    return "arming_check_reply_v1", head + bytes(200) + struct.pack("<11?", True, True, True, True, *(False,) * 7)


def at_rates(mode: int) -> tuple[str, bytes]:
    """config_control_setpoints of a mode that is flown by body rates."""
    flags = (False,) * 11 + (True, True, False)
    return "config_control_setpoints", struct.pack("<Q14?B", 0, *flags, mode)
