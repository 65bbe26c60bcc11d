"""Who is our vehicle, and who is nobody."""

from __future__ import annotations

import random

import pytest

from companion.mavlink import link as wire
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import Value, message
from companion.mavlink.peer import LINE, LOOKED_AT, PEER_SILENT, STRANGERS_MAX, WINDOW, Peers

HERE, THERE, ELSEWHERE = ("127.0.0.1", 14580), ("127.0.0.1", 5000), ("10.0.0.7", 14550)


def frame(name: str, system: int = 1, component: int = 1, **fields: Value) -> bytes:
    return Encoder(system, component).message(message(name), **fields)


def beat(system: int = 1, kind: int = 2, autopilot: int = 12, component: int = 1) -> bytes:
    return frame("HEARTBEAT", system, component, type=kind, autopilot=autopilot, system_status=4)


STATE = frame("ODOMETRY", frame_id=1, child_frame_id=1, q=(1.0, 0.0, 0.0, 0.0), time_usec=7)


def met(at: float = 0.0) -> Peers:
    peers = Peers()
    assert peers.knock(beat(), HERE, at)
    return peers


def test_the_first_multirotors_autopilot_is_the_vehicle() -> None:
    peers = Peers()
    for data in (b"\xfd\x00garbage", beat(255, 6, 8, 190), beat(1, 18, 8, 191), beat(1, 1), beat(1, 10), STATE):
        assert not peers.knock(data, THERE, 0.0)
    assert peers.to is None
    assert peers.knock(beat(7), HERE, 0.1)
    assert (peers.heard, peers.to, peers.system) == (HERE, HERE, 7)
    assert not peers.knock(beat(7), THERE, 0.2)
    assert peers.heard == HERE


def test_a_called_address_is_the_only_one_and_a_line_has_one_source() -> None:
    peers = Peers()
    peers.call(HERE)
    assert peers.to == HERE
    assert not peers.knock(beat(), THERE, 0.0)
    assert peers.knock(beat(), HERE, 0.0)
    line = Peers()
    line.call(LINE)
    assert line.heard == line.to == LINE


@pytest.mark.parametrize(
    ("data", "rival"),
    [
        (beat(1), "system 1 at 127.0.0.1:5000"),
        (beat(2), "system 2 at 127.0.0.1:5000"),
        (STATE, "system 1 at 127.0.0.1:5000"),
        (frame("CURRENT_MODE", custom_mode=1), "system 1 at 127.0.0.1:5000"),
        (beat(2, kind=1), None),  # a fixed wing is nobody
        (beat(255, 6, 8, 190), None),
        (beat(1, 18, 8, 191), None),
        (b"\xfd", None),
    ],
)
def test_a_second_candidate_is_noticed_before_the_flight_and_has_no_effect_in_it(data: bytes, rival: str) -> None:
    peers = met()
    assert not peers.knock(data, THERE, 0.1)
    peers.heard_at = 0.2  # both speak
    assert peers.rival == rival
    flying = met()
    flying.flying = True
    assert not flying.knock(data, THERE, 0.1)
    flying.heard_at = 0.2
    assert flying.rival is None
    assert flying.foreign == 1
    assert "1 datagrams without effect" in flying.words()[0]


def test_a_vehicle_that_was_started_again_is_met_at_its_new_port_and_is_no_rival() -> None:
    peers = met()
    assert not peers.knock(beat(), THERE, 0.5 * PEER_SILENT)
    assert peers.rival is None  # the first has not spoken since
    later = 1.1 * PEER_SILENT
    assert not peers.knock(beat(2), THERE, later)  # another system is another vehicle
    assert peers.knock(beat(), THERE, later)
    assert peers.heard == peers.to == THERE
    peers.heard_at = later + 1.0
    assert peers.rival is None


def test_a_vehicle_that_comes_back_in_flight_is_only_listened_to() -> None:
    peers = met()
    peers.flying = True
    peers.heard_at = 5.0
    assert not peers.knock(beat(), THERE, 5.0 + 0.9 * PEER_SILENT)
    assert peers.knock(beat(), THERE, 5.0 + 1.1 * PEER_SILENT)
    assert peers.heard == THERE
    assert peers.to is None


def test_what_strangers_send_costs_no_more_than_a_budget() -> None:
    peers = met()
    for i in range(1000):
        peers.heard_at = 0.001 * i
        assert not peers.knock(STATE, ELSEWHERE, 0.001 * i)
    (stranger,) = peers.strangers.values()
    assert stranger.datagrams == 1000
    assert stranger.decoder.counters.frames <= LOOKED_AT * (1.0 / WINDOW + 1)
    rng = random.Random(1)
    for i in range(2000):
        peers.knock(rng.randbytes(40), ("10.0.0.1", i), 1.0)
    assert len(peers.strangers) == STRANGERS_MAX
    assert peers.foreign == 3000


def test_a_flood_does_not_hide_the_vehicle_that_is_waited_for() -> None:
    peers = Peers()
    for i in range(5000):
        peers.knock(b"\xfe" * 1000, ELSEWHERE, 1e-5 * i)
    assert peers.knock(beat(), HERE, 0.06)


def meets(link: wire.Link, data: bytes, now: float) -> None:
    for found in Decoder().datagram(data):
        link.receive(found, now)


def test_on_the_vehicles_own_link_others_are_counted_and_nobody() -> None:
    link = wire.Link()
    meets(link, beat(3, kind=1), 0.0)
    meets(link, beat(1, 18, 8, 191), 0.0)
    assert link.identity is None
    meets(link, beat(1), 0.1)
    meets(link, beat(7, 18, 8, 191), 0.2)
    meets(link, beat(2, kind=10), 0.2)
    assert link.companions(0.3) == 0
    assert not link.others
    assert link.peers.bystanders == {
        "fixed wing (system 3, MAV_TYPE 1)": 1,
        "a companion of system 1": 1,
        "a companion of system 7": 1,
        "rover (system 2, MAV_TYPE 10)": 1,
    }
    meets(link, beat(1, 18, 8, 191), 0.4)
    assert link.companions(0.5) == 1


def test_the_hardwares_number_tells_another_vehicle_under_the_same_id() -> None:
    link = wire.Link()
    meets(link, beat(), 0.0)
    meets(link, frame("AUTOPILOT_VERSION", uid=0x1234, flight_sw_version=0x01100240), 0.1)
    assert link.identity is not None
    assert link.identity.uid == "0000000000001234"
    meets(link, frame("AUTOPILOT_VERSION", uid=0x1234, capabilities=5), 0.2)
    assert link.replaced is None
    meets(link, frame("AUTOPILOT_VERSION", uid=0x9999, capabilities=7), 0.3)
    assert link.replaced == ("0000000000001234", "0000000000009999")
    assert link.identity.capabilities == 5


def test_a_vehicle_met_again_before_the_flight_is_asked_everything_once_more() -> None:
    link = wire.Link(streams=())
    meets(link, beat(), 0.0)
    meets(link, frame("COMMAND_ACK", command=512, result=0, target_system=1, target_component=191), 0.1)
    assert link.is_set_up
    link.outgoing.clear()
    link.on_new_source(5.0)
    assert not link.is_set_up
    assert any(found.format.name == "COMMAND_LONG" for data in link.outgoing for found in Decoder().datagram(data))
