"""EVENT: what PX4 says in numbers, also to those who are sent no texts."""

from __future__ import annotations

import struct
from typing import Any

from companion.mavlink.modes import Mode
from sim_bridge.autopilot.commander.event_table import event_table
from sim_bridge.autopilot.commander.events import PLAIN, event_of
from sim_bridge.autopilot.commander.health_report import Health, report
from tests.support.plant_client import ARM, NAN, TAKEOFF, Client

EXTERNAL_COMMAND, HOLD = 4, 5


CHECKS = {0: 11047904, 1: 11464574, 2: 13835193, 3: 10011251, 4: 377561, 5: 453929, 6: 6801787, 7: 1914663, 8: 1871713}
OF_THE_HEALTH_REPORT = {1 << 24 | identity for identity in CHECKS.values()}


def events(client: Client) -> list[tuple[int, int, bytes]]:
    """(id, log levels, arguments) of every event the companion was sent."""
    return [
        (fields["id"], fields["log_levels"], bytes(fields["arguments"]).rstrip(b"\0"))
        for fields in client.all("EVENT")
    ]  # fmt: skip


def told(client: Client) -> list[tuple[int, int, bytes]]:
    """The same without the health report."""
    return [event for event in events(client) if event[0] not in OF_THE_HEALTH_REPORT]


def reports(client: Client) -> list[list[str]]:
    """The health reports: each event as its number in CHECKS and its arguments."""
    numbers = {1 << 24 | identity: number for number, identity in CHECKS.items()}
    found: list[list[str]] = []
    for identity, _, arguments in events(client):
        if identity in numbers:
            found += [[]] if numbers[identity] == 0 else []
            found[-1].append(f"{numbers[identity]} {arguments.hex()}")
    return found


def test_the_health_report_is_that_of_a_recorded_session() -> None:
    client = Client("sih", landed=True)
    client.run(5.0)
    client.ground_station()
    client.run(2.0)
    offboard, place, globe = "1 0040000014", "2 fc007e0011", "3 3800000018"
    mission, sticks, operator = "4 0800000014", "5 ffffffff07", "6 ffffffff0c"
    assert reports(client) == [
        ["0 000000120180000000003a0180003a0180", offboard, place, globe, mission, sticks, operator, "7 00020d0238"],
        ["0 000000100080000000b03a7f80b03a7f80", offboard, mission, sticks, operator, "7 000a0d0238"],
        ["0 000000100080000000b03a7f80b03a7f80", offboard, mission, sticks, "7 000a1d0238"],
    ]
    client.run(2.0)
    client.run(0.1, lambda: client.rates(thrust=0.1))
    assert reports(client)[3:] == [["0 000000000080000000b07a7f80b07a7f80", mission, sticks, "7 000a1d0238"]]
    client.run(2.0)
    assert len(reports(client)) == 5
    assert reports(client)[4] == reports(client)[2]


def test_the_health_report_knows_sticks_missions_and_modes_nobody_arms_in() -> None:
    client = Client("sih", landed=True)
    client.ground_station()
    client.piloted(5.0)
    summary = bytes.fromhex(reports(client)[-1][0].removeprefix("0 ")).ljust(17, b"\0")
    assert struct.unpack("<BIIII", summary) == (0, 1 << 20, 0, 0x807FBFF7, 0x807FBFF7)
    client.mode(Mode.LAND)
    client.piloted(2.1)
    assert [line.split()[0] for line in reports(client)[-1]] == ["0", "1", "8", "4", "7"]
    _, _, _, can_arm, can_run = struct.unpack("<BIIII", bytes.fromhex(reports(client)[-1][0][2:]).ljust(17, b"\0"))
    assert not can_arm >> 18 & 1
    assert can_run >> 18 & 1


def test_a_companion_is_told_what_the_operator_reads() -> None:
    """The ids and arguments are those of a recorded session of PX4."""
    client = Client("sih", landed=True)
    client.run(1.0)
    client.command(ARM, 1)
    client.run(5.0)
    client.command(TAKEOFF, *(NAN,) * 7)
    client.command(ARM, 1)
    client.run(4.0)
    assert told(client) == [
        (16910493, 0x62, b""),
        (26266355, 0x66, bytes([EXTERNAL_COMMAND])),
        (20656071, 0x66, struct.pack("<f", 2.5).rstrip(b"\0")),
        (21054825, 0x66, b""),
    ]
    assert not client.all("STATUSTEXT")


def test_a_failsafe_is_an_event() -> None:
    client = Client("sih")
    client.bridge.autopilot.parameters["COM_OBL_RC_ACT"] = 5
    client.rates(thrust=0.49)
    client.mode(Mode.OFFBOARD)
    client.run(1.3)
    (event,) = told(client)
    assert event == (31382480, 0x42, struct.pack("<IB", Mode.OFFBOARD.custom_mode, HOLD))


def test_what_was_missed_is_sent_again() -> None:
    client = Client("sih")
    for _ in range(30):
        client.command(176, 1, 99)
        client.run(0.1)
    client.run(0.3)
    sequences = [fields["sequence"] for fields in client.all("EVENT")]
    assert len(told(client)) == 30
    last = 30 + sum(map(len, reports(client))) - 1
    assert sequences == list(range(last + 1))
    assert client.last("CURRENT_EVENT_SEQUENCE")["sequence"] in range(last - 4, last + 1)
    client.send("REQUEST_EVENT", first_sequence=last - 1, last_sequence=last)
    assert [fields["sequence"] for fields in client.all("EVENT")][-2:] == [last - 1, last]
    client.send("REQUEST_EVENT", first_sequence=3, last_sequence=3)
    missing: dict[str, Any] = client.last("RESPONSE_EVENT_ERROR")
    assert (missing["sequence"], missing["sequence_oldest_available"]) == (3, last - 19)


def test_every_event_is_described() -> None:
    """What MAVSDK and QGroundControl need to show it: a text, and arguments that are as long as what is sent."""
    sizes = {"uint8_t": 1, "int16_t": 2, "uint16_t": 2, "uint32_t": 4, "int32_t": 4, "float": 4}
    component: Any = event_table()["components"]["1"]
    sizes |= {name: sizes[kind["type"]] for name, kind in component["enums"].items()}
    events_of = {name: group["events"] for name, group in component["event_groups"].items()}
    described = {int(identity): event for group in events_of.values() for identity, event in group.items()}
    said = report(Health(False, False, Mode.LAND, False, False, False, False, True, True))
    assert {event.id for event in said} == set(CHECKS.values())
    texts = [
        *PLAIN, "Armed by mission start", "Failsafe activated", "Failsafe activated: entering Hold for 5 seconds",
        "Using default takeoff altitude: 2.5 m", "RTL: start return at 519 m (30 m above destination)",
        "Geofence violation for waypoint 3", "Climb to 8.0 meters above home",
        "SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 unsupported",
    ]  # fmt: skip
    beside = [event_of(text, Mode.OFFBOARD, Mode.HOLD) for text in texts]
    for identity, arguments in [(e.id, e.arguments) for e in said] + [e for e in beside if e is not None]:
        event = described[identity]
        assert sum(sizes[each["type"]] for each in event["arguments"]) == len(arguments), event
        assert event["message"].count("{") <= len(event["arguments"])
    assert described[5383828]["message"] == "RTL: start return at {1} m ({2} m above destination)"
    assert events_of["health"][str(CHECKS[7])]["type"] == events_of["arming_check"][str(CHECKS[0])]["type"] == "summary"
