"""The thrust curve, found in flight: the slopes that it follows from, and what is found."""

from __future__ import annotations

import math
import random

import pytest

from companion.estimation.estimator import Measurement, Prior, initial_estimator_state, update_estimate
from companion.estimation.kalman import Innovation
from companion.estimation.thrust_curve import (
    CURVE_RANGE,
    PROPORTIONAL,
    UNKNOWN,
    ThrustCurve,
    model_factor,
    update_thrust_curve,
)
from companion.frames import rotation_matrix

G = 9.80665
STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("slope", [-0.15, 0.0, 0.18, 0.4])
def test_a_command_and_what_is_made_of_it_are_each_other_s_inverse(slope: float) -> None:
    curve = ThrustCurve(slope, 0.0)
    for command in (2.0, G, 15.0, 20.0):
        assert curve.command_for(curve.made_of(command, G), G) == pytest.approx(command)
    assert curve.made_of(G, G) == G
    d = 1e-6
    assert (curve.made_of(G + d, G) - curve.made_of(G - d, G)) / (2.0 * d) == pytest.approx(1.0 + slope)


@pytest.mark.parametrize("slope", [-0.1, 0.0, 0.2])
def test_the_slope_of_the_thrust_is_that_of_the_curve(slope: float) -> None:
    d = 1e-6
    for command in (5.0, G, 16.0):
        more, less = ThrustCurve(slope + d, 0.0), ThrustCurve(slope - d, 0.0)
        expected = (more.made_of(command, G) - less.made_of(command, G)) / (2.0 * d)
        made = ThrustCurve(slope, 0.0).made_of(command, G)
        assert ThrustCurve(slope, 0.0).by_slope(made, G) == pytest.approx(expected, abs=1e-6)


def test_more_than_a_bent_curve_can_make_is_still_a_command() -> None:
    assert math.isfinite(ThrustCurve(-0.2, 0.0).command_for(5.0 * G, G))


@pytest.mark.parametrize("factor", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("hover", [0.3, 0.5])
def test_a_factor_of_px4_that_is_not_told_is_named(factor: float, hover: float) -> None:
    slope = factor * hover / (1.0 - factor + factor * hover)
    assert model_factor(slope, hover, 0.0) == pytest.approx(factor)
    assert model_factor(0.0, hover, factor) == pytest.approx(factor)


def test_a_factor_of_px4_that_is_told_and_not_there_is_named() -> None:
    """PX4 makes s of u = m s^2 + (1 - m) s, and the rotors thrust of s in proportion."""
    m, hover, d = 0.3, 0.5, 1e-6

    def made(u: float) -> float:
        return (math.sqrt((1.0 - m) ** 2 + 4.0 * m * u) - (1.0 - m)) / (2.0 * m)

    slope = (made(hover + d) - made(hover - d)) / (2.0 * d) * hover / made(hover) - 1.0
    assert slope < -0.1
    assert model_factor(slope, hover, m) == pytest.approx(0.0, abs=1e-6)


def innovation(residual: float, variance: float, slope: float) -> Innovation:
    return Innovation((0.0,) * 5 + (residual,), (1.0,) * 5 + (variance,), (0.0,) * 6, (0.0,) * 5 + (slope,))


def test_what_says_nothing_of_it_leaves_it() -> None:
    assert update_thrust_curve(UNKNOWN, innovation(0.01, 0.02**2, -0.5), 0.01).slope > 0.0
    assert update_thrust_curve(UNKNOWN, innovation(1.0, 0.02**2, -0.5), 0.01).slope == 0.0  # a glitch
    assert update_thrust_curve(UNKNOWN, innovation(0.01, 0.02**2, 0.0), 0.01).slope == 0.0
    assert update_thrust_curve(PROPORTIONAL, innovation(0.01, 0.02**2, -0.5), 0.01) is PROPORTIONAL


def test_it_stays_within_what_rotors_have() -> None:
    known = ThrustCurve(0.0, 100.0)
    assert update_thrust_curve(known, innovation(0.05, 0.02**2, -0.01), 0.01).slope == CURVE_RANGE[1]
    assert update_thrust_curve(known, innovation(-0.05, 0.02**2, -0.01), 0.01).slope == CURVE_RANGE[0]


@pytest.mark.parametrize("true", [0.0, 0.18, 0.3])
@pytest.mark.parametrize("load", [1.0, 1.5])
def test_a_curve_is_found_from_a_height_that_is_held_in_gusts(true: float, load: float) -> None:
    """``load``: of a vehicle that its file takes for lighter, or that flies a steady bend."""
    (found, variance), thrust_scale = held_in_gusts(true, load)
    assert math.sqrt(variance) < 0.035
    assert found == pytest.approx(true, abs=0.04)
    assert thrust_scale == pytest.approx(1.0 / load, rel=0.03)


def test_none_is_believed_that_would_make_the_loop_quicker() -> None:
    assert held_in_gusts(-0.12, 1.0)[0].slope == pytest.approx(0.0, abs=1e-3)


def held_in_gusts(true: float, load: float) -> tuple[ThrustCurve, float]:
    """What is found of a slope, and the thrust scale."""
    rng, dt, p, v, gust = random.Random(7), 0.008, 0.0, 0.0, 0.0
    state = initial_estimator_state(
        STILL, STILL, rotation_matrix((1.0, 0.0, 0.0, 0.0)), G, Prior(), thrust_curve=UNKNOWN
    )
    actual, command = ThrustCurve(true, 0.0), G
    for k in range(5000):
        if k % 5 == 0:
            lift = G + 4.0 * v + 4.0 * p + 1.5 * math.sin(0.02 * k) + rng.gauss(0.0, 0.5)
            command = state.thrust_curve.command_for(lift / state.belief.thrust_scale, G)
        gust += -gust * dt / 0.5 + 0.2 * math.sqrt(2.0 * dt / 0.5) * rng.gauss(0.0, 1.0)
        a = G - actual.made_of(command, G) / load + gust
        p, v = p + dt * v + 0.5 * dt * dt * a, v + dt * a
        mean = state.thrust_curve.made_of(command, G)
        at, fast = (0.0, 0.0, p + rng.gauss(0.0, 0.002)), (0.0, 0.0, v + rng.gauss(0.0, 0.01))
        by_curve = (0.0, 0.0, state.thrust_curve.by_slope(mean, G))
        state = update_estimate(state, Measurement(dt, (0.0, 0.0, mean), at, fast, thrust_by_curve_n=by_curve), G)
    return state.thrust_curve, state.belief.thrust_scale
