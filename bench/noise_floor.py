"""How near the path any controller could stay with the estimate that sih_noisy gives: ``python -m bench.noise_floor``.

One axis across the path, in steps of 8 ms, linear: what the vehicle reports (its errors as in the world's file, as
driven processes), the rate loop, one step of delay. Its state x, command u and measurements y:

    x' = A x + B u + noise W,  y = C x + noise R,  e = E x: the reported distance from the path

LQG: the gain of one Riccati equation (e^2 + rho u^2), the filter of the other. Of all linear controllers with that much
command this has the least e; with rho towards zero the bound falls to that of a vehicle that may shake at will. Beside
it what is flown: our Kalman filter (its assumed noise), predictor and poles in the same linear world, their covariance
by Lyapunov's equation. rho is set so that both command alike. docs/estimation.md has the table.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are, solve_discrete_lyapunov

from companion.config.world.world import load_world
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
from companion.vehicle import GRAVITY as G
from companion.vehicle import Vehicle
from trials.measured import machine

Array = NDArray[np.float64]

STEP = 0.008
"""s: states come and setpoints go at 125 Hz, and a setpoint acts one step later."""
RADIUS = 5.0
"""m, of the circle: how far the thrust leans."""
ROUND_OFF = 1e-5
"""m: a reported position has no noise of its own; the filter's equation wants some."""
DRAG = 1.0
"""1/s, of the vehicle."""


class Plant(NamedTuple):
    """One axis. ``A``, ``B``: of the step; ``W``: noise of the state; ``C``, ``R``: of the measurements position,
    velocity, tilt (or thrust), gyro; ``e``: the row that reports the distance."""

    A: Array
    B: Array
    W: Array
    C: Array
    R: Array
    e: Array


def _smooth(sigma: float, time: float) -> tuple[Array, Array]:
    """Two equal lags (A, noise density) of which the second has ``sigma``."""
    A = np.array([[-1.0 / time, 0.0], [1.0 / time, -1.0 / time]])
    return A, np.diag([4.0 * sigma**2 / time, 0.0])


def _discrete(A: Array, B: Array, W: Array, step: float) -> tuple[Array, Array, Array]:
    """Van Loan: the exact step of x' = A x + B u + noise of density W."""
    n = len(A)
    held = expm(np.block([[A, B], [np.zeros((1, n + 1))]]) * step)
    both = expm(np.block([[-A, W], [np.zeros((n, n)), A.T]]) * step)
    return held[:n, :n], held[:n, n:], both[n:, n:].T @ both[:n, n:]


def axis_at(speed: float, vehicle: Vehicle, *, vertical: bool = False, gain: float = 1.0) -> Plant:
    """An axis at ``speed`` on the circle. Level: body rate -> tilt -> acceleration; vertical: rate of the thrust, of
    which the motors make ``gain`` times what is asked for."""
    errors = load_world("sih_noisy").estimate
    axis = 2 if vertical else 0
    lean = speed * speed / RADIUS
    assert errors.drift is not None
    parts = [
        _smooth(errors.position.wander[axis], errors.position.wander_time),
        _smooth(errors.drift.speed[axis] * errors.drift.time, errors.drift.time),
        _smooth(errors.velocity.wander[axis], errors.velocity.wander_time),
        _smooth(errors.attitude.wander[0], errors.attitude.wander_time),
    ]
    n = 5 + 2 * len(parts)
    A, B, W = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((n, n))
    A[0, 1], A[1, 1], A[1, 2] = 1.0, -DRAG, G if not vertical else 1.0
    A[1, 12] = -(lean if vertical else G)  # the tilt is not what it is held to be
    if vertical:  # thrust over mass behind the motors, of which the rate is commanded
        A[2, 2], A[2, 3], B[3, 0] = -1.0 / vehicle.motor_lag, gain / vehicle.motor_lag, 1.0
        A[4, 4] = -1.0 / vehicle.motor_lag
    else:
        decay, stiff = 1.0 / vehicle.motor_lag, 1.0 / (vehicle.rate_loop_lag * vehicle.motor_lag)
        A[2, 3], A[3, 4], A[4, 3], A[4, 4], B[4, 0] = 1.0, 1.0, -stiff, -decay, stiff
        W[4, 4] = stiff**2 * errors.gyro.white[0] ** 2 * 0.5 * STEP  # its rate loop flies by that gyro
    for k, (own, noise) in enumerate(parts):
        at = slice(5 + 2 * k, 7 + 2 * k)
        A[at, at], W[at, at] = own, noise
    Ad, Bd, Wd = _discrete(A, B, W, STEP)
    C = np.zeros((4, n))
    C[0, [0, 6, 8]], C[1, [1, 10]], C[3, 3] = 1.0, 1.0, 1.0
    C[2, [2, 12]] = (1.0, 0.0) if vertical else (1.0, 1.0)
    white = (ROUND_OFF, errors.velocity.white[axis], errors.attitude.white[0], errors.gyro.white[0])
    R = np.diag(np.square((*white[:2], 1e-3, 1e-3) if vertical else white))
    return _delayed(Plant(Ad, Bd, Wd, C, R, C[0]))


