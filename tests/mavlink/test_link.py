"""The conversation with a vehicle: who it is, commands until confirmed, nobody else's word."""

from __future__ import annotations

from companion.mavlink import link as wire
from companion.mavlink import requests
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Value, message
from companion.mavlink_common import MAV_CMD_REQUEST_MESSAGE, MAV_CMD_SET_MESSAGE_INTERVAL
from companion.vehicle import Mode


class Peer:
    """A vehicle played by the test: what it hears, and what it says."""

    def __init__(self, link: wire.Link, system: int = 1, component: int = 1) -> None:
        self.link = link
        self.encoder = Encoder(system, component)
        self.decoder = Decoder()

    def says(self, name: str, now: float, **fields: Value) -> tuple[requests.Command, int] | None:
        (frame,) = Decoder().datagram(self.encoder.message(message(name), **fields))
        return self.link.receive(frame, now)

    def hears(self) -> list[Frame]:
        outgoing, self.link.outgoing = self.link.outgoing, []
        return [frame for datagram in outgoing for frame in self.decoder.datagram(datagram)]

    def commands(self) -> list[tuple[int, float, int]]:
        named = [f.format.named(f.values) for f in self.hears() if f.format.name == "COMMAND_LONG"]
        return [(c["command"], c["param2"], c["confirmation"]) for c in named]

    def heartbeat(self, now: float, autopilot: int = 12) -> None:
        self.says("HEARTBEAT", now, autopilot=autopilot, type=2, system_status=4)

    def acknowledges(
        self, command: int, result: int, now: float, target: int = 191
    ) -> tuple[requests.Command, int] | None:
        return self.says("COMMAND_ACK", now, command=command, result=result, target_system=1, target_component=target)


def test_it_heartbeats_from_the_start_and_takes_the_vehicles_system_id() -> None:
    link = wire.Link()
    vehicle = Peer(link, system=7)
    link.on_timer(0.0)
    (beat,) = vehicle.hears()
    assert beat.format.named(beat.values) | {"mavlink_version": 3} == {
        "custom_mode": 0, "type": 18, "autopilot": 8, "base_mode": 0, "system_status": 4, "mavlink_version": 3,
    }  # fmt: skip
    vehicle.heartbeat(0.5)
    assert link.identity is not None
    assert link.identity.system == 7
    link.on_timer(1.0)
    assert {(f.system, f.component) for f in vehicle.hears()} == {(7, 191)}


def test_ground_stations_and_other_companions_are_no_vehicle() -> None:
    link = wire.Link()
    Peer(link, 255, 190).says("HEARTBEAT", 0.0, autopilot=8, type=6)
    Peer(link, 1, 191).says("HEARTBEAT", 0.0, autopilot=8, type=18)
    assert link.identity is None
    Peer(link, 1, 1).heartbeat(0.1)
    Peer(link, 2, 1).heartbeat(0.2, autopilot=3)
    assert link.identity is not None
    assert link.identity.system == 1
    assert link.others == {2: 3}


def test_streams_are_asked_for_one_by_one_until_answered() -> None:
    link = wire.Link(streams=(requests.stream(331, 250.0), requests.stream(436, 20.0)))
    vehicle = Peer(link)
    vehicle.heartbeat(0.0)
    assert vehicle.commands() == [(MAV_CMD_REQUEST_MESSAGE, 0.0, 0)]
    vehicle.acknowledges(MAV_CMD_REQUEST_MESSAGE, 0, 0.01)
    assert vehicle.commands() == [(MAV_CMD_SET_MESSAGE_INTERVAL, 4000.0, 0)]
    link.on_timer(0.3)
    assert vehicle.commands() == []
    link.on_timer(0.6)  # no answer
    assert vehicle.commands() == [(MAV_CMD_SET_MESSAGE_INTERVAL, 4000.0, 1)]
    vehicle.acknowledges(MAV_CMD_SET_MESSAGE_INTERVAL, 0, 0.61)
    assert vehicle.commands() == [(MAV_CMD_SET_MESSAGE_INTERVAL, 50000.0, 0)]
    vehicle.acknowledges(MAV_CMD_SET_MESSAGE_INTERVAL, 4, 0.62)  # not streamed by this vehicle: go on
    link.on_timer(1.3)
    assert vehicle.commands() == []


