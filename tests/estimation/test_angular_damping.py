"""The damping of the turning: nothing where nothing turns, its sign, its size beside a trim, and none made of noise."""

from __future__ import annotations

import math
import random

import pytest

from companion.estimation.angular_damping import DAMPING_MAX, NO_TURNING, damping_of, update_regressions
from companion.estimation.body_model import (
    TURN_OBSERVER_POLE,
    Body,
    BodyState,
    TimedWrench,
    correct_body_with_gyro,
    propagate_body,
)
from companion.frames import Vec3

ZERO: Vec3 = (0.0, 0.0, 0.0)
HOVER = (9.81, 0.0, 0.0, 0.0)
BODY = Body(1.0, (0.02, 0.025, 0.04), 0.05)
DT = 0.008


def found(damping: float, trim: float, rate: float, gyro: float = 0.0) -> tuple[Vec3, BodyState]:
    """What an observer that starts from nothing makes of 20 s of swinging at ``rate`` rad/s, a lap in 4.5 s, about the
    roll axis. ``gyro``: rad/s, its noise."""
    shake = random.Random(3)
    regressions, known, pace = NO_TURNING, BodyState(ZERO, HOVER), 1.4
    for k in range(round(20.0 / DT)):
        t = k * DT
        w = rate * math.sin(pace * t)
        torque = BODY.inertia[0] * (pace * rate * math.cos(pace * (t + 0.5 * DT)) - trim + damping * w)
        known = known._replace(acting=(9.81, torque, 0.0, 0.0))
        known, _ = propagate_body(known, BODY, (TimedWrench(-math.inf, known.acting),), 0.0, DT)
        w_b = (rate * math.sin(pace * (t + DT)) + shake.gauss(0.0, gyro), shake.gauss(0.0, gyro), 0.0)
        known = correct_body_with_gyro(known, w_b, DT)
        regressions = update_regressions(regressions, known.w_b, known.trim, known.damping, TURN_OBSERVER_POLE, DT)
        known = known._replace(damping=damping_of(regressions))
    return known.damping, known


def test_what_does_not_turn_has_none() -> None:
    assert found(0.0, 0.0, 0.0)[0] == ZERO


@pytest.mark.parametrize(("damping", "trim", "rate"), [(1.0, 0.0, 1.0), (1.0, 2.0, 0.3), (4.0, -1.0, 1.0)])
def test_it_is_found_beside_a_trim_and_leaves_the_trim_alone(damping: float, trim: float, rate: float) -> None:
    (roll, pitch, yaw), state = found(damping, trim, rate)
    assert roll == pytest.approx(damping, rel=0.1)
    assert (pitch, yaw) == (0.0, 0.0)
    assert state.trim[0] == pytest.approx(trim, abs=0.1)


def test_a_gyro_that_shakes_hides_it_a_little_and_makes_none() -> None:
    (roll, pitch, _), _ = found(1.0, 0.5, 0.3, gyro=0.09)
    assert roll == pytest.approx(1.0, abs=0.2)
    assert pitch < 0.1


def test_a_body_that_is_driven_by_its_turning_has_none_and_the_most_is_bounded() -> None:
    assert found(-2.0, 0.0, 1.0)[0][0] == 0.0
    assert found(10.0, 0.0, 1.0)[0][0] == DAMPING_MAX
