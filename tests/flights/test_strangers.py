"""Others who speak where the vehicle speaks: no state, no mode and no heartbeat of theirs has any effect."""

from __future__ import annotations

import random
import socket
import threading

import pytest

from companion.cli.flying import WAIT_FOR_VEHICLE
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.address import UdpPort
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.loop import NoVehicleError, clock, run
from companion.daemon.progress import status_document
from companion.law.gains import Level
from companion.library.outcome import notes_of_the_link
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.mission import Origin
from companion.vehicle import Mode, OutputLevel
from companion.world import World
from companion.world.events import PortChange, When
from sim_bridge.world_events import COMPANION
from tests.support.flights import Flown, flight

STRANGER = 7
"""An endpoint that is neither the vehicle's nor the ground station's."""
HOLD = 0x03040000


def impostor(system: int, component: int = 1) -> list[bytes]:
    encoder = Encoder(system, component)
    return [
        encoder.message(message("HEARTBEAT"), autopilot=12, type=2, system_status=4, custom_mode=HOLD, base_mode=29),
        encoder.message(
            message("ODOMETRY"), frame_id=1, child_frame_id=1, q=(1, 0, 0, 0), x=50.0, z=3.0, time_usec=99_000_000
        ),
        encoder.message(message("CURRENT_MODE"), custom_mode=HOLD, intended_custom_mode=HOLD),
        encoder.message(message("STATUSTEXT"), severity=0, text="land at once"),
        encoder.message(message("COMMAND_ACK"), command=176, result=2, target_system=1, target_component=191),
        encoder.message(message("PARAM_SET"), target_system=1, target_component=191, param_id="PF_SPEED_SCALE"),
        encoder.message(message("HEARTBEAT"), autopilot=8, type=18, system_status=4),
    ]


def same(a: Flown, b: Flown) -> bool:
    return a.setpoints == b.setpoints and a.notes == b.notes


@pytest.mark.parametrize(("system", "component"), [(1, 1), (2, 1), (1, 191), (255, 190)])
def test_another_port_changes_not_one_setpoint(system: int, component: int) -> None:
    frames = impostor(system, component)

    def speak(flown: Flown, now: float) -> None:
        if now > 1.0 and flown.conductor.memory is not None and round(now * 1000.0) % 40 == 0:
            flown.conductor.receive([(frame, STRANGER) for frame in frames], now)

    spoken = flight(duration=3.0, meddle=speak)
    assert same(spoken, flight(duration=3.0))
    assert spoken.conductor.link.peers.foreign > 100
    assert "endpoint 7" in spoken.conductor.link.peers.words()[0]
    assert "endpoint 7" in str(status_document(spoken.conductor)["others"])
    assert any("endpoint 7" in note for note in notes_of_the_link(spoken.conductor))


def test_a_vehicle_that_comes_back_at_another_port_in_flight_is_listened_to_and_nothing_is_sent_there() -> None:
    heard: list[tuple[float, object, object]] = []

    def watch(flown: Flown, now: float) -> None:
        peers = flown.conductor.link.peers
        heard.append((now, peers.heard, peers.to))

    world = World(events=(PortChange(When(2.0, 2.0)),))
    flown = flight(world=world, duration=20.0, time_out=20.0, meddle=watch)
    moved = next(now for now, source, to in heard if to is None)
    ((_, before, to),) = [entry for entry in heard if entry[0] == heard[0][0]]
    assert before in (None, to)
    assert heard[-1][1] not in (None, before)
    assert all(to is None for now, _, to in heard if now >= moved)
    assert flown.reason is not None
    assert flown.conductor.telemetry.status.mode is not Mode.OFFBOARD  # PX4's own failsafe, and it is known


def test_a_second_vehicle_under_the_same_id_before_the_flight_is_refused() -> None:
    beat = impostor(1)[0]

    def speak(flown: Flown, now: float) -> None:
        if flown.conductor.memory is None and flown.conductor.refusal is None:
            flown.conductor.receive([(beat, STRANGER)], now)

    flown = flight(duration=3.0, meddle=speak, time_out=20.0)
    assert not flown.setpoints
    assert flown.conductor.refusal is not None
    assert "two vehicles are heard, system 1 at endpoint 0 and system 1 at endpoint 7" in flown.conductor.refusal


def test_a_companion_of_another_system_on_the_vehicles_link_is_nobody() -> None:
    beat = Encoder(9, 191).message(message("HEARTBEAT"), autopilot=8, type=18, system_status=4)

    def speak(flown: Flown, now: float) -> None:
        if round(now * 1000.0) % 500 == 0:
            flown.conductor.receive([(beat, COMPANION)], now)

    spoken = flight(duration=3.0, meddle=speak)
    assert same(spoken, flight(duration=3.0))
    assert any("a companion of system 9" in line for line in spoken.conductor.link.peers.words())


def test_bytes_cut_anywhere_into_datagrams_are_flown() -> None:
    rng = random.Random(5)
    held = bytearray()

    def cut(flown: Flown) -> None:
        def pieces(data: bytes, now: float) -> list[bytes]:
            held.extend(data)
            out = []
            while len(held) > 30:
                step = rng.randrange(1, 60)
                out.append(bytes(held[:step]))
                del held[:step]
            return out

        flown.between.down = pieces

    flown = flight(duration=3.0, prepare=cut)
    assert any("-> done" in note for note in flown.notes[-2:]), flown.notes
    assert len(flown.setpoints) > 600
    assert flown.conductor.decoder.counters.garbage_bytes < 200


@pytest.mark.parametrize(("kind", "named"), [(1, "fixed wing (system 1, MAV_TYPE 1)"), (10, "rover (system 1")])
def test_only_a_fixed_wing_or_a_rover_is_no_vehicle_and_is_named(kind: int, named: str) -> None:
    assert WAIT_FOR_VEHICLE <= 20.0
    port = UdpPort("127.0.0.1", 0, listen=True)
    mission = load_mission("circle_r5", Level.RATES)
    conductor = Conductor(Orders(mission, load_vehicle("x500"), OutputLevel.RATES, None, Origin.TAKEOFF), None, clock())
    beat = Encoder(1, 1).message(message("HEARTBEAT"), autopilot=12, type=kind, system_status=4)
    over = threading.Event()

    def speak() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            while not over.wait(0.05):
                link.sendto(beat, port.local)

    speaker = threading.Thread(target=speak)
    speaker.start()
    try:
        with pytest.raises(NoVehicleError) as caught:
            run(conductor, port, None, lambda line: None, 0.5)
    finally:
        over.set()
        speaker.join()
        port.close()
    assert f"only what it cannot fly: {named}" in str(caught.value)
    assert "expected a multirotor" in str(caught.value)


def test_who_speaks_before_the_arming_is_still_before_the_flight() -> None:
    """The plan is made long before the vehicle is ready: until it is armed, a second vehicle is a reason not to."""
    beat = impostor(1)[0]

    def speak(flown: Flown, now: float) -> None:
        if now > 2.0 and flown.conductor.refusal is None:
            flown.conductor.receive([(beat, STRANGER)], now)

    flown = flight(duration=3.0, meddle=speak, from_ground=True, time_out=20.0)
    assert not flown.setpoints
    assert flown.between.bridge.autopilot.commander.armed is False
    assert flown.conductor.refusal is not None
    assert "two vehicles are heard" in flown.conductor.refusal
