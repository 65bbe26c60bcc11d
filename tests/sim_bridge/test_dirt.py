"""The dirt of a world: what becomes of datagrams, what the vehicle says wrongly, who else acts. Each on the wire."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

from companion.frames import euler_from_rotation, rotation_matrix
from companion.mavlink.codec import Decoder, Frame
from companion.mavlink.modes import Mode
from companion.world import World
from companion.world.events import (
    After,
    EstimatorReset,
    Event,
    FrozenState,
    Impostor,
    LinkCut,
    LinkDelay,
    LinkDuplicate,
    LinkRecut,
    LinkRepeat,
    LinkThin,
    MotorFailure,
    NotANumber,
    OdometryFrames,
    OffsetState,
    Operator,
    Order,
    Part,
    PortChange,
    Saying,
    Stamps,
    Sticks,
    Stranger,
    When,
    WrongStamps,
)
from sim_bridge.strangers import FIRST_STRANGER, source
from tests.support.plant_client import ACCEPTED, SET_INTERVAL, Client

ODOMETRY = frozenset({"ODOMETRY"})


def hovering(*events: Event) -> Client:
    """A hover in which the state is asked for 125 times a second."""
    client = Client("x500", World(events=events))
    assert client.command(SET_INTERVAL, 331, 8000) == ACCEPTED
    return client


def stamps(client: Client, since: float) -> list[float]:
    """The stamps of the states heard (s)."""
    return [fields["time_usec"] * 1e-6 for fields in client.all("ODOMETRY", since=since)]


# What becomes of datagrams


def test_a_message_kind_comes_twice_and_later_while_the_rest_does_not() -> None:
    client = hovering(LinkDuplicate(When(1.0), messages=ODOMETRY, delay=0.015))
    client.run(2.0)
    assert len(set(stamps(client, -1.0))) == len(stamps(client, 0.0)) - 123  # those of the last second came twice
    late = [h.at - h.fields["time_usec"] * 1e-6 for h in client.heard if h.name == "ODOMETRY" and h.at > 1.1]
    assert sorted({round(x, 3) for x in late}) == [0.0, 0.016]  # the next step after 15 ms
    attitudes = [fields["time_boot_ms"] for fields in client.all("ATTITUDE", since=1.1)]
    assert len(attitudes) == len(set(attitudes))


def test_one_kind_is_silent_and_one_way_is_cut() -> None:
    client = hovering(
        LinkCut(When(1.0, 2.0), messages=frozenset({"HEARTBEAT", "CURRENT_MODE"})), LinkCut(When(3.0), down=False)
    )
    client.run(4.0)
    beats = [h.at for h in client.heard if h.name == "HEARTBEAT" and h.endpoint == 0]
    assert max(b - a for a, b in itertools.pairwise(beats)) > 1.5
    assert max(b - a for a, b in itertools.pairwise(stamps(client, 0.0))) < 0.01
    assert client.command(SET_INTERVAL, 331, 4000) is None  # it does not get there
    assert client.command(176, 1, 4, 3, endpoint=1) == ACCEPTED  # the operator's does


def test_the_last_state_comes_again_and_again() -> None:
    client = hovering(LinkRepeat(When(1.0, 1.5), messages=ODOMETRY))
    client.run(2.0)
    repeated = stamps(client, 1.01)[:50]
    assert len(set(repeated)) == 1
    assert stamps(client, 1.6) == sorted(set(stamps(client, 1.6)))


def test_a_delay_grows_in_order_and_drains_in_order() -> None:
    client = hovering(LinkDelay(When(1.0, 3.0), up=False, delay=0.02, growth=0.1))
    client.run(4.0)
    ages = {round(h.at, 2): h.at - h.fields["time_usec"] * 1e-6 for h in client.heard if h.name == "ODOMETRY"}
    assert ages[0.96] == pytest.approx(0.0, abs=1e-6)
    assert ages[2.0] == pytest.approx(0.02 + 0.1 * 0.9, abs=0.02)
    assert stamps(client, 0.0) == sorted(stamps(client, 0.0))
    assert max(b.at - a.at for a, b in itertools.pairwise([h for h in client.heard if h.name == "ODOMETRY"])) < 0.04


def test_a_thin_link_lets_so_many_through() -> None:
    client = hovering(LinkThin(When(1.0), up=False, messages=ODOMETRY, rate=14.0))
    client.run(3.0)
    assert len(stamps(client, 1.0)) == pytest.approx(28, abs=1)
    assert len(client.all("ATTITUDE", since=1.0)) == pytest.approx(200, abs=3)


def test_bytes_are_cut_anywhere_and_nothing_is_lost() -> None:
    client = hovering(LinkRecut(When(1.0, 2.0), size=77))
    whole = Decoder()
    frames: list[Frame] = []
    sizes = set()
    for _ in range(500):
        client.bridge.step()
        for endpoint, datagram in client.bridge.datagrams():
            if endpoint == 0:
                frames += whole.stream(datagram)
                if 1.1 < client.bridge.now < 1.9:
                    sizes.add(len(datagram))
    assert max(sizes) == 77
    assert whole.counters.garbage_bytes == whole.counters.lost == 0
    stamps = [f.values[0] for f in frames if f.format.name == "ODOMETRY"]
    assert stamps == list(range(stamps[0], stamps[-1] + 1, 8000))


def test_a_command_in_pieces_is_a_command() -> None:
    client = hovering(LinkRecut(When(0.5), size=11, wait=0.002))
    client.run(1.0)
    before = len(client.bridge.log)
    assert client.command(SET_INTERVAL, 331, 100_000) is None  # it is still on its way
    client.run(1.0)
    assert len(stamps(client, 1.1)) < 20
    assert len(client.bridge.log) == before


def test_the_ground_stations_link_is_another() -> None:
    client = hovering(LinkCut(When(1.0), companion=False, ground_station=True))
    client.run(2.0)
    assert client.all("ATTITUDE", since=1.1)
    assert not client.all("ATTITUDE", 1, since=1.1)


# What the vehicle says wrongly


def test_a_frozen_position_has_its_noise_and_the_velocity_goes_on() -> None:
    client = hovering(FrozenState(When(1.0), Part.POSITION, 1e-6))
    client.rates(thrust=0.57)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    client.run(2.0, lambda: client.rates(q=-0.2, thrust=0.57))
    frozen = client.all("ODOMETRY", since=1.01)
    spread = [fields["x"] - frozen[0]["x"] for fields in frozen]
    assert 0.0 < max(map(abs, spread)) < 1e-5
    assert frozen[-1]["vx"] > frozen[0]["vx"] + 0.3
    assert frozen[-1]["q"] != frozen[0]["q"]
    assert client.bridge.truth.p_n[0] > frozen[-1]["x"] + 0.1


@pytest.mark.parametrize(
    ("stamps", "expected"),
    [(Stamps.ZERO, {0}), (Stamps.HUGE, {2**64 - 1}), (Stamps.FROZEN, {1_008_000})],
)
def test_wrong_stamps(stamps: Stamps, expected: set[int]) -> None:
    client = hovering(WrongStamps(When(1.0), stamps))
    client.run(1.5)
    assert {fields["time_usec"] for fields in client.all("ODOMETRY", since=1.006)} == expected
    assert client.all("HIGHRES_IMU", since=1.4)[-1]["time_usec"] > 1_400_000


def test_stamps_in_milliseconds() -> None:
    client = hovering(WrongStamps(When(0.0), Stamps.MILLISECONDS))
    client.run(1.0)
    assert client.last("ODOMETRY")["time_usec"] == 1000


def test_an_offset_is_only_said_and_ends_and_a_glitch_is_not_counted() -> None:
    client = hovering(
        OffsetState(When(1.0, 1.2), (20.0, 0.0, -1.0), (0.0, 2.0, 0.0), math.pi / 2),
        EstimatorReset(When(2.0, 2.0), (20.0, 0.0, 0.0), counted=False),
    )
    client.run(1.1)
    said = client.last("ODOMETRY")
    assert (said["x"], said["z"], said["vy"]) == pytest.approx((20.0, -11.0, 2.0), abs=1e-3)
    assert euler_from_rotation(rotation_matrix(said["q"]))[0] == pytest.approx(math.pi / 2, abs=1e-3)
    client.run(0.5)
    assert client.last("ODOMETRY")["x"] == pytest.approx(0.0, abs=1e-3)
    counter = client.last("ODOMETRY")["reset_counter"]
    client.run(0.5)
    assert client.last("ODOMETRY")["x"] > 19.0
    assert client.last("ODOMETRY")["reset_counter"] == counter


def test_what_no_vehicle_is() -> None:
    client = hovering(
        NotANumber(When(1.0), Part.POSITION, 3e38), OdometryFrames(When(1.0), 4, 12), Impostor(When(0.0), 10, 3)
    )
    client.run(1.5)
    said = client.last("ODOMETRY")
    assert said["x"] > 1e38 and math.isfinite(said["q"][0])
    assert (said["frame_id"], said["child_frame_id"]) == (4, 12)
    assert (client.last("HEARTBEAT")["type"], client.last("HEARTBEAT")["autopilot"]) == (10, 3)
    assert client.command(512, 331) == ACCEPTED  # asked for, it is told as wrongly
    assert client.last("ODOMETRY")["frame_id"] == 4


def test_all_motors_weak() -> None:
    client = hovering(MotorFailure(When(1.0), None, 0.9))
    client.run(1.9)
    assert client.bridge.plant.left == (0.9,) * 4


# Who acts


@pytest.mark.parametrize(
    ("order", "mode"),
    [(Order.LAND, Mode.LAND), (Order.RETURN, Mode.RETURN), (Order.TAKE_OFF, Mode.TAKEOFF), (Order.POSITION, Mode.HOLD)],
)
def test_the_operator_asks_for_a_mode(order: Order, mode: Mode) -> None:
    client = hovering(Operator(When(1.0, 1.0), order))
    client.run(0.99)
    assert client.flown is Mode.HOLD
    client.run(0.1)
    assert client.flown is mode  # Position needs the sticks
    ((at, asked, result),) = client.bridge.orders
    assert at == pytest.approx(1.0, abs=0.01)
    assert asked.order is order
    assert (result == ACCEPTED) is (mode is not Mode.HOLD)
    assert not client.all("COMMAND_ACK", since=0.1)  # the answer is for the operator


def test_the_operator_kills_in_the_air_and_disarms_on_the_ground_only() -> None:
    client = hovering(Operator(When(1.0, 1.0), Order.DISARM), Operator(When(2.0, 2.0), Order.KILL))
    client.run(1.5)
    assert client.bridge.autopilot.commander.armed
    client.run(0.6)
    assert not client.bridge.autopilot.commander.armed


def test_an_event_counts_from_the_arming() -> None:
    client = Client("x500", World(events=(Operator(When(0.06, 0.06, After.ARMED), Order.DISARM),)), landed=True)
    client.run(5.0)
    assert client.command(400, 1) == ACCEPTED
    client.run(0.05)
    assert client.bridge.autopilot.commander.armed
    client.run(0.02)
    assert not client.bridge.autopilot.commander.armed


def test_the_sticks_let_the_operator_choose_position() -> None:
    client = hovering(Sticks(When(0.5, 3.0), pitch=0.0), Operator(When(1.0, 1.0), Order.POSITION))
    client.run(1.2)
    assert client.flown is Mode.POSITION
    client.run(4.0)
    assert client.flown is not Mode.POSITION  # the sticks are lost


def test_strangers_speak_from_their_own_ports_or_through_the_vehicle() -> None:
    everything = frozenset(Saying)
    own = Stranger(When(1.0, 2.0), 2, 1, says=everything, mode=Order.LAND, armed=False, position_n=(50.0, 0.0, -1.0))
    forwarded = Stranger(When(1.0), 3, 191, 18, 8, own_port=False)
    client = hovering(own, forwarded)
    decoder = Decoder()
    heard: list[tuple[int, Frame]] = []
    for _ in range(700):
        client.bridge.step()
        for endpoint, datagram in client.bridge.datagrams():
            heard += [(endpoint, frame) for frame in decoder.datagram(datagram) if frame.system in (2, 3)]
    ours = [frame for endpoint, frame in heard if endpoint == FIRST_STRANGER]
    counts = {name: sum(f.format.name == name for f in ours) for name in ("HEARTBEAT", "CURRENT_MODE", "ODOMETRY")}
    assert counts == {"HEARTBEAT": 1, "CURRENT_MODE": 10, "ODOMETRY": 50}
    state: dict[str, Any] = next(f.format.named(f.values) for f in ours if f.format.name == "ODOMETRY")
    assert (state["x"], state["frame_id"]) == (50.0, 1)
    passed_on = [(endpoint, f.component) for endpoint, f in heard if f.system == 3]
    assert passed_on == [(0, 191)] * 2


def test_the_vehicle_changes_its_port() -> None:
    client = hovering(PortChange(When(1.0, 1.0)))
    client.run(0.9)
    assert client.bridge.ports_dialled == 0
    client.run(0.2)
    assert client.bridge.ports_dialled == 1
    assert len({source(0, 0), source(0, 1), source(FIRST_STRANGER, 1), source(FIRST_STRANGER + 1, 1)}) == 4
