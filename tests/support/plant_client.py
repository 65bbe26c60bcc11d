"""A client for the plant's tests: speaks to a Bridge in lockstep, remembers what it hears."""

from __future__ import annotations

from typing import Any, NamedTuple

from companion.config.vehicle import load_vehicle
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import Value, message
from companion.mavlink.modes import Mode
from companion.mavlink_common import (
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_GET_MESSAGE_INTERVAL,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_RETURN_TO_LAUNCH,
    MAV_CMD_NAV_TAKEOFF,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_COMP_ID_MISSIONPLANNER,
    MAV_COMP_ID_ONBOARD_COMPUTER,
)
from companion.world import World
from sim_bridge.bridge import Bridge

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = range(5)
ARM, SET_MODE = MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_SET_MODE
TAKEOFF, LAND, RETURN = MAV_CMD_NAV_TAKEOFF, MAV_CMD_NAV_LAND, MAV_CMD_NAV_RETURN_TO_LAUNCH
SET_INTERVAL, GET_INTERVAL = MAV_CMD_SET_MESSAGE_INTERVAL, MAV_CMD_GET_MESSAGE_INTERVAL
REQUEST = MAV_CMD_REQUEST_MESSAGE
NAN = float("nan")


class Heard(NamedTuple):
    """A message, when it came (the bridge's time), by which endpoint."""

    at: float
    endpoint: int
    name: str
    fields: dict[str, Any]


class Client:
    """A companion (endpoint 0) and an operator (endpoint 1) in one."""

    def __init__(self, vehicle: str = "x500", world: World | None = None, **options: Any) -> None:
        self.bridge = Bridge(load_vehicle(vehicle), world or World(), **options)
        self.heard: list[Heard] = []
        self._encoders = (Encoder(1, MAV_COMP_ID_ONBOARD_COMPUTER), Encoder(255, MAV_COMP_ID_MISSIONPLANNER))
        self._decoders = (Decoder(), Decoder())
        self._heartbeat_at: float | None = None

    def listen(self) -> None:
        self.remember(self.bridge.datagrams())

    def remember(self, arrived: list[tuple[int, bytes]]) -> None:
        """What came over MAVLink."""
        for endpoint, datagram in arrived:
            for frame in self._decoders[endpoint].datagram(datagram):
                if (frame.system, frame.component) != (1, 1):
                    continue  # passed on from the other link
                fields = frame.format.named(frame.values)
                self.heard.append(Heard(self.bridge.now, endpoint, frame.format.name, fields))

    def send(self, name: str, endpoint: int = 0, **fields: Value) -> None:
        fmt = message(name)
        for target in ("target_system", "target_component"):
            if target in fmt.where:
                fields.setdefault(target, 1)
        self.bridge.receive(self._encoders[endpoint].message(fmt, **fields), endpoint)
        self.listen()

    def command(self, command: int, *parameters: float, endpoint: int = 0) -> int | None:
        """The result of a command, None if there was no answer."""
        before = len(self.heard)
        given = (*parameters, *(0.0,) * (7 - len(parameters)))
        named = {f"param{i + 1}": value for i, value in enumerate(given)}
        self.send("COMMAND_LONG", endpoint, command=command, **named)
        answers = [h for h in self.heard[before:] if h.name == "COMMAND_ACK" and h.fields["command"] == command]
        assert len(answers) <= 1
        return answers[0].fields["result"] if answers else None

    def mode(self, mode: Mode, endpoint: int = 0) -> int | None:
        return self.command(SET_MODE, 1, mode.main, mode.sub, endpoint=endpoint)

    def ground_station(self) -> None:
        """The operator's heartbeat, which opens the link for texts; every second from now on."""
        self.send("HEARTBEAT", 1, type=6, autopilot=8)
        self._heartbeat_at = self.bridge.now + 1.0

    def step(self) -> None:
        """One step of the plant."""
        if self._heartbeat_at is not None and self.bridge.now >= self._heartbeat_at:
            self.ground_station()
        self.bridge.step()
        self.listen()

    def rates(self, p: float = 0.0, q: float = 0.0, r: float = 0.0, thrust: float = 0.5, mask: int = 0x80) -> None:
        self.send(
            "SET_ATTITUDE_TARGET", body_roll_rate=p, body_pitch_rate=q, body_yaw_rate=r, thrust=thrust,
            type_mask=mask, q=(1.0, 0.0, 0.0, 0.0),
        )  # fmt: skip

    def sticks(self, pitch: float = 0.0, roll: float = 0.0, throttle: float = 0.0, yaw: float = 0.0) -> None:
        """A pilot's sticks, -1..1, by the operator's link."""
        x, y, r = (round(1000 * value) for value in (pitch, roll, yaw))
        self.send("MANUAL_CONTROL", 1, target=1, x=x, y=y, z=round(500 * (throttle + 1.0)), r=r)

    def piloted(self, seconds: float, also: Any = None, **deflection: float) -> None:
        """Let time pass with somebody at the sticks, 25 times a second."""
        for _ in range(round(25 * seconds)):
            self.sticks(**deflection)
            self.run(0.04, also)

    def motors(self, *commands: float) -> None:
        self.send("SET_ACTUATOR_CONTROL_TARGET", controls=(*commands, 0.0, 0.0, 0.0, 0.0))

    def run(self, seconds: float, every_step: Any = None) -> None:
        """Let time pass, calling ``every_step`` before each step."""
        until = self.bridge.now + seconds - 1e-9
        while self.bridge.now < until:
            if every_step is not None:
                every_step()
            self.step()

    def run_until(self, happens: Any, at_most: float) -> float:
        """Let time pass until ``happens()``; how long it took. Fails after ``at_most`` s."""
        start = self.bridge.now
        while not happens():
            assert self.bridge.now - start < at_most, "it did not happen"
            self.step()
        return self.bridge.now - start

    def all(self, name: str, endpoint: int = 0, since: float = -1.0) -> list[dict[str, Any]]:
        return [h.fields for h in self.heard if h.name == name and h.endpoint == endpoint and h.at > since]

    def last(self, name: str, endpoint: int = 0) -> dict[str, Any]:
        return self.all(name, endpoint)[-1]

    def texts(self) -> list[str]:
        """What the operator has read, pieces put together."""
        texts: dict[int, str] = {}
        for fields in self.all("STATUSTEXT", 1):
            texts[fields["id"]] = texts.get(fields["id"], "") + fields["text"]
        return list(texts.values())

    @property
    def flown(self) -> Mode:
        return self.bridge.autopilot.commander.mode

    @property
    def height(self) -> float:
        return -self.bridge.truth.p_n[2]
