"""The model of motors and body: at zero, signs, against the exact solution, and what the observer finds."""

from __future__ import annotations

import math

import pytest

from companion.estimation.body_model import (
    TRIM_MAX,
    Body,
    BodyState,
    TimedWrench,
    correct_body_with_gyro,
    predict_body,
    propagate_body,
)
from companion.estimation.predictor import ForceModel
from companion.frames import Vec3, euler_from_rotation, rotation_matrix

ZERO: Vec3 = (0.0, 0.0, 0.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
BODY = Body(1.0, (0.02, 0.025, 0.04), 0.05)
STILL_AIR = ForceModel(1.0, 0.0, ZERO, 9.81)
HOVER = (9.81, 0.0, 0.0, 0.0)


def commands(*wrench: float, at: float = -math.inf) -> tuple[TimedWrench, ...]:
    a, b, c, d = wrench
    return (TimedWrench(-math.inf, HOVER), TimedWrench(at, (a, b, c, d)))


def test_a_hover_stays() -> None:
    state = BodyState(ZERO, HOVER)
    assert propagate_body(state, BODY, commands(*HOVER), 0.0, 0.1) == (state, 9.81)
    there = predict_body(ZERO, ZERO, UPRIGHT, state, STILL_AIR, BODY, commands(*HOVER), 0.0, 0.1)
    assert there.p_n == pytest.approx(ZERO)
    assert there.v_n == pytest.approx(ZERO)
    assert there.w_b == ZERO


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_torque_turns_about_its_axis_after_the_lag(axis: int) -> None:
    torque = [0.0, 0.0, 0.0]
    torque[axis] = 0.1
    state, _ = propagate_body(BodyState(ZERO, HOVER), BODY, commands(9.81, *torque), 0.0, 0.2)
    # w = (tau / J) (t - lag (1 - e^(-t/lag)))
    exact = 0.1 / BODY.inertia[axis] * (0.2 + 0.05 * math.expm1(-4.0))
    assert state.w_b[axis] == pytest.approx(exact, rel=1e-6)
    assert all(w == 0.0 for i, w in enumerate(state.w_b) if i != axis)


def test_what_is_on_its_way_acts_when_it_arrives() -> None:
    later = commands(9.81, 0.1, 0.0, 0.0, at=0.06)
    before, _ = propagate_body(BodyState(ZERO, HOVER), BODY, later, 0.0, 0.06)
    assert before.w_b == ZERO
    assert propagate_body(before, BODY, later, 0.06, 0.1)[0].w_b[0] > 0.0


def test_the_prediction_is_the_motion() -> None:
    """In steps of 12 ms as in steps of 0.5 ms, with thrust scale, drag, wind and a body that tumbles gently."""
    forces = ForceModel(0.9, 0.5, (0.3, -0.2, 0.1), 9.81)
    state = BodyState((1.0, -0.5, 0.4), (12.0, 0.05, -0.02, 0.01), (0.5, 0.0, -0.2))
    sent = commands(8.0, -0.05, 0.03, 0.0, at=0.024)
    coarse = predict_body((1.0, 2.0, -3.0), (2.0, 1.0, 0.5), UPRIGHT, state, forces, BODY, sent, 0.0, 0.12)
    fine, p_n, v_n, q_nb = state, (1.0, 2.0, -3.0), (2.0, 1.0, 0.5), UPRIGHT
    for k in range(240):
        p_n, v_n, q_nb, _ = predict_body(p_n, v_n, q_nb, fine, forces, BODY, sent, k * 5e-4, 5e-4)
        fine, _ = propagate_body(fine, BODY, sent, k * 5e-4, (k + 1) * 5e-4)
    assert math.dist(coarse.p_n, p_n) < 1e-3
    assert math.dist(coarse.v_n, v_n) < 5e-3
    assert math.dist(coarse.w_b, fine.w_b) < 1e-3
    angles = (euler_from_rotation(rotation_matrix(q)) for q in (coarse.q_nb, q_nb))
    assert math.dist(*angles) < 1e-3


def test_a_body_that_turns_by_itself_is_found_and_bounded() -> None:
    """A weak motor: 4 rad/s^2 that no command explains, in a gyro without noise, at 125 Hz."""
    state, w, dt = BodyState(ZERO, HOVER), 0.0, 0.008
    for _ in range(125):
        state, _ = propagate_body(state, BODY, commands(*HOVER), 0.0, dt)
        w += 4.0 * dt
        state = correct_body_with_gyro(state, (w, 0.0, 0.0), dt)
    assert state.trim == pytest.approx((4.0, 0.0, 0.0), abs=0.1)
    assert state.w_b[0] == pytest.approx(w, abs=0.02)
    for _ in range(500):
        state = correct_body_with_gyro(state, (state.w_b[0] + 5.0, 0.0, 0.0), dt)
    assert state.trim[0] == TRIM_MAX
