"""What is flown, in the linear world of ``bench.noise_world``: our Kalman filter with the noise it assumes, the
predictor and the poles; covariances by Lyapunov's equation."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm, solve_discrete_are, solve_discrete_lyapunov

from bench.noise_world import DRAG, STEP, Array, Plant
from companion.estimation.adaptation import DISTURBANCE_Q, NOISE_MIN
from companion.estimation.kalman_step import (
    DISTURBANCE_TIME,
    GUST_TIME,
    POSITION_Q,
    VELOCITY_ERROR_TIME,
    VELOCITY_Q,
    WANDER_TIME,
)
from companion.estimation.rate_loop_model import GYRO_ACCELERATION_GAIN, GYRO_TIME
from companion.law.gains import from_poles
from companion.vehicle import GRAVITY as G
from companion.vehicle import Vehicle

SLOW = 0.02
"""1/s, of a third pole where only the speed is held: the place along the path has a covariance then."""


class Levels(NamedTuple):
    """What the filter takes the noise for once it has found it: (m/s)^2 of U and B, (m/s^2)^2 of W."""

    wander: float
    velocity_error: float
    gust: float


FOUND = (Levels(0.06**2, 0.22**2, 0.13**2), Levels(0.12**2, 0.22**2, 0.1**2))
"""Level and vertical, as flights on sih_noisy end with them."""


class Loop(NamedTuple):
    """The closed loop over (plant, filter, reported actuator, rate observer): ``F``: its step; ``driven``:
    noise of a step. ``error``, ``believed``, ``command``: deviations, m (or m/s) and rad/s (or m/s^3)."""

    F: Array
    driven: Array
    error: float
    believed: float
    command: float


def filter_of(levels: Levels, *, vertical: bool) -> tuple[Array, Array, Array]:
    """Our filter of one axis, thrust scale and drag known: transition, what an acceleration moves, steady gain."""
    A, axis = np.eye(6), 2 if vertical else 0
    A[0, [1, 2]] = A[1, [4, 5]] = STEP
    A[1, 1] -= STEP * DRAG
    for i, time in ((2, WANDER_TIME), (3, VELOCITY_ERROR_TIME), (4, DISTURBANCE_TIME[axis]), (5, GUST_TIME)):
        A[i, i] = 1.0 / (1.0 + STEP / time)
    Q = np.diag([
        POSITION_Q, VELOCITY_Q, 2.0 * levels.wander / WANDER_TIME, 2.0 * levels.velocity_error / VELOCITY_ERROR_TIME,
        DISTURBANCE_Q[axis], 2.0 * levels.gust / GUST_TIME,
    ]) * STEP  # fmt: skip
    C = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]])
    P = solve_discrete_are(A.T, C.T, Q, np.diag(NOISE_MIN))
    pushed = np.array([0.5 * STEP**2, STEP, 0.0, 0.0, 0.0, 0.0])
    return A, pushed, P @ C.T @ np.linalg.inv(C @ P @ C.T + np.diag(NOISE_MIN))


def _model(vehicle: Vehicle, *, vertical: bool) -> Array:
    """What the predictor integrates: distance, its rate, the actuator's three states, the disturbance, the command."""
    model = np.zeros((7, 7))
    model[0, 1], model[1, 1], model[1, 2], model[1, 5] = 1.0, -DRAG, 1.0 if vertical else G, 1.0
    if vertical:
        model[2, 2], model[2, 3] = -1.0 / vehicle.motor_lag, 1.0 / vehicle.motor_lag
    else:
        decay, stiff = 1.0 / vehicle.motor_lag, 1.0 / (vehicle.rate_loop_lag * vehicle.motor_lag)
        model[2, 3], model[3, 4], model[4, 3], model[4, 4], model[4, 6] = 1.0, 1.0, -stiff, -decay, stiff
    return model


def flown(
    plant: Plant, told: Vehicle, poles: tuple[complex, ...], *, vertical: bool = False, levels: Levels | None = None
) -> Loop | None:
    """Our law in the same world, None where it is not stable. ``told``: what its model believes of the vehicle.
    ``poles``: 1/s, three of a distance, or two of the speed along the path."""
    A, pushed, L = filter_of(levels or FOUND[vertical], vertical=vertical)
    n = len(plant.A)
    horizon = 1.5 * STEP + told.rate_loop_lag
    along = len(poles) == 2
    k0, k1, k2 = from_poles((-SLOW, *poles) if along else poles)
    f = 1.0 if vertical else G
    model = _model(told, vertical=vertical)
    ahead, one = expm(model * horizon), expm(model * STEP)
    near, far = 1.0 - math.exp(-STEP / GYRO_TIME), GYRO_ACCELERATION_GAIN * STEP

    def step(state: Array, noise: Array) -> tuple[Array, float, float, float]:
        """The joint state a step later, the error, what is believed of it, and the command."""
        x, known, last, rates = state[:n], state[n : n + 6], state[n + 6], state[n + 7 :]
        y = plant.C @ x + noise
        acting = rates[0] if vertical else y[2]  # of the thrust only the model is known
        known = A @ known + pushed * (0.5 * f * (last + acting))
        rates = np.array([x[3], 0.0]) if vertical else rates + np.array([near, far]) * (y[3] - rates[0])
        push = known[4] + known[5] + DRAG * known[2]
        now = np.array([known[0], known[1] + known[2], acting, *rates, push, x[n - 1]])
        p, v, there, *_ = ahead @ now
        a = (now[3] if vertical else f * there) + push - DRAG * v
        u = (-k0 * p - k1 * v - k2 * a + DRAG * a) / f
        moved = (one @ now)[[2, 3]] if vertical else (one @ now)[3:5]
        after = known + L @ (y[:2] - np.array([known[0], known[1] + known[3]]))
        joint = np.concatenate([plant.A @ x + plant.B[:, 0] * u, after, [acting], moved])
        return joint, plant.e @ x, v if along else p, u

    return closed(plant, step, n + 9)


def closed(plant: Plant, step: Callable[[Array, Array], tuple[Array, float, float, float]], size: int) -> Loop | None:
    """The loop of a joint state that begins with the plant's."""
    n, still = len(plant.A), np.zeros(4)
    states, noises = [step(e, still) for e in np.eye(size)], [step(np.zeros(size), e) for e in np.eye(4)]
    F, N = np.array([each[0] for each in states]).T, np.array([each[0] for each in noises]).T
    if max(abs(np.linalg.eigvals(F))) >= 1.0:
        return None
    driven = N @ plant.R @ N.T
    driven[:n, :n] += plant.W
    S = solve_discrete_lyapunov(F, driven)

    def deviation(which: int) -> float:
        row, new = (np.array([float(each[which]) for each in every]) for every in (states, noises))
        return math.sqrt(row @ S @ row + new @ plant.R @ new)

    return Loop(F, driven, deviation(1), deviation(2), deviation(3))
