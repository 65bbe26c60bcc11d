"""The motors' lag, found in flight: the slopes that it follows from, and what is found."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from companion.estimation.estimator import Measurement, Prior, initial_estimator_state, update_estimate
from companion.estimation.kalman import Innovation
from companion.estimation.motor_lag import (
    MOTOR_LAG_RANGE,
    TOLD,
    MotorLag,
    propagate_by_lag,
    told_motor_lag,
    update_motor_lag,
)
from companion.estimation.rate_loop_model import RateLoopState, TimedCommand, alike, propagate
from companion.frames import rotation_matrix

G = 9.80665
STILL = (0.0, 0.0, 0.0)


def test_the_slope_of_the_thrust_is_that_of_the_model() -> None:
    rng = random.Random(1)
    commands = tuple(TimedCommand(0.02 * k, STILL, rng.uniform(5.0, 15.0)) for k in range(20))

    def thrusts(lag: float) -> list[float]:
        state, found = RateLoopState(STILL, STILL, 9.0), []
        for k in range(25):
            state, mean = propagate(state, alike(0.07, lag), commands, 0.016 * k, 0.016 * (k + 1))
            found += [state.specific_thrust, mean]
        return found

    told, by_lag, slopes, lag, d = 9.0, 0.0, [], 0.04, 1e-5
    for k in range(25):
        begin, end = 0.016 * k, 0.016 * (k + 1)
        by_lag, mean = propagate_by_lag(by_lag, told, lag, commands, begin, end)
        told = propagate(RateLoopState(STILL, STILL, told), alike(0.07, lag), commands, begin, end)[0].specific_thrust
        slopes += [by_lag, mean]
    difference = (np.array(thrusts(lag + d)) - np.array(thrusts(lag - d))) / (2.0 * d)
    assert slopes == pytest.approx(difference, rel=1e-4, abs=1e-3)


def test_motors_that_have_none_count_as_quick() -> None:
    commands = (TimedCommand(0.0, STILL, 12.0),)
    by_lag, mean = propagate_by_lag(0.0, 9.0, 0.0, commands, 0.0, 0.008)
    assert math.isfinite(by_lag) and math.isfinite(mean)


def innovation(residual: float, variance: float, slope: float) -> Innovation:
    return Innovation((0.0,) * 5 + (residual,), (1.0,) * 5 + (variance,), (0.0,) * 5 + (slope,))


def test_a_velocity_that_comes_later_than_expected_is_a_longer_lag() -> None:
    known = told_motor_lag(0.05)
    later = update_motor_lag(known, innovation(0.01, 0.02**2, -0.5), 0.01)
    assert later.lag > known.lag and later.variance < known.variance
    assert update_motor_lag(known, innovation(-0.01, 0.02**2, -0.5), 0.01).lag < known.lag


def test_what_says_nothing_of_it_leaves_it() -> None:
    known = told_motor_lag(0.05)
    assert update_motor_lag(known, innovation(1.0, 0.02**2, -0.5), 0.01).lag == known.lag  # a glitch
    assert update_motor_lag(known, innovation(0.01, 0.02**2, 0.0), 0.01).lag == known.lag  # a hover
    assert update_motor_lag(TOLD, innovation(0.01, 0.02**2, -0.5), 0.01) is TOLD


def test_it_stays_within_what_motors_have() -> None:
    known = MotorLag(0.05, 1.0)
    assert update_motor_lag(known, innovation(0.05, 0.02**2, -0.1), 0.01).lag == MOTOR_LAG_RANGE[1]
    assert update_motor_lag(known, innovation(-0.05, 0.02**2, -0.1), 0.01).lag == MOTOR_LAG_RANGE[0]


@pytest.mark.parametrize(("told", "true"), [(0.025, 0.06), (0.05, 0.05), (0.06, 0.02)])
def test_a_lag_is_found_from_a_height_that_is_held_in_gusts(told: float, true: float) -> None:
    rng, dt, p, v, gust, made, sent = random.Random(7), 0.008, 0.0, 0.0, 0.0, G, G
    state = initial_estimator_state(
        STILL, STILL, rotation_matrix((1.0, 0.0, 0.0, 0.0)), G, Prior(), motor_lag=told_motor_lag(told)
    )
    thrust, by_lag = G, 0.0
    for k in range(2500):
        if k % 5 == 0:
            sent = G + 4.0 * v + 4.0 * p + math.sin(0.1 * k) + rng.gauss(0.0, 0.5)
        gust += -gust * dt / 0.5 + 0.3 * math.sqrt(2.0 * dt / 0.5) * rng.gauss(0.0, 1.0)
        was, made = made, made + (sent - made) * (1.0 - math.exp(-dt / true))
        a = G - 0.5 * (was + made) + gust
        p, v = p + dt * v + 0.5 * dt * dt * a, v + dt * a
        lag, commands = state.motor_lag.lag, (TimedCommand(0.0, STILL, sent),)
        by_lag, mean_by_lag = propagate_by_lag(by_lag, thrust, lag, commands, 0.0, dt)
        after, mean = propagate(RateLoopState(STILL, STILL, thrust), alike(0.07, lag), commands, 0.0, dt)
        thrust = after.specific_thrust
        at, fast = (0.0, 0.0, p + rng.gauss(0.0, 0.002)), (0.0, 0.0, v + rng.gauss(0.0, 0.01))
        measurement = Measurement(dt, (0.0, 0.0, mean), at, fast, thrust_by_lag_n=(0.0, 0.0, mean_by_lag))
        state = update_estimate(state, measurement, G)
    found, variance = state.motor_lag
    assert found == pytest.approx(true, abs=0.006)
    assert math.sqrt(variance) < 0.004