def _delayed(plant: Plant) -> Plant:
    """A command acts one step later: it is a state."""
    n = len(plant.A)
    A = np.block([[plant.A, plant.B], [np.zeros((1, n + 1))]])
    B = np.vstack([np.zeros((n, 1)), [[1.0]]])
    W = np.block([[plant.W, np.zeros((n, 1))], [np.zeros((1, n + 1))]])
    wider = np.zeros((len(plant.C), 1))
    return plant._replace(A=A, B=B, W=W, C=np.hstack([plant.C, wider]), e=np.append(plant.e, 0.0))


def optimal(plant: Plant, rho: float) -> tuple[float, float]:
    """LQG: standard deviations of distance (m) and command for a cost of e^2 + rho u^2."""
    A, B, C = plant.A, plant.B, plant.C
    X = solve_discrete_are(A, B, np.outer(plant.e, plant.e) + 1e-12 * np.eye(len(A)), np.array([[rho]]))
    K = np.linalg.solve(B.T @ X @ B + rho, B.T @ X @ A)
    P = solve_discrete_are(A.T, C.T, plant.W + 1e-14 * np.eye(len(A)), plant.R)
    L = P @ C.T @ np.linalg.inv(C @ P @ C.T + plant.R)
    known = P - L @ C @ P  # of the estimate with the newest state
    # the estimate moves by what the filter learns at each step; e is the estimate and its error
    moved = solve_discrete_lyapunov(A - B @ K, L @ (C @ P @ C.T + plant.R) @ L.T)
    total = plant.e @ (moved + known) @ plant.e
    return math.sqrt(total), math.sqrt((K @ moved @ K.T).item())


def bound(plant: Plant, command: float) -> float:
    """The least distance (m) for a command of at most this standard deviation."""
    low, high = -16.0, 2.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        if optimal(plant, 10.0**middle)[1] > command:
            low = middle
        else:
            high = middle
    return optimal(plant, 10.0**high)[0]


MISTAKES = (
    ("all as told", 0.05, 0.05, 1.0),
    ("motors lag 15 ms, told 50", 0.015, 0.05, 1.0),
    ("motors lag 75 ms, told 50", 0.075, 0.05, 1.0),
    ("motors lag 60 ms, told 25", 0.06, 0.025, 1.0),
    ("thrust curve 0.3 at hover 0.5", 0.05, 0.05, 1.18),
    ("60 ms, told 25, and the curve", 0.06, 0.025, 1.18),
)
"""What; s of motor lag, true and told; thrust made over thrust asked for about the mean: of a curve m at a command u
(1 - m + 2 m u) / (1 - m + m u), the mean itself being found as the thrust scale."""


class Levels(NamedTuple):
    """What the filter takes the noise for once it has found it: (m/s)^2 of U and B, (m/s^2)^2 of W."""

    wander: float
    velocity_error: float
    gust: float


