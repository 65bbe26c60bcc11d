"""The gate before commands: xrce.md, section 6, line by line."""

from __future__ import annotations

import math

import pytest

from companion.vehicle import (
    AttitudeSetpoint,
    MotorSetpoint,
    OutputLevel,
    RateSetpoint,
    Setpoint,
    TorqueSetpoint,
)
from companion.xrce import wire
from companion.xrce.agent import Counters
from companion.xrce.command_message import TOPICS
from companion.xrce.commands import CONTROL_MODE_LASTS, KEPT_BACK_USUALLY, Commands
from companion.xrce.messages import SESSION, THE_CLIENT, Delete, GetInfo, Timestamp
from companion.xrce.objects import Data, Status, WriteData
from companion.xrce.topics import LAYOUTS
from companion.xrce.wire import NO_STREAM, Message
from tests.xrce.captured import session

MOTORS, TORQUES, RATES, ATTITUDE = OutputLevel.MOTORS, OutputLevel.TORQUES, OutputLevel.RATES, OutputLevel.ATTITUDE
SETPOINTS: dict[OutputLevel, Setpoint] = {
    MOTORS: MotorSetpoint((0.4, 0.5, 0.6, 0.7)),
    TORQUES: TorqueSetpoint((0.1, -0.2, 0.05), 0.55),
    RATES: RateSetpoint((0.1, -0.2, 0.3), 0.55),
    ATTITUDE: AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), 0.55),
}
FLOWN = {  # what stays on of PX4's controllers in OFFBOARD
    MOTORS: (),
    TORQUES: ("allocation",),
    RATES: ("allocation", "rates"),
    ATTITUDE: ("allocation", "rates", "attitude"),
}
AT = 100.0
"""s, when it begins."""


class Vehicle:
    """PX4 main's client with its session as captured, in Hold."""

    def __init__(self, level: OutputLevel) -> None:
        self.commands = Commands(level)
        for each in session():
            if each.of_client:
                self.commands.receive(each.data, AT)
                self.commands.datagrams(AT)
        self._number = 10_000
        self.says(AT, "position", "velocity", "altitude", "attitude", "rates", "allocation")

    def says(self, now: float, *enabled: str) -> None:
        """Publish vehicle_control_mode."""
        flags = {f"flag_control_{name}_enabled": True for name in enabled}
        sample = LAYOUTS["vehicle_control_mode", 0].encode(**flags)
        self._number += 1
        data = wire.encode(Message(SESSION, 1, self._number, (WriteData(0, 0x1155, sample),)))
        self.commands.receive(data, now)

    def told(self, now: float, setpoint: Setpoint | None = None, *, says_offboard: bool = True) -> list[str]:
        """The topics of what goes out for a setpoint, which is one message at most."""
        agent = self.commands.agent
        self.commands.send(setpoint or SETPOINTS[self.commands.level], 42.252, now, says_offboard)
        messages = [wire.decode(data) for data in self.commands.datagrams(now)]
        assert len(messages) <= 1
        names = {reader.object: name for name, reader in agent.reading.items()}
        self.samples = {
            names[each.object]: each.sample
            for message in messages
            for each in message.submessages
            if isinstance(each, Data)
        }
        return list(self.samples)


@pytest.mark.parametrize("level", [MOTORS, TORQUES, RATES, ATTITUDE])
def test_mode_and_command_go_out_in_one_message_and_only_where_px4_flies_on_them(level: OutputLevel) -> None:
    vehicle = Vehicle(level)
    assert vehicle.commands.missing is None
    assert vehicle.told(AT, says_offboard=False) == ["offboard_control_mode"]  # it asks for no more before OFFBOARD
    vehicle.says(AT, "offboard", *FLOWN[level])
    assert vehicle.told(AT) == ["offboard_control_mode", *TOPICS[level]]
    assert vehicle.commands.sent == 1


def test_motors_come_with_their_thrust_and_the_stamp_of_their_state() -> None:
    vehicle = Vehicle(MOTORS)
    vehicle.says(AT, "offboard")
    vehicle.told(AT)
    motors = LAYOUTS["actuator_motors", 0].decode(vehicle.samples["actuator_motors"])
    thrust = LAYOUTS["vehicle_thrust_setpoint", 0].decode(vehicle.samples["vehicle_thrust_setpoint"])
    assert motors is not None
    assert thrust is not None
    assert (motors["timestamp"], motors["timestamp_sample"]) == (0, 42_252_000)
    assert motors["control"][:4] == pytest.approx((0.4, 0.5, 0.6, 0.7))
    assert all(math.isnan(value) for value in motors["control"][4:])
    assert thrust["xyz"] == pytest.approx((0.0, 0.0, -0.55))


