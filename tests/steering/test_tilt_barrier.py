"""The barrier before the failure detector: what leans on is stopped short of it, everything else is left alone."""

from __future__ import annotations

import dataclasses
import math
import random

import pytest

from companion.config.vehicle import load_vehicle
from companion.daemon.conductor import Conductor
from companion.frames import Matrix3, from_rotation_vector, multiply, rotation_matrix, tilt, turned
from companion.steering.tilt_barrier import BARRIER_RATE, BARRIER_UNDER_DETECTOR, within_barrier
from sim_bridge.plant import Truth
from trials.measured import course, machine, measure_flight, steady_wind, world

LIMITS = load_vehicle("x500").limits
assert LIMITS is not None
STEEPEST = LIMITS.failure_detector - BARRIER_UNDER_DETECTOR
UPRIGHT: Matrix3 = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def leaning(angle: float, towards: float, nose: float = 0.0) -> Matrix3:
    """An attitude ``angle`` rad steep, about the body axis ``towards`` rad from the nose."""
    lean = from_rotation_vector((angle * math.cos(towards), angle * math.sin(towards), 0.0))
    return rotation_matrix(multiply(from_rotation_vector((0.0, 0.0, nose)), lean))


def test_rates_far_from_it_are_as_asked_for() -> None:
    assert within_barrier(1.0, -2.0, UPRIGHT, LIMITS) == (1.0, -2.0)
    assert within_barrier(1.0, -2.0, leaning(0.3, 0.7), LIMITS) == (1.0, -2.0)


def test_a_vehicle_without_limits_has_none() -> None:
    assert within_barrier(9.0, 9.0, leaning(1.2, 0.7), None) == (9.0, 9.0)


@pytest.mark.parametrize("towards", [0.0, 0.5 * math.pi, 2.0, -2.0])
def test_only_what_leans_it_further_is_taken_out(towards: float) -> None:
    steep = leaning(STEEPEST - 0.05, towards, nose=1.0)
    along, across = (math.cos(towards), math.sin(towards)), (-math.sin(towards), math.cos(towards))
    p, q = within_barrier(2.0 * along[0] + across[0], 2.0 * along[1] + across[1], steep, LIMITS)
    assert p * along[0] + q * along[1] == pytest.approx(BARRIER_RATE * 0.05, rel=0.01)
    assert p * across[0] + q * across[1] == pytest.approx(1.0, rel=1e-6)
    assert within_barrier(-2.0 * along[0], -2.0 * along[1], steep, LIMITS) == (-2.0 * along[0], -2.0 * along[1])


def test_beyond_it_the_vehicle_is_brought_back() -> None:
    p, q = within_barrier(0.0, 0.0, leaning(STEEPEST + 0.1, 0.0), LIMITS)
    assert p == pytest.approx(-0.1 * BARRIER_RATE, rel=0.01)
    assert q == pytest.approx(0.0, abs=1e-6)


def test_whatever_is_asked_for_it_is_never_passed() -> None:
    rng = random.Random(1)
    r, dt = UPRIGHT, 0.002
    for step in range(20_000):
        if step % 50 == 0:
            asked = rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0)
        r = turned(r, (*within_barrier(*asked, r, LIMITS), rng.uniform(-2.0, 2.0)), dt)
        assert tilt(r) < STEEPEST + 0.002


def test_a_path_at_the_steepest_tilt_in_wind_and_noise_is_flown_under_the_detector() -> None:
    """Handed back at 58 deg after 98 s without it."""
    sih = machine("sih")
    assert sih.limits is not None
    told = dataclasses.replace(sih, limits=dataclasses.replace(sih.limits, tilt=math.radians(60.0)))
    steepest = 0.0

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        nonlocal steepest
        state = conductor.memory.state if conductor.memory else None
        steepest = max(steepest, 0.0 if state is None else state.tilt)

    windy = world("sih_noisy", wind_n=steady_wind(3.0, 14))
    flight = measure_flight(course("circle_r5", 7.0), told, windy, seed=14, duration=100.0, watch=watch)
    assert flight.reason is None
    assert math.degrees(steepest) < 58.0
