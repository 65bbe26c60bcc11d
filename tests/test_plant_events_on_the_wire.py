"""EVENT: what PX4 says in numbers, also to those who are sent no texts."""

from __future__ import annotations

import struct
from typing import Any

from companion.mavlink.modes import Mode
from tests.plant_client import ARM, NAN, TAKEOFF, Client

EXTERNAL_COMMAND, HOLD = 4, 5


def told(client: Client) -> list[tuple[int, int, bytes]]:
    """(id, log levels, arguments) of every event the companion was sent."""
    return [
        (fields["id"], fields["log_levels"], bytes(fields["arguments"]).rstrip(b"\0"))
        for fields in client.all("EVENT")
    ]  # fmt: skip


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
    assert sequences == list(range(30))
    assert client.last("CURRENT_EVENT_SEQUENCE")["sequence"] in range(25, 30)
    client.send("REQUEST_EVENT", first_sequence=28, last_sequence=29)
    assert [fields["sequence"] for fields in client.all("EVENT")][-2:] == [28, 29]
    client.send("REQUEST_EVENT", first_sequence=3, last_sequence=3)
    missing: dict[str, Any] = client.last("RESPONSE_EVENT_ERROR")
    assert (missing["sequence"], missing["sequence_oldest_available"]) == (3, 10)