FOUND = (Levels(0.06**2, 0.22**2, 0.13**2), Levels(0.12**2, 0.22**2, 0.1**2))
"""Level and vertical, as flights on sih_noisy end with them."""


def _filter(levels: Levels, *, vertical: bool) -> tuple[Array, Array, Array]:
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


def flown(plant: Plant, told: Vehicle, pole: float, levels: Levels, *, vertical: bool = False) -> tuple[float, float]:
    """Our law in the same world: standard deviations of distance (m) and command, inf where it is not stable. ``told``:
    what its model believes of the vehicle. ``pole``: 1/s, three times."""
    A, pushed, L = _filter(levels, vertical=vertical)
    n = len(plant.A)
    horizon = 1.5 * STEP + told.rate_loop_lag
    k0, k1, k2 = pole**3, 3.0 * pole**2, 3.0 * pole
    f = 1.0 if vertical else G
    model = _model(told, vertical=vertical)
    ahead, one = expm(model * horizon), expm(model * STEP)
    near, far = 1.0 - math.exp(-STEP / GYRO_TIME), GYRO_ACCELERATION_GAIN * STEP

    def step(state: Array, noise: Array) -> tuple[Array, float]:
        """The joint state (plant, filter, reported actuator, rate observer) a step later, and the command."""
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
        return np.concatenate([plant.A @ x + plant.B[:, 0] * u, after, [acting], moved]), u

    return _deviations(plant, step, n + 9)


def _deviations(plant: Plant, step: Callable[[Array, Array], tuple[Array, float]], size: int) -> tuple[float, float]:
    """Standard deviations of distance (m) and command of a joint state that begins with the plant's."""
    n = len(plant.A)
    F = np.array([step(e, np.zeros(4))[0] for e in np.eye(size)]).T
    N = np.array([step(np.zeros(size), e)[0] for e in np.eye(4)]).T
    fu = np.array([step(e, np.zeros(4))[1] for e in np.eye(size)])
    nu = np.array([step(np.zeros(size), e)[1] for e in np.eye(4)])
    driven = np.zeros((size, size))
    driven[:n, :n] = plant.W
    if max(abs(np.linalg.eigvals(F))) >= 1.0:
        return math.inf, math.inf
    S = solve_discrete_lyapunov(F, driven + N @ plant.R @ N.T)
    return math.sqrt(plant.e @ S[:n, :n] @ plant.e), math.sqrt(fu @ S @ fu + nu @ plant.R @ nu)


def main() -> None:
    """Print a line a speed and pole: flown and the least, level and vertical, and both together."""
    vehicle = machine("sih")
    print("speed pole | level: flown, least cm | vertical: flown, least cm | together: flown, least cm, ratio")
    for speed in (3.0, 5.0, 7.0):
        for pole in (5.0, 6.0, 7.0, 8.0):
            ours, least = [], []
            for vertical in (False, True):
                plant = axis_at(speed, vehicle, vertical=vertical)
                distance, command = flown(plant, vehicle, pole, FOUND[vertical], vertical=vertical)
                ours.append(100.0 * distance)
                least.append(100.0 * bound(plant, command))
            both, floor = math.hypot(*ours), math.hypot(*least)
            print(
                f"{speed:5.0f} {-pole:4.0f} | {ours[0]:5.2f} {least[0]:5.2f} | {ours[1]:5.2f} {least[1]:5.2f} |"
                f" {both:5.2f} {floor:5.2f} {both / floor:5.2f}"
            )
    print("wrong files, 3 m/s, poles -6 | level cm, vertical cm, together")
    for what, lag, told_lag, gain in MISTAKES:
        true, told = (dataclasses.replace(vehicle, motor_lag=each) for each in (lag, told_lag))
        off: list[float] = []
        for vertical in (False, True):
            plant = axis_at(3.0, true, vertical=vertical, gain=gain)
            off.append(100.0 * flown(plant, told, 6.0, FOUND[vertical], vertical=vertical)[0])
        print(f"{what:30} | {off[0]:5.2f} {off[1]:5.2f} {math.hypot(*off):5.2f}")


if __name__ == "__main__":
    main()