def ready(link: wire.Link) -> Peer:
    vehicle = Peer(link)
    vehicle.heartbeat(0.0)
    vehicle.acknowledges(MAV_CMD_REQUEST_MESSAGE, 0, 0.01)
    vehicle.hears()
    return vehicle


def test_a_command_of_the_flight_is_sent_once_each_time_it_is_asked_for() -> None:
    link = wire.Link()
    vehicle = ready(link)
    offboard = requests.set_mode(Mode.OFFBOARD)
    link.requests.ask(offboard, 0, 1.0)
    assert vehicle.commands() == [(176, 6.0, 0)]
    link.on_timer(1.6)
    assert vehicle.commands() == []  # nothing is repeated that was not decided anew
    link.requests.ask(offboard, 1, 1.7)
    assert vehicle.commands() == [(176, 6.0, 1)]
    assert vehicle.acknowledges(176, 1, 1.72) == (offboard, 1)


def test_answers_to_others_and_repeated_answers_do_not_count() -> None:
    link = wire.Link()
    vehicle = ready(link)
    link.requests.ask(requests.ARM, 0, 1.0)
    assert vehicle.acknowledges(400, 0, 1.01, target=190) is None
    assert Peer(link, 1, 50).acknowledges(400, 0, 1.01) is None  # not the autopilot
    assert vehicle.acknowledges(22, 0, 1.01) is None
    assert vehicle.acknowledges(400, 0, 1.02) == (requests.ARM, 0)
    assert vehicle.acknowledges(400, 0, 1.03) is None


def test_an_answer_is_never_taken_for_a_later_command() -> None:
    """Modes share one command: OFFBOARD's late acceptance must not count as HOLD's."""
    link = wire.Link()
    vehicle = ready(link)
    offboard, hold = requests.set_mode(Mode.OFFBOARD), requests.set_mode(Mode.HOLD)
    link.requests.ask(offboard, 0, 1.0)
    link.requests.ask(hold, 0, 1.1)
    assert vehicle.acknowledges(176, 0, 1.12) == (offboard, 0)
    assert vehicle.acknowledges(176, 0, 1.13) == (hold, 0)
    link.requests.ask(offboard, 0, 2.0)  # lost
    link.requests.ask(hold, 0, 3.1)
    assert vehicle.acknowledges(176, 0, 3.12) == (hold, 0)


def test_who_it_is_and_what_it_can_do() -> None:
    link = wire.Link()
    vehicle = ready(link)
    assert link.identity is not None
    assert link.identity.direct_motors is None
    vehicle.says("AUTOPILOT_VERSION", 0.1, capabilities=59647, flight_sw_version=0x01100240)
    assert link.identity.direct_motors is False
    assert link.identity.version == (1, 16, 2)
    vehicle.says("AUTOPILOT_VERSION", 0.1, capabilities=59647 | 1024)
    assert link.identity.direct_motors is True


def test_round_trip_time() -> None:
    link = wire.Link()
    vehicle = ready(link)
    link.on_timer(5.0)
    (request,) = [f for f in vehicle.hears() if f.format.name == "TIMESYNC"]
    assert request.values == (0, 5_000_000_000)
    vehicle.says("TIMESYNC", 5.02, tc1=123, ts1=5_000_000_000)
    assert link.round_trip is not None
    assert abs(link.round_trip - 0.02) < 1e-9
    vehicle.says("TIMESYNC", 5.5, tc1=0, ts1=99)  # the vehicle's own request
    assert abs(link.round_trip - 0.02) < 1e-9


def test_what_the_vehicle_says_in_words() -> None:
    link = wire.Link()
    vehicle = ready(link)
    vehicle.says("STATUSTEXT", 1.0, severity=4, text="Landing at current position\t")
    assert link.texts == [(4, "Landing at current position")]


def test_what_the_vehicle_says_is_data_and_no_command_to_a_terminal() -> None:
    link = wire.Link()
    vehicle = ready(link)
    vehicle.says("STATUSTEXT", 1.0, severity=4, text="\x1b[2J\rhold -> land: \n\u202eok\t")
    ((_, text),) = link.texts
    assert text == "\\x1b[2J\\rhold -> land: \\n\\u202eok"
    assert text.isprintable()