@pytest.mark.parametrize(
    ("enabled", "says_offboard", "why"),
    [
        ((), True, "somebody selected Hold: the motors are its allocator's"),
        (("offboard", "allocation"), True, "OFFBOARD with the allocator on: they would fight"),
        (("offboard",), False, "CURRENT_MODE does not say OFFBOARD, or not of late"),
    ],
)
def test_no_motor_command_unless_both_links_say_so(enabled: tuple[str, ...], says_offboard: bool, why: str) -> None:
    """Out of OFFBOARD the mode alone may be heard; in it, a mode without a command would hold a dead one for ever."""
    vehicle = Vehicle(MOTORS)
    vehicle.says(AT, *enabled)
    told = vehicle.told(AT, says_offboard=says_offboard)
    assert told == ([] if "offboard" in enabled else ["offboard_control_mode"]), why
    assert vehicle.commands.sent == 0
    assert vehicle.commands.kept_back == ("offboard" in enabled)


@pytest.mark.parametrize("level", [TORQUES, RATES, ATTITUDE])
def test_setpoints_are_kept_back_from_controllers_that_would_overrule_them(level: OutputLevel) -> None:
    vehicle = Vehicle(level)
    vehicle.says(AT, "offboard", "allocation", "rates", "attitude", "position", "velocity", "altitude")
    assert vehicle.told(AT) == []


def test_an_old_word_is_none() -> None:
    vehicle = Vehicle(MOTORS)
    vehicle.says(AT, "offboard")
    assert len(vehicle.told(AT + CONTROL_MODE_LASTS - 0.01)) == 3
    assert vehicle.told(AT + CONTROL_MODE_LASTS + 0.01) == []


def test_a_client_that_is_gone_gets_nothing() -> None:
    vehicle = Vehicle(MOTORS)
    vehicle.says(AT, "offboard")
    vehicle.commands.receive(wire.encode(Message(SESSION, NO_STREAM, 0, (Delete(2, THE_CLIENT),))), AT)
    assert [wire.decode(data).submessages[0] for data in vehicle.commands.datagrams(AT)] == [Status(2, THE_CLIENT)]
    assert vehicle.told(AT) == []
    assert "that its XRCE client has offboard_control_mode" in (vehicle.commands.missing or "")


def test_while_it_is_commanded_the_client_waits_on_its_socket() -> None:
    """TIMESTAMP stays unanswered then, pings do not."""
    vehicle = Vehicle(MOTORS)
    vehicle.says(AT, "offboard")
    vehicle.told(AT)
    for asked, answers in ((Timestamp(bytes(8)), 0), (GetInfo(10, 0xFFFD), 1)):
        vehicle.commands.receive(wire.encode(Message(SESSION, NO_STREAM, 0, (asked,))), AT)
        assert len(vehicle.commands.datagrams(AT)) == answers
    vehicle.says(AT)
    vehicle.told(AT)
    vehicle.commands.receive(wire.encode(Message(SESSION, NO_STREAM, 0, (Timestamp(bytes(8)),))), AT)
    assert len(vehicle.commands.datagrams(AT)) == 1


def test_a_rehearsal_leaves_nothing_behind() -> None:
    vehicle = Vehicle(MOTORS)
    vehicle.says(AT, "offboard")
    vehicle.commands.rehearse(SETPOINTS[MOTORS], 1.0)
    assert vehicle.commands.datagrams(AT) == []
    assert vehicle.commands.sent == 0
    vehicle.commands.send(SETPOINTS[MOTORS], 1.0, AT, True)
    (data,) = vehicle.commands.datagrams(AT)
    assert wire.decode(data).sequence == 0


def test_what_was_lost_or_refused_is_told() -> None:
    vehicle = Vehicle(MOTORS)
    vehicle.commands.agent.counters = Counters()
    assert vehicle.commands.words() == []
    vehicle.commands.receive(b"?", AT)
    vehicle.says(AT, "offboard", "allocation")
    for _ in range(KEPT_BACK_USUALLY + 1):
        vehicle.told(AT)
    damaged, refused = vehicle.commands.words()
    assert "1 datagrams made no sense" in damaged
    assert f"{KEPT_BACK_USUALLY + 1} commands were kept back, 0 sent" in refused


def test_a_topic_in_a_version_nobody_knows_is_a_refusal() -> None:
    vehicle = Vehicle(MOTORS)
    reader = vehicle.commands.agent.reading["actuator_motors"]
    vehicle.commands.agent.reading["actuator_motors"] = reader._replace(topic=reader.topic._replace(version=7))
    assert "that its XRCE client has actuator_motors" in (vehicle.commands.missing or "")
    assert "actuator_motors in version 7" in (vehicle.commands.refusal or "")
    vehicle.says(AT, "offboard")
    assert vehicle.told(AT) == []
