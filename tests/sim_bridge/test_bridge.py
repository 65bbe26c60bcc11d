"""The bridge as a whole: held start, starts in the air, determinism, garbage."""

from __future__ import annotations

import hashlib
import random

import pytest

from companion.config.vehicle import load_vehicle
from companion.frames import quaternion_from_euler
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import FORMATS, message
from companion.mavlink.modes import Mode
from companion.world import Deviations, Start, World
from companion.world.events import PayloadDrop, When
from sim_bridge.bridge import Bridge
from tests.support.plant_client import ACCEPTED, SET_INTERVAL, Client

PAPER_START = Start(
    (0.0, 10.0, -20.0), (-1.0, 0.0, 0.0), quaternion_from_euler(1.5707963, 0.3926991, 0.3926991), held=True
)  # fmt: skip


def test_a_held_start_waits_for_the_first_setpoint_in_offboard() -> None:
    client = Client("paper", start=PAPER_START, endpoints=1)
    client.command(SET_INTERVAL, message("ODOMETRY").id, 4000)
    client.run(1.0)
    truth = client.bridge.truth
    assert client.bridge.held
    assert (truth.t_boot, truth.p_n, truth.v_n, truth.q_nb) == (
        0.0, PAPER_START.position_n, PAPER_START.velocity_n, PAPER_START.q_nb,
    )  # fmt: skip
    stamps = {fields["time_usec"] for fields in client.all("ODOMETRY")}
    assert stamps == {0}
    assert len(client.all("ODOMETRY")) == 250
    client.motors(0.02, 0.02, 0.02, 0.02)
    client.run(2.0)  # a setpoint, but not in offboard; and it does not grow old while the clock stands
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    client.run(1.0)
    assert client.bridge.held
    client.motors(0.02, 0.02, 0.02, 0.02)
    assert not client.bridge.held
    assert client.bridge.truth.t_boot == 0.0
    client.bridge.step()
    assert client.bridge.truth.t_boot == 0.001
    assert client.bridge.truth.v_n[0] == pytest.approx(-1.0, abs=0.02)
    client.listen()
    client.run(0.1)
    assert client.last("ODOMETRY")["time_usec"] == pytest.approx(101_000, abs=4_000)


@pytest.mark.parametrize("vehicle", ["x500", "sih", "paper"])
@pytest.mark.parametrize("wind", [(0.0, 0.0, 0.0), (5.0, -3.0, 1.0)])
def test_a_hover_start_does_not_move(vehicle: str, wind: tuple[float, float, float]) -> None:
    start = Start.hover((3.0, -4.0, -20.0), 1.0)
    client = Client(vehicle, World(wind_n=wind), start=start, endpoints=1)
    client.run(2.0)
    assert client.flown is Mode.HOLD
    truth = client.bridge.truth
    assert truth.p_n == pytest.approx(start.position_n, abs=1e-6)
    assert truth.v_n == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    if wind == (0.0, 0.0, 0.0):
        assert truth.q_nb == pytest.approx(start.q_nb, abs=1e-9)
        assert truth.thrust == pytest.approx(load_vehicle(vehicle).weight)


def test_a_machine_that_is_not_what_its_file_says_hovers_too() -> None:
    world = World(truth=Deviations(mass=2.4, thrust_scale=0.9))
    client = Client("x500", world, endpoints=1)
    client.run(1.0)
    assert client.bridge.truth.p_n == pytest.approx((0.0, 0.0, -10.0), abs=1e-6)
    assert client.bridge.truth.thrust == pytest.approx(2.4 * 9.80665)


def test_a_world_too_heavy_to_fly_in_is_refused() -> None:
    with pytest.raises(ValueError, match=r"x500 in world ideal weighs 39.23 N and its rotors lift 34.19 N at most"):
        Client("x500", World(truth=Deviations(mass=4.0)))


def test_a_payload_that_is_most_of_the_vehicle_is_refused() -> None:
    drops = tuple(PayloadDrop(When(t, t), 0.8) for t in (1.0, 2.0))
    with pytest.raises(ValueError, match=r"x500 in world ideal has 2 kg and drops 1.6 kg; expected 1.5 kg at most"):
        Client("x500", World(events=drops))


def test_time_is_a_count_of_steps() -> None:
    client = Client("paper", endpoints=1)
    for _ in range(12_345):
        client.bridge.step()
    assert client.bridge.now == 12.345
    assert client.bridge.truth.t_boot == 12.345


def conversation(seed: int) -> str:
    """A digest of every byte of a flight with garbage, commands and setpoints in it."""
    rng = random.Random(1)
    client = Client("sih", seed=seed)
    digest = hashlib.sha256()
    encoder = Encoder(1, 191)
    for i in range(1500):
        if i % 5 == 0:
            values = message("SET_ATTITUDE_TARGET").values(
                type_mask=0x80, thrust=0.5, body_roll_rate=rng.uniform(-0.3, 0.3), target_system=1, target_component=1
            )
            client.bridge.receive(encoder.encode(message("SET_ATTITUDE_TARGET"), values))
        if i == 100:
            client.mode(Mode.OFFBOARD)
        if i % 100 == 50:
            client.bridge.receive(rng.randbytes(60))
        client.bridge.step()
        for endpoint, datagram in client.bridge.datagrams():
            digest.update(bytes([endpoint]) + datagram)
    return digest.hexdigest()


def test_the_same_seed_gives_the_same_bytes() -> None:
    assert conversation(3) == conversation(3)


def test_garbage_never_raises_and_is_counted() -> None:
    rng = random.Random(9)
    bridge = Bridge(load_vehicle("x500"), World(), direct=True)
    encoder = Encoder(1, 191)
    formats = list(FORMATS.values())
    for i in range(4000):
        fmt = rng.choice(formats)
        frame = bytearray(encoder.encode(fmt, fmt.unpack(rng.randbytes(fmt.size))))  # valid frames of any nonsense
        if rng.random() < 0.3:
            frame[rng.randrange(len(frame))] ^= 1 << rng.randrange(8)
        if rng.random() < 0.1:
            frame = bytearray(rng.randbytes(rng.randrange(300)))
        bridge.receive(bytes(frame), i % 2)
        if i % 20 == 0:
            bridge.step()
            bridge.datagrams()
    counters = bridge.counters[0]
    assert counters.bad_crc > 50
    assert counters.garbage_bytes > 1000
    assert all(abs(x) < 1e6 for x in bridge.truth.p_n)


def commanded_nonsense(bridge: Bridge, rng: random.Random) -> None:
    encoder = Encoder(255, 190)
    values = [float("nan"), float("inf"), -1.0, 0.0, 1.0, 2.0, 4.0, 6.0, 21196.0, 1e30, 31.0, 331.0, 4000.0]
    parameters = {f"param{i}": rng.choice(values) for i in range(1, 8)}
    command = rng.choice((20, 21, 22, 176, 246, 400, 510, 511, 512, 31000))
    fmt = message("COMMAND_LONG")
    bridge.receive(
        encoder.message(fmt, command=command, target_system=1, target_component=1, **parameters), 1
    )  # fmt: skip


def test_any_command_with_any_numbers_gets_an_answer_if_it_is_one_that_does() -> None:
    rng = random.Random(11)
    client = Client("sih")
    for _ in range(3000):
        before = len(client.all("COMMAND_ACK", 1)) if client.heard else 0
        commanded_nonsense(client.bridge, rng)
        client.listen()
        assert before <= len(client.all("COMMAND_ACK", 1)) <= before + 1
        client.heard.clear()
        if rng.random() < 0.1:
            client.run(0.02)
            client.heard.clear()
