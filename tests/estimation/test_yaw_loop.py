"""The yaw loop found in flight: strong and weak ones, beside an offset and a gyro that shakes; and used."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from companion.estimation.rate_loop_model import (
    YAW_INTEGRAL_RATE,
    YAW_LAG,
    YAW_OBSERVER_POLE,
    YAW_TORQUE_LAG,
    RateLoopState,
    TimedCommand,
    alike,
    propagate,
    propagate_yaw,
    yaw_observer,
)
from companion.estimation.yaw_loop_identification import (
    LAG_RATIO_RANGE,
    YawLoopEstimate,
    initial_yaw_loop_estimate,
    update_yaw_loop_estimate,
)
from companion.steering.yaw import USUAL_THRUST_PER_RATE, thrust_per_rate, usual_yaw_lag, yaw_integral, yaw_loop
from companion.vehicle import Tuning

STILL = (0.0, 0.0, 0.0)


def found(
    true: float, swing: float, seconds: float = 12.0, torque_lag: float = 0.12, damping: float = 0.0
) -> YawLoopEstimate:
    """What is known after so long of turning to and fro by ``swing`` rad/s, as round a figure-eight; the loop has PX4's
    integral, and the body's turning is damped by ``damping`` (1/s)."""
    rng = random.Random(2)
    r, turned, integral, known = 0.0, 0.0, 0.2, initial_yaw_loop_estimate(0.0)
    commands: tuple[TimedCommand, ...] = (TimedCommand(0.0, STILL, 9.8),)
    for k in range(int(seconds / 0.008)):
        t = 0.008 * k
        wanted = swing * (math.sin(1.9 * t) + 0.6 * math.sin(4.1 * t + 1.0))
        commands = (*commands[-20:], TimedCommand(t, (0.0, 0.0, wanted), 9.8))
        for _ in range(4):
            integral += 0.002 * YAW_INTEGRAL_RATE * (wanted - r)
            turned += 0.002 * ((wanted - r + integral) / true - turned) / torque_lag
            r += 0.002 * (turned - damping * r)
        known = update_yaw_loop_estimate(known, commands, t + 0.008, r + rng.gauss(0.0, 0.03))
    return known


@pytest.mark.parametrize("true", [0.22, 0.33, 0.43, 0.7])
@pytest.mark.parametrize("torque_lag", [0.09, 0.15])
def test_a_strong_and_a_weak_yaw_are_found_and_the_lag_of_its_torque(true: float, torque_lag: float) -> None:
    known = found(true, 0.8, torque_lag=torque_lag)
    assert known.lag == pytest.approx(true, rel=0.1)
    assert known.torque_lag == pytest.approx(torque_lag, abs=0.02)


@pytest.mark.parametrize("damping", [0.0, 0.8, 1.5])
def test_the_damping_of_the_turning_is_found_and_the_lags_beside_it(damping: float) -> None:
    """The torque is late and the damping is not: what the model, linear in its unknowns, has of each is 1 + theta
    damping times less."""
    known, late = found(0.4, 0.8, 30.0, damping=damping), 1.0 + 0.12 * damping
    assert known.damping == pytest.approx(damping / late, abs=0.15)
    assert known.lag == pytest.approx(0.4 * late, rel=0.1)
    assert known.torque_lag == pytest.approx(0.12 / late, abs=0.02)


def test_a_nose_that_stays_teaches_nothing() -> None:
    known = found(0.25, 0.0)
    assert known.lag == pytest.approx(YAW_LAG, rel=0.01)
    assert known.torque_lag == pytest.approx(YAW_TORQUE_LAG)


def test_none_is_sought_that_no_vehicle_has() -> None:
    assert found(2.0, 0.8, seconds=25.0).lag == pytest.approx(LAG_RATIO_RANGE[1] * YAW_LAG, rel=0.02)


def test_a_gap_begins_anew_and_keeps_what_was_found() -> None:
    known = found(0.25, 0.8)
    later = update_yaw_loop_estimate(known, (TimedCommand(0.0, STILL, 9.8),), known.at + 1.0, 0.3)
    assert (later.unknowns, later.ran, later.rate) == (known.unknowns, 0.0, (0.3, 0.3, 0.3))
    assert update_yaw_loop_estimate(later, (TimedCommand(0.0, STILL, 9.8),), later.at, 0.3) is later


