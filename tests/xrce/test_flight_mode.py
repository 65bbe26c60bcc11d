"""A flight mode of our own, against the topics of PX4 main as captured: registered, selected, left, completed."""

from __future__ import annotations

from typing import Any

import pytest

from companion.vehicle import AttitudeSetpoint, CompanionError, Mode, OutputLevel
from companion.xrce import topics, wire
from companion.xrce.commands import Commands, follows
from companion.xrce.flight_mode import ASK_AGAIN, CONTROLLERS, FlightMode, level_refused, mode_name
from companion.xrce.messages import SESSION
from companion.xrce.objects import Data, WriteData
from companion.xrce.topics import LAYOUTS
from companion.xrce.wire import Message
from tests.xrce.captured import session

WRITERS = {
    ("register_ext_component_reply", 1): 0x0D25,
    ("arming_check_request", 1): 0x0105,
    ("vehicle_status", 2): 0x1265,
    ("vehicle_control_mode", 0): 0x1155,
}
LEVEL = AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), 0.5)
AT = 100.0
"""s, when it begins."""


class Vehicle:
    """PX4 main's client with its session as captured, in Hold, and a flight mode that is not registered yet."""

    def __init__(self, level: OutputLevel = OutputLevel.ATTITUDE) -> None:
        self.mode = FlightMode("Path", level)
        self.commands = Commands(level, flight_mode=self.mode)
        for each in session():
            if each.of_client:
                self.commands.receive(each.data, AT)
                self.commands.agent.datagrams(AT)
        self._number = 10_000

    def says(self, topic: tuple[str, int], now: float, **values: Any) -> None:
        self._number += 1
        sample = WriteData(0, WRITERS[topic], LAYOUTS[topic].encode(**values))
        self.commands.receive(wire.encode(Message(SESSION, 1, self._number, (sample,))), now)

    def told(self, now: float) -> dict[str, dict[str, Any]]:
        """What goes out, by topic."""
        reading = {reader.object: reader.topic for reader in self.commands.agent.reading.values()}
        found: dict[str, dict[str, Any]] = {}
        for data in self.commands.datagrams(now):
            for each in wire.decode(data).submessages:
                if isinstance(each, Data):
                    topic = reading[each.object]
                    values = topics.layout(topic, versioned=True).decode(each.sample)
                    assert values is not None
                    found[topic.name] = values
        return found

    def register(self) -> None:
        request = self.told(AT)["register_ext_component_request"]
        self.says(
            ("register_ext_component_reply", 1), AT, request_id=request["request_id"], success=True, arming_check_id=2,
            mode_id=23, mode_executor_id=-1,
        )  # fmt: skip

    def select(self, now: float) -> None:
        self.says(("vehicle_status", 2), now, nav_state=23)
        self.says(
            ("vehicle_control_mode", 0), now, flag_control_attitude_enabled=True, flag_control_rates_enabled=True,
            flag_control_allocation_enabled=True, source_id=23,
        )  # fmt: skip


def test_it_is_registered_by_its_name_and_asked_for_until_answered() -> None:
    vehicle = Vehicle()
    request = vehicle.told(AT)["register_ext_component_request"]
    assert request["name"].rstrip(b"\0") == b"Path"
    assert request["register_mode"]
    assert request["register_arming_check"]
    assert not request["register_mode_executor"]
    assert vehicle.told(AT + 0.5 * ASK_AGAIN) == {}
    assert "registered" in (vehicle.commands.missing or "")
    again = vehicle.told(AT + 1.1 * ASK_AGAIN)["register_ext_component_request"]
    assert again["request_id"] != request["request_id"]
    other = {"request_id": 7, "success": True, "arming_check_id": 1, "mode_id": 24}
    vehicle.says(("register_ext_component_reply", 1), AT, **other)  # somebody else's
    assert vehicle.mode.mode is None


@pytest.mark.parametrize(("mode", "check"), [(22, 2), (31, 2), (127, 2), (-1, 2), (23, -1)])
def test_a_registration_under_numbers_that_are_none_is_asked_for_again(mode: int, check: int) -> None:
    vehicle = Vehicle()
    request = vehicle.told(AT)["register_ext_component_request"]
    said = {"request_id": request["request_id"], "success": True, "arming_check_id": check, "mode_id": mode}
    vehicle.says(("register_ext_component_reply", 1), AT, **said)
    vehicle.says(("arming_check_request", 1), AT, request_id=77)
    assert vehicle.told(AT) == {}
    assert vehicle.mode.mode is None
    assert "register_ext_component_request" in vehicle.told(AT + 1.1 * ASK_AGAIN)


