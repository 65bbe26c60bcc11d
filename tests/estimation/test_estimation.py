"""What is found out on the way: the inner loops' model, the prediction, the filter, and what keeps it honest."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from companion.estimation.body_model import Body, TimedWrench
from companion.estimation.estimator import (
    EstimatorState,
    Measurement,
    Prior,
    initial_estimator_state,
    innovation_is_small,
    predict_measurement,
    update_estimate,
)
from companion.estimation.kalman import Belief, initial_belief, predict_and_update, reset_position_velocity
from companion.estimation.kalman_step import AXES, DRAG, PER_AXIS, SIZE, THRUST_SCALE
from companion.estimation.motor_estimate import advance_motor_estimate, begin_motor_estimate, learn_motor_estimate
from companion.estimation.noise_levels import NoiseLevels
from companion.estimation.predictor import ForceModel, predict
from companion.estimation.rate_loop_identification import initial_rate_loop_estimate, update_rate_loop_estimate
from companion.estimation.rate_loop_model import (
    RateLoop,
    RateLoopState,
    TimedCommand,
    active_command,
    alike,
    axis_transition,
    correct_with_gyro,
    propagate,
)
from companion.frames import Vec3, from_rotation_vector, multiply, quaternion_from_euler, rotation_matrix
from companion.vehicle import VehicleState
from trials.prediction import measurement
from trials.prediction import predict as predict_in_matrices

G = 9.80665
STILL: Vec3 = (0.0, 0.0, 0.0)
SIH = alike(0.071, 0.05)


@pytest.mark.parametrize(("lag", "motor_lag"), [(0.071, 0.05), (0.06, 0.0125), (0.06, 0.015), (0.3, 0.01)])
def test_an_axis_follows_its_equation_exactly(lag: float, motor_lag: float) -> None:
    """Under, critically and over-damped, against a fine integration."""
    step = axis_transition(lag, motor_lag, 0.02)
    y, yd, angle, h = 0.7, -2.0, 0.0, 1e-6
    for _ in range(20000):
        mid = yd + 0.5 * h * (-y / (lag * motor_lag) - yd / motor_lag)
        angle += h * y
        yd += h * (-(y + 0.5 * h * yd) / (lag * motor_lag) - mid / motor_lag)
        y += h * mid
    assert 0.7 * step.yy - 2.0 * step.yd == pytest.approx(y, abs=1e-5)
    assert 0.7 * step.dy - 2.0 * step.dd == pytest.approx(yd, abs=1e-3)
    assert 0.7 * step.ay - 2.0 * step.ad == pytest.approx(angle, abs=1e-5)


def test_the_response_is_the_one_measured_on_px4() -> None:
    """A step of the roll rate: 50 % after 76 ms, 63 % after 92, 90 % after 136, 7 to 8 % overshoot."""
    rate_loop_state, commands = RateLoopState(STILL, STILL, G), (TimedCommand(0.0, (1.0, 0.0, 0.0), G),)
    reached: dict[float, float] = {}
    most = 0.0
    for k in range(1, 200):
        rate_loop_state, _ = propagate(rate_loop_state, SIH, commands, (k - 1) * 0.004, k * 0.004)
        for share in (0.5, 0.63, 0.9):
            if rate_loop_state.w_b[0] >= share:
                reached.setdefault(share, k * 0.004)
        most = max(most, rate_loop_state.w_b[0])
    assert reached[0.5] == pytest.approx(0.076, abs=0.010)
    assert reached[0.63] == pytest.approx(0.092, abs=0.010)
    assert reached[0.9] == pytest.approx(0.136, abs=0.010)
    assert most == pytest.approx(1.08, abs=0.03)


def test_commands_take_over_one_after_another() -> None:
    commands = tuple(TimedCommand(t, (t, 0.0, 0.0), G) for t in (1.0, 2.0, 3.0))
    assert [active_command(commands, t).at for t in (0.5, 1.0, 2.5, 9.0)] == [1.0, 1.0, 2.0, 3.0]


def test_lift_follows_the_motors_lag() -> None:
    rate_loop_state, mean = propagate(
        RateLoopState(STILL, STILL, 0.0), SIH, (TimedCommand(0.0, STILL, 10.0),), 0.0, 0.05
    )
    assert rate_loop_state.specific_thrust == pytest.approx(10.0 * (1.0 - math.exp(-1.0)))
    assert mean == pytest.approx(10.0 * math.exp(-1.0))


def test_the_gyro_corrects_the_model_without_swinging() -> None:
    for dt in (0.004, 0.01, 0.02, 0.1):
        rate_loop_state, commands = RateLoopState((1.0, -1.0, 0.5), (20.0, 0.0, 0.0), G), (TimedCommand(0.0, STILL, G),)
        for k in range(500):
            rate_loop_state, _ = propagate(rate_loop_state, SIH, commands, k * dt, (k + 1) * dt)
            rate_loop_state = correct_with_gyro(rate_loop_state, STILL, dt, SIH)
            assert max(map(abs, rate_loop_state.w_b)) < 1.5
        assert max(map(abs, rate_loop_state.w_b)) < 1e-3


def test_a_yaw_loop_that_falls_short_is_trimmed() -> None:
    """A vehicle without an integral that turns at 80 % of what is asked: the trim is the missing fifth."""
    loop = SIH._replace(yaw_integral=0.0)
    rate_loop_state, commands = RateLoopState(STILL, STILL, G), (TimedCommand(0.0, (0.0, 0.0, 1.0), G),)
    for k in range(300):
        rate_loop_state, _ = propagate(rate_loop_state, loop, commands, k * 0.01, (k + 1) * 0.01)
        rate_loop_state = correct_with_gyro(rate_loop_state, (0.0, 0.0, 0.8), 0.01, loop)
    assert rate_loop_state.yaw_trim == pytest.approx(-0.2, abs=1e-3)
    assert rate_loop_state.w_b[2] == pytest.approx(0.8, abs=1e-3)


def test_prediction_is_the_motion_it_predicts() -> None:
    """Against a fine integration of the same equations, commands changing on the way, drag and wind included."""
    known = ForceModel(1.1, 0.8, (0.5, -1.0, 0.2), G)
    commands = (
        TimedCommand(0.0, (1.0, -0.5, 0.3), 11.0),
        TimedCommand(0.036, (-1.0, 0.8, 0.0), 9.0),
        TimedCommand(0.072, (2.0, 0.0, -0.4), 12.0),
    )
    p_n, v_n, q_nb = (1.0, 2.0, -3.0), (4.0, -2.0, 1.0), quaternion_from_euler(0.5, 0.2, -0.3)
    rate_loop_state = RateLoopState((0.4, 0.1, -0.2), (3.0, -2.0, 0.0), 10.0)
    there = predict(p_n, v_n, q_nb, rate_loop_state, known, SIH, commands, 0.0, 0.12)
    p, v, q, h = np.array(p_n), np.array(v_n), q_nb, 0.0002
    for k in range(600):
        rate_loop_state, specific_thrust = propagate(rate_loop_state, SIH, commands, k * h, (k + 1) * h)
        w = rate_loop_state.w_b
        q = multiply(q, from_rotation_vector((w[0] * h, w[1] * h, w[2] * h)))
        b = np.array(rotation_matrix(q)[2::3])
        a = np.array((0.5, -1.0, 0.2 + G)) - 1.1 * specific_thrust * b - 0.8 * v
        p, v = p + h * v + 0.5 * h * h * a, v + h * a
    assert there.p_n == pytest.approx(tuple(p), abs=5e-4)
    assert there.v_n == pytest.approx(tuple(v), abs=6e-3)
    assert there.w_b == pytest.approx(rate_loop_state.w_b, abs=0.05)
    assert abs(np.dot(there.q_nb, q)) == pytest.approx(1.0, abs=1e-5)


def dense(belief: Belief) -> np.ndarray:
    return np.array(belief.covariance())


LEVELS = NoiseLevels(
    1e-6, 1e-4, (0.01, 0.02, 0.03), (0.04, 0.05, 0.06), (0.09, 0.1, 0.04), (0.002, 0.003, 0.004), 0.05**2, 0.03**2
)


def usual_kalman(belief: Belief, dt: float, F: Vec3, z: np.ndarray, noise: NoiseLevels, learn: bool):  # type: ignore[no-untyped-def]
    """The textbook's filter in matrices, in Joseph's form: all six measurements at once; while kappa and c are frozen
    one by one, each for its own axis alone."""
    new, P = predict_in_matrices(np.array(belief.x), dense(belief), dt, F, G, noise, learn)
    H, R = measurement(noise)
    axes_apart(P)
    if learn:
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        return new + K @ (z - H @ new), joseph(P, K, H, R)
    for row in range(6):
        own, seen = slice(PER_AXIS * (row % AXES), PER_AXIS * (row % AXES + 1)), H[[row]]
        K = np.zeros((SIZE, 1))
        K[own] = (P @ seen.T / (seen @ P @ seen.T + R[row, row]))[own]
        new, P = new + K @ (z[[row]] - seen @ new), joseph(P, K, seen, R[row : row + 1, row : row + 1])
    return new, P


def joseph(P: np.ndarray, K: np.ndarray, H: np.ndarray, R: np.ndarray) -> np.ndarray:
    I_KH = np.eye(SIZE) - K @ H
    return I_KH @ P @ I_KH.T + K @ R @ K.T


def axes_apart(P: np.ndarray) -> None:
    """Let the axes have nothing in common but what they have with k and c."""
    common = P[:THRUST_SCALE, THRUST_SCALE:] @ np.linalg.solve(
        P[THRUST_SCALE:, THRUST_SCALE:], P[THRUST_SCALE:, :THRUST_SCALE]
    )
    for i in range(AXES):
        for j in range(AXES):
            if i != j:
                block = np.ix_(range(PER_AXIS * i, PER_AXIS * (i + 1)), range(PER_AXIS * j, PER_AXIS * (j + 1)))
                P[block] = common[block]


def fresh(p_n: Vec3 = STILL, v_n: Vec3 = STILL) -> Belief:
    return initial_belief(p_n, v_n, (0.1, 0.0, 0.0), (1.0, 0.2), (0.3, 0.5), LEVELS)


def test_the_filter_is_the_textbooks() -> None:
    rng = random.Random(1)
    belief = fresh((1.0, 2.0, -3.0), (0.5, 0.0, 0.0))
    for _ in range(60):
        F = (rng.gauss(0, 2), rng.gauss(0, 2), rng.gauss(9, 1))
        z = np.array([*(p + rng.gauss(0, 0.01) for p in belief.p_n), *(v + rng.gauss(0, 0.02) for v in belief.v_n)])
        noise = LEVELS._replace(position=rng.uniform(1e-6, 1e-4), velocity=rng.uniform(1e-5, 1e-3))
        x, P = usual_kalman(belief, 0.01, F, z, noise, True)
        belief, innovation = predict_and_update(belief, 0.01, F, G, tuple(z[:3]), tuple(z[3:]), noise, True)
        assert belief.x == pytest.approx(x, abs=1e-9)
        assert np.allclose(dense(belief), P, rtol=1e-7, atol=1e-12)
        assert np.linalg.eigvalsh(dense(belief)).min() > 0.0
        assert len(innovation.residual) == len(innovation.variance) == 6


def test_frozen_rows_stay_and_the_rest_is_as_with_zero_gains() -> None:
    belief = fresh(STILL, (2.0, 1.0, 0.0))
    for k in range(30):
        belief, _ = predict_and_update(belief, 0.01, (0.1 * k, 0.0, 9.0), G, STILL, (2.0, 1.0, 0.0), LEVELS, True)
    F, z = (1.0, 0.0, 9.0), np.array([0.1, 0.0, 0.0, 2.5, 1.0, 0.0])
    frozen, _ = predict_and_update(belief, 0.01, F, G, tuple(z[:3]), tuple(z[3:]), LEVELS, False)
    x, P = usual_kalman(belief, 0.01, F, z, LEVELS, False)
    assert frozen.x == pytest.approx(x, abs=1e-9)
    assert np.allclose(dense(frozen), P, rtol=1e-7, atol=1e-12)
    assert frozen.x[THRUST_SCALE:] == belief.x[THRUST_SCALE:]
    for i in (THRUST_SCALE, DRAG):
        for j in (THRUST_SCALE, DRAG):
            assert dense(frozen)[i, j] == dense(belief)[i, j]
    assert frozen.v_n[0] > belief.v_n[0]
    assert np.linalg.eigvalsh(dense(frozen)).min() > 0.0


def fly(
    known: EstimatorState,
    seconds: float,
    thrust_scale: float,
    drag: float,
    wind: Vec3 = STILL,
    held: bool = False,
    dt: float = 0.01,
) -> EstimatorState:
    """A machine that swings about in the air, its lift as asked for times kappa."""
    p, v = np.array(known.belief.p_n), np.array(known.belief.v_n)
    for k in range(round(seconds / dt)):
        t = k * dt
        F = np.array([2.5 * math.sin(1.3 * t), 2.5 * math.cos(1.1 * t), 9.8 / thrust_scale + 0.8 * math.sin(2.0 * t)])
        a = np.array([0.0, 0.0, G]) - thrust_scale * F - drag * (v - np.array(wind))
        if held:
            v[:] = 0.0
        else:
            p, v = p + dt * v + 0.5 * dt * dt * a, v + dt * a
        known = update_estimate(known, Measurement(dt, tuple(F), tuple(p), tuple(v), moving=True), G)
    return known


def level_start() -> EstimatorState:
    return initial_estimator_state((0.0, 0.0, -10.0), STILL, rotation_matrix((1.0, 0.0, 0.0, 0.0)), G, Prior())


@pytest.mark.parametrize("thrust_scale", [0.7, 1.0, 1.4])
def test_thrust_scale_and_drag_are_found(thrust_scale: float) -> None:
    known = fly(level_start(), 6.0, thrust_scale, 0.9)
    assert known.belief.thrust_scale == pytest.approx(thrust_scale, rel=0.01)
    assert known.belief.drag == pytest.approx(0.9, abs=0.05)
    assert known.converged


def test_a_thrust_scale_converges_within_a_second_of_flight() -> None:
    known = level_start()
    assert not known.converged
    known = fly(known, 1.0, 1.3, 0.3)
    assert known.converged
    assert known.belief.thrust_scale == pytest.approx(1.3, rel=0.03)


def test_wind_ends_up_in_the_disturbance_and_not_in_the_drag() -> None:
    known = fly(level_start(), 10.0, 1.0, 0.5, wind=(4.0, -2.0, 0.0))
    assert known.belief.drag == pytest.approx(0.5, abs=0.05)
    assert known.belief.disturbance_n[:2] == pytest.approx((2.0, -1.0), abs=0.25)


def test_a_lean_in_hover_is_taken_for_the_winds() -> None:
    leaning = rotation_matrix(quaternion_from_euler(0.0, -0.2, 0.0))  # nose down into a wind from the north
    known = initial_estimator_state(STILL, STILL, leaning, G, Prior())
    assert known.belief.disturbance_n[0] == pytest.approx(-G * math.tan(0.2), rel=1e-6)
    assert initial_estimator_state(STILL, (5.0, 0.0, 0.0), leaning, G, Prior()).belief.disturbance_n == STILL


def test_a_held_vehicle_teaches_nothing() -> None:
    known = fly(level_start(), 6.0, 1.0, 0.9)
    before = known.belief
    assert not known.restrained
    known = fly(known, 4.0, 1.0, 0.9, held=True)
    assert known.restrained
    assert math.dist(known.belief.disturbance_n, before.disturbance_n) < 0.3
    assert known.belief.thrust_scale == pytest.approx(before.thrust_scale, abs=0.02)
    assert known.belief.drag == pytest.approx(before.drag, abs=0.05)
    known = fly(known, 2.0, 1.0, 0.9)
    assert not known.restrained


def test_a_vehicle_that_is_let_go_is_seen_to_be_free_before_it_is_fast() -> None:
    """Held while it leans to the north; a noise of velocity as outdoors does not free it, 0.13 m/s northwards does."""
    rng = random.Random(7)
    known, place = fly(level_start(), 6.0, 1.0, 0.9), (0.0, 0.0, -10.0)

    def seen(known: EstimatorState, v_n: Vec3) -> EstimatorState:
        return update_estimate(known, Measurement(0.01, (-4.0, 0.0, G), place, v_n, moving=True), G)

    for k in range(400):
        known = seen(known, (rng.gauss(0.0, 0.03), rng.gauss(0.0, 0.03), rng.gauss(0.0, 0.03)))
        assert known.restrained or k < 50
    assert seen(known, (-0.2, 0.0, 0.0)).restrained
    assert not seen(known, (0.13, 0.0, 0.0)).restrained


def test_turning_round_is_not_being_held() -> None:
    """A vehicle that comes to rest and sets off the other way at 1.5 m/s^2."""
    known, v = level_start(), 3.0
    tan_tilt_max = 1.5
    for k in range(400):
        v -= tan_tilt_max * 0.01
        p = (3.0 * 0.01 * k - 0.5 * tan_tilt_max * (0.01 * k) ** 2, 0.0, -10.0)
        known = update_estimate(known, Measurement(0.01, (tan_tilt_max, 0.0, G), p, (v, 0.0, 0.0), moving=True), G)
        assert not known.restrained


def test_what_is_expected_is_what_the_filter_expects() -> None:
    """A measurement just there surprises nobody, and the belief stays where it was expected."""
    known = fly(level_start(), 3.0, 1.1, 0.6)
    seen = Measurement(0.01, (1.0, -2.0, 9.5), STILL, STILL)
    belief = known.belief
    forces = ForceModel(belief.thrust_scale, belief.drag, belief.apparent_disturbance_n(seen.specific_thrust_n), G)
    p_n, v_n = predict_measurement(belief, seen, forces)
    bias = known.belief.bias_n
    there = seen._replace(p_n=p_n, v_n=(v_n[0] + bias[0], v_n[1] + bias[1], v_n[2] + bias[2]))
    after = update_estimate(known, there, G).belief
    assert after.p_n == pytest.approx(p_n, abs=1e-7)
    assert after.v_n == pytest.approx(v_n, abs=1e-3)  # the bias fades by half a percent in a step


def test_a_jump_or_a_hand_that_holds_does_not_wait() -> None:
    known = fly(level_start(), 3.0, 1.0, 0.6)
    p_n, v_n = known.belief.p_n, known.belief.v_n
    near = Measurement(0.01, (0.0, 0.0, G), (p_n[0] + 0.1, p_n[1], p_n[2]), v_n)
    assert innovation_is_small(known, near, p_n, v_n)
    assert not innovation_is_small(known, near._replace(jumped=True), p_n, v_n)
    assert not innovation_is_small(known, near._replace(p_n=(p_n[0] + 0.3, p_n[1], p_n[2])), p_n, v_n)
    assert not innovation_is_small(known, near._replace(v_n=(v_n[0], v_n[1] - 0.6, v_n[2])), p_n, v_n)
    assert not innovation_is_small(fly(known, 4.0, 1.0, 0.6, held=True), near, p_n, v_n)


def test_a_jump_moves_the_place_and_nothing_else() -> None:
    known = fly(level_start(), 3.0, 1.1, 0.6)
    p, v = known.belief.p_n, known.belief.v_n
    moved = update_estimate(known, Measurement(0.01, (0.0, 0.0, 8.9), (p[0] + 5.0, p[1], p[2]), v), G)
    assert moved.belief.p_n[0] == pytest.approx(p[0] + 5.0)
    assert moved.belief.x[THRUST_SCALE:] == known.belief.x[THRUST_SCALE:]
    assert np.linalg.eigvalsh(dense(reset_position_velocity(known.belief, p, v, known.noise))).min() > 0.0


def test_trust_in_measurements_follows_their_noise() -> None:
    rng = random.Random(3)
    known = level_start()
    for _ in range(3000):
        p = (rng.gauss(0.0, 0.01), rng.gauss(0.0, 0.01), -10.0 + rng.gauss(0.0, 0.01))
        v = (rng.gauss(0.0, 0.03), rng.gauss(0.0, 0.03), rng.gauss(0.0, 0.03))
        known = update_estimate(known, Measurement(0.01, (0.0, 0.0, G), p, v), G)
    assert math.sqrt(known.noise.position) == pytest.approx(0.01, rel=0.3)
    assert math.sqrt(known.noise.velocity) == pytest.approx(0.03, rel=0.3)
    assert math.hypot(*known.belief.v_n) < 0.03
    assert not known.restrained


@pytest.mark.parametrize("true", [0.067, 0.08, 0.1])
def test_the_lag_of_the_rate_loop_is_found(true: float) -> None:
    """Told 71 ms; a gyro with noise, a loop whose gain is 5 % off, commands as a circle brings them."""
    rng = random.Random(4)
    rate_loop_state, rate_loop, lag = (
        RateLoopState(STILL, STILL, G),
        alike(true, 0.05),
        initial_rate_loop_estimate(0.071, STILL),
    )
    commands: tuple[TimedCommand, ...] = (TimedCommand(0.0, STILL, G),)
    for k in range(4000):
        t = 0.01 * k
        rate_loop_state, _ = propagate(rate_loop_state, rate_loop, commands, t, t + 0.01)
        gyro = (
            1.05 * rate_loop_state.w_b[0] + rng.gauss(0, 0.01),
            1.05 * rate_loop_state.w_b[1] + rng.gauss(0, 0.01),
            0.0,
        )
        lag = update_rate_loop_estimate(lag, 0.05, commands, t + 0.01, gyro)
        wanted = (0.4 * math.sin(1.2 * t), 0.4 * math.cos(1.2 * t), 0.0)
        commands = (*commands[-8:], TimedCommand(t + 0.015, wanted, G))
    assert lag.lag == pytest.approx(true, rel=0.12)


@pytest.mark.parametrize(("true", "found"), [(1.04, 1.04), (0.95, 1.0), (1.3, 1.1)])
def test_the_gain_of_the_rate_loop_is_found(true: float, found: float) -> None:
    """A loop that overshoots, told less by what is known of it; one that falls short is never told more."""
    rng = random.Random(6)
    rate_loop_state, rate_loop, lag = (
        RateLoopState(STILL, STILL, G),
        alike(0.071, 0.05),
        initial_rate_loop_estimate(0.071, STILL),
    )
    meant = sent = (TimedCommand(0.0, STILL, G),)
    for k in range(3000):
        t = 0.01 * k
        rate_loop_state, _ = propagate(rate_loop_state, rate_loop, sent, t, t + 0.01)
        gyro = (
            true * rate_loop_state.w_b[0] + rng.gauss(0, 0.01),
            true * rate_loop_state.w_b[1] + rng.gauss(0, 0.01),
            0.0,
        )
        lag = update_rate_loop_estimate(lag, 0.05, meant, t + 0.01, gyro)
        p, q = 0.4 * math.sin(1.2 * t), 0.4 * math.cos(1.2 * t)
        meant = (*meant[-8:], TimedCommand(t + 0.015, (p, q, 0.0), G))
        sent = (*sent[-8:], TimedCommand(t + 0.015, (p / lag.gains[0], q / lag.gains[1], 0.0), G))
    assert lag.gains == pytest.approx((found, found), abs=0.005)


def test_in_a_hover_the_lag_stays_as_believed() -> None:
    rng = random.Random(5)
    lag, commands = initial_rate_loop_estimate(0.071, STILL), (TimedCommand(0.0, STILL, G),)
    for k in range(3000):
        gyro = (rng.gauss(0, 0.01), rng.gauss(0, 0.01), rng.gauss(0, 0.01))
        lag = update_rate_loop_estimate(lag, 0.05, commands, 0.01 * k + 0.01, gyro)
    assert lag.lag == pytest.approx(0.071, rel=1e-6)
    assert lag.gains == (1.0, 1.0)


def test_a_lag_is_sought_within_reason() -> None:
    rate_loop_state, rate_loop, lag = (
        RateLoopState(STILL, STILL, G),
        alike(0.4, 0.05),
        initial_rate_loop_estimate(0.071, STILL),
    )
    commands: tuple[TimedCommand, ...] = (TimedCommand(0.0, STILL, G),)
    for k in range(4000):
        t = 0.01 * k
        rate_loop_state, _ = propagate(rate_loop_state, rate_loop, commands, t, t + 0.01)
        lag = update_rate_loop_estimate(lag, 0.05, commands, t + 0.01, rate_loop_state.w_b)
        commands = (*commands[-8:], TimedCommand(t + 0.015, (0.5 * math.sin(2.0 * t), 0.0, 0.0), G))
    assert lag.lag == pytest.approx(1.6 * 0.071, rel=0.01)


def test_roll_and_pitch_are_told_apart_and_an_axis_that_rests_goes_along() -> None:
    rng = random.Random(9)
    for both in (True, False):
        state, known = RateLoopState(STILL, STILL, G), initial_rate_loop_estimate(0.071, STILL)
        vehicle = RateLoop((0.095, 0.068), 0.05)
        commands: tuple[TimedCommand, ...] = (TimedCommand(0.0, STILL, G),)
        for k in range(4000):
            t = 0.01 * k
            state, _ = propagate(state, vehicle, commands, t, t + 0.01)
            gyro = (state.w_b[0] + rng.gauss(0, 0.01), state.w_b[1] + rng.gauss(0, 0.01), 0.0)
            known = update_rate_loop_estimate(known, 0.05, commands, t + 0.01, gyro)
            wanted = (0.4 * math.sin(1.7 * t), 0.4 * math.cos(1.3 * t) if both else 0.0, 0.0)
            commands = (*commands[-8:], TimedCommand(t + 0.015, wanted, G))
        assert known.lags == pytest.approx((0.095, 0.068) if both else (0.095, 0.095), rel=0.1)
        assert known.lag == pytest.approx(sum(known.lags) / 2.0)


def test_at_motors_two_states_of_250_hz_are_one_measurement_for_the_filter() -> None:
    body, q = Body(1.5, (0.02, 0.02, 0.04), 0.05), (1.0, 0.0, 0.0, 0.0)
    first = begin_motor_estimate(VehicleState(0.0, STILL, (1.0, 0.0, 0.0), q, STILL), Prior(), body, G)
    commands = (TimedWrench(-math.inf, (1.5 * G, 0.0, 0.0, 0.0)),)
    estimate = first
    for k in (1, 2):
        state = VehicleState(0.004 * k, (0.004 * k, 0.0, 0.0), (1.0, 0.0, 0.0), q, STILL)
        estimate = learn_motor_estimate(advance_motor_estimate(estimate, body, commands, state, k == 1, False))
        if k == 1:
            assert estimate.motion.pending is not None
            assert estimate.motion.estimator is first.motion.estimator
            assert estimate.motion.p_n == pytest.approx((0.004, 0.0, 0.0), abs=1e-9)
    both = Measurement(0.008, (0.0, 0.0, G), (0.008, 0.0, 0.0), (1.0, 0.0, 0.0), limited=True)
    assert estimate.motion.pending is None
    assert estimate.motion.estimator.belief.x == pytest.approx(
        update_estimate(first.motion.estimator, both, G).belief.x, abs=1e-12
    )