@pytest.mark.parametrize("lag", [0.2, 0.43, 0.8])
@pytest.mark.parametrize("gain", [1.0, 0.7])
def test_the_observers_poles_are_where_they_are_meant_to_be(lag: float, gain: float) -> None:
    """The errors of yaw rate, its derivative and the trim: the eigenvalues of what they do to each other."""
    l1, l2, l3 = yaw_observer(lag, YAW_TORQUE_LAG, gain, 0.5)
    per_trim = 1.0 / (lag * YAW_TORQUE_LAG)
    errors = [
        [-l1, 1.0, 0.0],
        [-per_trim / gain - l2, -1.0 / YAW_TORQUE_LAG, per_trim],
        [-0.5 - l3, 0.0, 0.0],
    ]
    assert np.poly(errors) == pytest.approx(np.poly([-YAW_OBSERVER_POLE] * 3))


def test_yaw_alone_is_predicted_as_the_whole() -> None:
    state = RateLoopState((0.1, 0.2, 0.3), (0.0, 0.0, 1.0), 9.8, yaw_trim=0.2)
    commands = (TimedCommand(0.0, (0.0, 0.0, 0.5), 9.8), TimedCommand(0.03, (0.0, 0.0, -0.5), 9.8))
    loop = alike(0.07, 0.05, 0.3)._replace(yaw_damping=0.8)
    whole, _ = propagate(state, loop, commands, 0.0, 0.1)
    assert propagate_yaw(state, loop, commands, 0.0, 0.1) == pytest.approx((whole.w_b[2], whole.w_dot_b[2]))
    assert propagate_yaw(state, loop, commands, 0.0, 0.0) == (0.3, 1.0)


def test_a_weak_yaw_is_led_further_and_its_gain_says_what_the_motors_have_for_it() -> None:
    weak, usual, strong = (yaw_loop(alike(0.07, 0.05, lag), 0.07, 0.0) for lag in (0.7, YAW_LAG, 0.22))
    assert weak.lag > usual.lag > strong.lag > 0.0
    assert usual_yaw_lag(0.06) == pytest.approx(YAW_LAG) and usual_yaw_lag(0.0) < 0.05
    assert thrust_per_rate(Tuning()) == USUAL_THRUST_PER_RATE
    told = thrust_per_rate(Tuning(roll_rate_p=0.3, yaw_rate_p=0.1, yaw_rate_k=3.0))
    assert told.yaw == pytest.approx(0.3) and told.tilt == pytest.approx(2.0 * USUAL_THRUST_PER_RATE.tilt)
    assert thrust_per_rate(Tuning(yaw_rate_p=1e-9)).yaw > 0.0
    assert yaw_integral(Tuning()) == YAW_INTEGRAL_RATE == yaw_integral(Tuning(yaw_rate_p=0.0, yaw_rate_i=0.1))
    assert yaw_integral(Tuning(yaw_rate_p=0.2, yaw_rate_i=0.3, yaw_rate_k=2.0)) == pytest.approx(1.5)
    assert yaw_integral(Tuning(yaw_rate_p=0.2, yaw_rate_i=0.0)) == 0.0


def test_a_damped_yaw_ends_where_its_gain_says_and_its_integral_brings_it_to_the_command() -> None:
    loop = alike(0.07, 0.05, 0.4)._replace(yaw_damping=0.8)
    commands = (TimedCommand(0.0, (0.0, 0.0, 1.0), 9.8),)
    state, rates = RateLoopState(STILL, STILL, 9.8), []
    for k in range(1200):
        state, _ = propagate(state, loop, commands, 0.01 * k, 0.01 * (k + 1))
        rates.append(state.w_b[2])
    assert loop.yaw_gain < rates[100] < 0.95
    assert rates[-1] == pytest.approx(1.0, abs=0.02)
    assert state.yaw_trim == pytest.approx(1.0 / loop.yaw_gain - 1.0, rel=0.05)