def test_it_says_what_it_needs_and_whether_it_can_be_flown() -> None:
    vehicle = Vehicle()
    vehicle.register()
    assert vehicle.mode.mode is Mode.EXTERNAL1
    assert vehicle.told(AT)["config_control_setpoints"]["source_id"] == 23
    for ready in (False, True):
        vehicle.commands.tell(ready, False, False)
        vehicle.says(("arming_check_request", 1), AT, request_id=77)
        reply = vehicle.told(AT)["arming_check_reply"]
        assert (reply["request_id"], reply["registration_id"], reply["can_arm_and_run"]) == (77, 2, ready)
        assert reply["mode_req_local_position"]
        assert reply["mode_req_prevent_arming"]  # it begins in the air
        assert not reply["mode_req_global_position"]


def test_setpoints_go_out_while_the_pilot_has_it_selected_and_no_longer() -> None:
    vehicle = Vehicle()
    vehicle.register()
    vehicle.told(AT)
    assert not vehicle.commands.send(LEVEL, 1.0, AT, True)
    vehicle.select(AT)
    assert vehicle.commands.send(LEVEL, 1.0, AT, True)
    assert list(vehicle.told(AT)) == ["vehicle_attitude_setpoint"]  # and no offboard_control_mode
    assert not vehicle.commands.send(LEVEL, 1.0, AT, False)  # MAVLink says otherwise
    assert not vehicle.commands.send(LEVEL, 1.0, AT + 1.0, True)  # an old word
    vehicle.select(AT + 1.0)
    vehicle.says(("vehicle_status", 2), AT + 1.0, nav_state=4)
    assert not vehicle.commands.send(LEVEL, 1.0, AT + 1.0, True)
    assert vehicle.told(AT + 1.0) == {}


def test_a_mode_without_commands_cannot_be_flown() -> None:
    """PX4 would hold the last attitude for as long as its questions are answered."""
    vehicle = Vehicle()
    vehicle.register()
    vehicle.commands.tell(True, False, False)

    def runs(now: float) -> bool:
        vehicle.says(("arming_check_request", 1), now, request_id=1)
        answer: bool = vehicle.told(now)["arming_check_reply"]["can_arm_and_run"]
        return answer

    vehicle.select(AT)
    assert runs(AT + 0.4)
    assert not runs(AT + 0.6)
    vehicle.select(AT + 0.6)
    vehicle.commands.send(LEVEL, 1.0, AT + 0.6, True)
    assert runs(AT + 1.0)
    vehicle.says(("vehicle_status", 2), AT + 2.0, nav_state=4)
    assert runs(AT + 5.0)


def test_its_end_is_told_once_and_it_is_unregistered() -> None:
    vehicle = Vehicle()
    vehicle.register()
    vehicle.told(AT)
    for _ in range(2):
        vehicle.commands.tell(False, True, True)
    told = vehicle.told(AT)
    assert list(told) == ["mode_completed", "unregister_ext_component"]
    assert (told["mode_completed"]["result"], told["mode_completed"]["nav_state"]) == (0, 23)
    assert (told["unregister_ext_component"]["arming_check_id"], told["unregister_ext_component"]["mode_id"]) == (2, 23)
    vehicle.says(("arming_check_request", 1), AT, request_id=78)
    assert vehicle.told(AT + 5.0) == {}


def test_a_client_that_begins_anew_is_asked_again() -> None:
    vehicle = Vehicle()
    vehicle.register()
    vehicle.told(AT)
    vehicle.commands.agent.sessions += 1
    assert "register_ext_component_request" in vehicle.told(AT)
    assert vehicle.mode.mode is None


@pytest.mark.parametrize(
    ("level", "on"),
    [
        (OutputLevel.ATTITUDE, {"attitude", "rates", "allocation"}),
        (OutputLevel.RATES, {"rates", "allocation"}),
        (OutputLevel.TORQUES, {"allocation"}),
        (OutputLevel.MOTORS, set()),
    ],
)
def test_it_asks_for_the_controllers_of_its_level(level: OutputLevel, on: set[str]) -> None:
    vehicle = Vehicle(level)
    vehicle.register()
    asked = vehicle.told(AT)["config_control_setpoints"]
    assert {name for name in CONTROLLERS[OutputLevel.ATTITUDE] if asked[f"flag_control_{name}_enabled"]} == on
    assert follows(asked, level)
    assert (level_refused(level) is None) == (level is OutputLevel.ATTITUDE)


@pytest.mark.parametrize("name", ["Path", "Path following", "Survey 2", "a.b_c-d", "x" * 24])
def test_a_name_is_kept(name: str) -> None:
    assert mode_name(name) == name


@pytest.mark.parametrize(
    "name",
    [
        "",
        " ",
        " Path",
        "Path ",
        "-Path",
        "x" * 25,
        "Pf\u00e4d",
        "a/b",
        "a\nb",
        "a\0",
        "Hold",
        "position slow",
        "EXTERNAL1",
    ],
)
def test_a_name_that_px4_or_a_ground_station_could_not_keep_is_refused(name: str) -> None:
    with pytest.raises(CompanionError, match=r"is no name for a flight mode; expected 1 to 24|is a flight mode of PX4"):
        mode_name(name)
