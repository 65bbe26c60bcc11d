"""Steps of rate, thrust, place and velocity, as PX4's own simulated quadrotor answers them (px4.md 5, io.md 5)."""

from __future__ import annotations

import itertools
import math

import pytest

from companion.config.world.world import load_world
from companion.mavlink.modes import Mode
from tests.support.plant_client import Client


def rate_step(axis: int, vehicle: str = "sih") -> list[float]:
    """The true body rate over the demand, every 4 ms after a step in offboard hover."""
    client = Client(vehicle, load_world("sih"), endpoints=1)
    hover = client.bridge.autopilot.cascade.hover
    client.rates(thrust=hover)
    client.mode(Mode.OFFBOARD)
    client.run(0.2, lambda: client.rates(thrust=hover))
    demand = [0.7 if i == axis else 0.0 for i in range(3)]
    response = []
    for _ in range(300):
        client.run(0.004, lambda: client.rates(*demand, thrust=hover))
        response.append(client.bridge.truth.w_b[axis] / 0.7)
    return response


def time_to(level: float, response: list[float]) -> float:
    """ms from the step to ``level``, between the samples by a straight line."""
    for i, (before, after) in enumerate(itertools.pairwise([0.0, *response])):
        if after >= level:
            return 4.0 * (i + (level - before) / (after - before))
    raise AssertionError(f"never reached {level}")


@pytest.mark.parametrize(
    ("axis", "times", "overshoot"),
    [(0, (30, 76, 92, 136), 1.075), (1, (30, 76, 92, 136), 1.075), (2, (140, 350, 432, 875), None)],
)
def test_rate_steps_are_px4s(axis: int, times: tuple[float, ...], overshoot: float | None) -> None:
    """px4.md section 5, measured on PX4 with the vehicle `sih`: to 10 % and 4 points of overshoot."""
    response = rate_step(axis)
    seen = [time_to(level, response) for level in (0.1, 0.5, 0.63, 0.9)]
    assert seen == pytest.approx(times, rel=0.1)
    if overshoot is None:
        assert max(response) < 1.0
        assert response[249] == pytest.approx(0.91, abs=0.04)
    else:
        assert max(response) == pytest.approx(overshoot, abs=0.04)


def test_a_thrust_step_is_the_motors_lag() -> None:
    """The setpoint acts one step after the state it answers; then the force follows with 50 ms."""
    client = Client("sih", load_world("sih"), endpoints=1)
    client.rates(thrust=0.4905)
    client.mode(Mode.OFFBOARD)
    client.run(0.5, lambda: client.rates(thrust=0.4905))
    forces = []
    for _ in range(75):
        client.rates(thrust=0.5905)
        client.bridge.step()
        forces.append((client.bridge.truth.thrust / 20.0 - 0.4905) / 0.1)
    assert forces[0] == pytest.approx(0.0, abs=1e-3)
    assert forces[13] == pytest.approx(1.0 - math.exp(-0.052 / 0.05), abs=1e-3)
    assert forces[-1] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("vehicle", ["x500", "paper"])
def test_other_vehicles_answer_as_quickly(vehicle: str) -> None:
    response = rate_step(0, vehicle)
    assert 50.0 < time_to(0.63, response) < 110.0
    assert max(response) < 1.2


def offboard_step(mask: int, **fields: float) -> tuple[list[float], list[float]]:
    """Way and speed north every 40 ms for 12 s of a setpoint that is a step from a hover at 10 m."""
    client = Client("sih", load_world("sih"), endpoints=1)

    def send() -> None:
        client.send("SET_POSITION_TARGET_LOCAL_NED", coordinate_frame=1, type_mask=mask, z=-10.0, **fields)

    send()
    client.mode(Mode.OFFBOARD)  # answered after the delay of the link
    way, speed = [], []
    for _ in range(300):
        client.run(0.04, send)
        way.append(client.bridge.truth.p_n[0])
        speed.append(client.bridge.truth.v_n[0])
    return way, speed


def test_a_step_of_five_metres_is_flown_in_five_to_eight_seconds() -> None:
    """Most of it at once, up to 2.7 m/s; then the integral works against the drag until it is there to 25 cm."""
    way, speed = offboard_step(0b110111111000, x=5.0)
    arrived = 0.04 * (1 + max(i for i, x in enumerate(way) if abs(x - 5.0) > 0.25))
    assert 5.0 / 1.15 < arrived < 8.0 * 1.15
    assert max(way) < 5.0 * 1.1
    assert max(speed) < 4.75  # MPC_XY_P times the way
    assert way[-1] == pytest.approx(5.0, abs=0.1)


def test_a_step_of_two_metres_a_second_has_reached_1_6_after_three() -> None:
    _, speed = offboard_step(0b110111000111, vx=2.0)
    assert speed[74] == pytest.approx(1.6, rel=0.05)
    assert speed[-1] == pytest.approx(2.0, rel=0.1)
    assert max(speed) < 2.0
