"""What happens in a world at a time: each event does what it says, and only that, and only then."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.frames import Vec3, euler_from_rotation, rotation_matrix, tilt
from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode
from companion.world import Deviations, Event, World
from companion.world.events import (
    After,
    ClockJump,
    EstimatorReset,
    Hold,
    LinkCut,
    MotorFailure,
    NotANumber,
    Part,
    PayloadDrop,
    Push,
    Silence,
    When,
    Wind,
)
from tests.support.plant_client import ACCEPTED, SET_INTERVAL, Client

STILL: Vec3 = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)


def hovering(*events: Event, vehicle: str = "x500", **world: Any) -> Client:
    return Client(vehicle, World(events=events, **world), endpoints=2)


# Events


def test_a_push_gives_its_impulse() -> None:
    push = Push(When(1.0, 1.5), (4.0, -2.0, 0.0))
    plant_only = World(events=(push,), truth=Deviations(drag=0.0))
    client = Client("x500", plant_only, endpoints=1)
    client.run(1.0)
    before = client.bridge.truth.v_n
    client.run(0.1)
    after = client.bridge.truth.v_n
    gained = (after[0] - before[0], after[1] - before[1])
    assert gained == pytest.approx((4.0 / 2.0 * 0.1, -2.0 / 2.0 * 0.1), rel=0.05)  # the loops hardly lean yet
    client.run(0.41)
    assert client.bridge.plant.push_n == STILL
    client.run(8.0)
    assert client.bridge.truth.p_n == pytest.approx((0.0, 0.0, -10.0), abs=0.2)


def test_a_payload_that_falls_off_makes_it_lighter_and_easier_to_blow_away() -> None:
    client = hovering(PayloadDrop(When(1.0, 1.0), 0.4), truth=Deviations(drag=0.5, quadratic_drag=0.1))
    client.run(0.9)
    assert client.bridge.plant.vehicle.mass == 2.0
    thrust, before = client.bridge.truth.thrust, client.bridge.truth.v_n[2]
    client.run(0.11)
    plant = client.bridge.plant
    assert (plant.vehicle.mass, plant.vehicle.drag) == pytest.approx((1.6, 0.625))
    climbs = client.bridge.truth.a_n[2]
    assert climbs == pytest.approx(9.80665 - thrust / 1.6, rel=0.02)
    assert before == pytest.approx(0.0, abs=1e-6)
    client.run(8.0)
    assert client.bridge.truth.thrust == pytest.approx(1.6 * 9.80665, rel=1e-3)


def test_a_hold_keeps_the_pose_and_then_lets_go() -> None:
    client = hovering(Hold(When(0.5, 2.5, After.OFFBOARD)))
    client.run(1.0)
    client.rates(0.0, -0.5, 0.0, thrust=0.57)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    client.run(0.5, lambda: client.rates(0.0, -0.2, 0.0, thrust=0.57))
    client.run(0.02, lambda: client.rates(0.0, -0.2, 0.0, thrust=0.57))
    held = client.bridge.truth
    assert held.v_n == held.w_b == STILL
    client.run(1.9, lambda: client.rates(0.0, -0.2, 0.0, thrust=0.57))
    now = client.bridge.truth
    assert (now.p_n, now.q_nb, now.v_n, now.w_b) == (held.p_n, held.q_nb, STILL, STILL)
    assert client.last("ODOMETRY")["vx"] == 0.0
    client.run(0.3, lambda: client.rates(0.0, -0.2, 0.0, thrust=0.57))
    assert client.bridge.truth.v_n[0] > 0.0  # nose down flies north


def test_a_motor_that_fails_gives_what_is_left() -> None:
    client = hovering(MotorFailure(When(1.0), 2, 0.5))
    client.run(0.9)
    even = client.bridge.truth.rotor_thrusts
    assert max(even) - min(even) < 1e-6
    client.run(0.2)
    thrusts, commands = client.bridge.truth.rotor_thrusts, client.bridge.autopilot.commands
    assert thrusts[1] < 0.85 * thrusts[0]
    assert commands[1] > 1.1 * commands[0]  # the loops ask it for more
    client = hovering(MotorFailure(When(1.0, 1.1), 4))
    client.run(1.08)
    assert client.bridge.truth.rotor_thrusts[3] < 0.3
    client.run(0.1)
    assert client.bridge.truth.rotor_thrusts[3] > 2.0


def test_another_wind_comes_and_goes() -> None:
    client = hovering(Wind(When(1.0, 2.0), (10.0, 0.0, 0.0)))
    client.run(1.5)
    assert client.bridge.plant.wind_n == (10.0, 0.0, 0.0)
    assert client.bridge.truth.v_n[0] > 0.1
    client.run(1.0)
    assert client.bridge.plant.wind_n == STILL


def test_a_reset_moves_the_estimate_and_counts() -> None:
    reset = EstimatorReset(When(1.0), (0.5, -0.25, 0.0), yaw=math.radians(90.0))
    client = hovering(reset)
    client.command(SET_INTERVAL, message("ODOMETRY").id, 8000)
    client.run(0.99)
    before = client.last("ODOMETRY")
    client.run(0.03)
    after = client.last("ODOMETRY")
    assert (after["x"] - before["x"], after["y"] - before["y"]) == pytest.approx((0.5, -0.25), abs=1e-3)
    heading = euler_from_rotation(rotation_matrix(tuple(after["q"])))[0]
    assert heading == pytest.approx(math.pi / 2.0, abs=1e-3)
    assert (before["reset_counter"], after["reset_counter"]) == (11, 13)
    client.run(0.5)
    assert client.last("ODOMETRY")["reset_counter"] == 13


def test_a_vehicle_in_hold_flies_back_gently_after_a_reset() -> None:
    """As PX4 does: the reference jumps along, so that there is no step for the position loop to take."""
    client = hovering(EstimatorReset(When(1.0), (5.0, 0.0, 1.0), yaw=math.radians(30.0)))
    most = 0.0
    for _ in range(50):
        client.run(0.3)
        most = max(most, tilt(rotation_matrix(client.bridge.truth.q_nb)))
    assert most < math.radians(25.0)  # 3 m/s^2 of MPC_ACC_HOR and a little
    estimate = client.bridge.autopilot.estimate
    assert estimate.p_n == pytest.approx((0.0, 0.0, -10.0), abs=0.2)
    assert client.bridge.truth.p_n == pytest.approx((-5.0, 0.0, -11.0), abs=0.2)
    heading = euler_from_rotation(rotation_matrix(client.bridge.truth.q_nb))[0]
    assert heading == pytest.approx(0.0, abs=0.05)  # the nose stays where it was


@pytest.mark.parametrize("by", [5.0, -0.5, -100.0])
def test_a_clock_jump_moves_the_stamps_and_nothing_else(by: float) -> None:
    client = hovering(ClockJump(When(1.0), by))
    client.run(0.99)
    before = client.last("ATTITUDE_QUATERNION")["time_boot_ms"]
    client.run(0.05)
    after = client.last("ATTITUDE_QUATERNION")["time_boot_ms"]
    assert after - before == pytest.approx(max(1e3 * by, -before), abs=60)
    client.run(2.0)
    assert client.flown is Mode.HOLD
    assert client.height == pytest.approx(10.0, abs=1e-3)


def test_a_state_that_is_not_a_number_is_only_said() -> None:
    client = hovering(NotANumber(When(1.0, 1.2), Part.POSITION), NotANumber(When(2.0, 2.2), Part.STATE))
    client.run(1.1)
    odometry, attitude = client.last("ODOMETRY"), client.last("ATTITUDE_QUATERNION")
    assert math.isnan(odometry["x"]) and math.isnan(odometry["vz"])
    assert not math.isnan(odometry["q"][0]) and not math.isnan(attitude["q1"])
    client.run(1.0)
    assert math.isnan(client.last("ATTITUDE_QUATERNION")["rollspeed"])
    assert math.isnan(client.last("LOCAL_POSITION_NED")["vx"])
    client.run(1.0)
    assert client.last("ODOMETRY")["z"] == pytest.approx(-10.0, abs=1e-3)
    assert client.height == pytest.approx(10.0, abs=1e-3)


@pytest.mark.parametrize(
    ("part", "silent", "heard"),
    [
        (Part.ATTITUDE, {"ATTITUDE", "ATTITUDE_QUATERNION", "ODOMETRY"}, {"LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"}),
        (Part.POSITION, {"ODOMETRY", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"}, {"ATTITUDE", "ATTITUDE_QUATERNION"}),
        (Part.STATE, {"ODOMETRY", "LOCAL_POSITION_NED", "ATTITUDE"}, {"TIMESYNC"}),
    ],
)
def test_a_part_of_the_state_falls_silent(part: Part, silent: set[str], heard: set[str]) -> None:
    client = hovering(Silence(When(1.0, 2.0), part))
    client.run(1.99)
    names_heard = {each.name for each in client.heard if each.at > 1.05 and each.endpoint == 0}
    assert not names_heard & silent
    assert heard <= names_heard
    client.run(0.3)
    assert silent <= {each.name for each in client.heard if each.at > 2.0}


def test_a_cut_link_lets_nothing_through_and_comes_back() -> None:
    client = hovering(LinkCut(When(1.0, 2.0)), LinkCut(When(3.0, 3.5), down=False))
    client.run(1.9)
    assert not [each for each in client.heard if each.at > 1.01 and each.endpoint == 0]
    assert [each for each in client.heard if each.at > 1.5 and each.endpoint == 1]  # the ground station's own link
    assert client.command(SET_INTERVAL, 31, 10_000) is None
    client.run(0.3)
    assert client.command(SET_INTERVAL, 31, 10_000) == ACCEPTED
    client.run(1.0)
    assert client.command(SET_INTERVAL, 31, 10_000) is None
    assert [each for each in client.heard if each.at > 3.1 and each.endpoint == 0]


def test_an_event_can_be_added_in_flight() -> None:
    client = hovering()
    client.run(1.0)
    client.bridge.world_events.add(Push(When(1.5, 2.0), (5.0, 0.0, 0.0)))
    client.run(1.0)
    assert client.bridge.truth.v_n[0] > 0.3
