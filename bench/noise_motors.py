"""What is flown at motors, in the linear world of ``bench.noise_world``: our Kalman filter with the noise it assumes,
the model of motors and body with the gyro as its observer, the predictor, the relaxation and the poles."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from bench.noise_flown import FOUND, SLOW, Loop, closed, filter_of
from bench.noise_world import DAMPING, DRAG, STEP, Array, Plant
from companion.estimation.body_model import TURN_OBSERVER
from companion.law.gains import from_poles
from companion.steering.timing import Timing
from companion.vehicle import GRAVITY as G
from companion.vehicle import Vehicle


def _timing(told: Vehicle) -> Timing:
    return Timing(STEP, 0.5 * STEP, told.motor_lag, 0.0)


def flown_level(plant: Plant, told: Vehicle, poles: tuple[complex, ...], observer: Array | None = None) -> Loop | None:
    """Of a level axis, None where it is not stable. ``poles``: 1/s, four of a distance, or three of the speed along the
    path. ``observer``: 1/s and 1/s^2, gains from the gyro to body rate and trim; None: those that are flown."""
    A, pushed, L = filter_of(FOUND[0], vertical=False)
    n, lag, timing = len(plant.A), told.motor_lag, _timing(told)
    along = len(poles) == 3
    k0, k1, k2, k3 = from_poles((-SLOW, *poles) if along else poles)
    # distance, its rate, tilt, body rate, what acts, disturbance, command, trim
    model = np.zeros((8, 8))
    model[0, 1], model[1, 1], model[1, 2], model[1, 5] = 1.0, -DRAG, G, 1.0
    model[2, 3], model[3, 3], model[3, 4], model[3, 7] = 1.0, -DAMPING, 1.0, 1.0
    model[4, 4], model[4, 6] = -1.0 / lag, 1.0 / lag
    ahead, one = expm(model * timing.horizon), expm(model * STEP)
    ratio = timing.relaxation(k3)
    near, far = np.array(TURN_OBSERVER if observer is None else observer) * STEP

    def step(state: Array, noise: Array) -> tuple[Array, float, float, float]:
        """The joint state a step later, the error, what is believed of it, and the command."""
        x, known, (w, acting, trim, tilt) = state[:n], state[n : n + 6], state[n + 6 :]
        y = plant.C @ x + noise
        known = A @ known + pushed * (0.5 * G * (tilt + y[2]))
        missed = y[3] - w
        w, trim = w + near * missed, trim + far * missed
        push = known[4] + known[5] + DRAG * known[2]
        now = np.array([known[0], known[1] + known[2], y[2], w, acting, push, x[n - 1], trim])
        p, v, leaning, turning, *_ = ahead @ now
        a = G * leaning + push - DRAG * v
        jerk = G * turning - DRAG * a
        wanted = (-k0 * p - k1 * v - k2 * a - k3 * jerk + DRAG * jerk) / G
        u = x[n - 1] + ratio * (wanted + DAMPING * turning - trim - x[n - 1])
        after = known + L @ (y[:2] - np.array([known[0], known[1] + known[3]]))
        joint = np.concatenate([plant.A @ x + plant.B[:, 0] * u, after, [*(one @ now)[3:5], trim, y[2]]])
        return joint, plant.e @ x, v if along else p, u

    return closed(plant, step, n + 10)


def flown_vertical(plant: Plant, told: Vehicle, poles: tuple[complex, ...]) -> Loop | None:
    """Of the vertical axis, whose plant takes the thrust; the command of the loop is its rate (m/s^3). ``poles``: 1/s,
    four."""
    A, pushed, L = filter_of(FOUND[1], vertical=True)
    n, lag, timing = len(plant.A), told.motor_lag, _timing(told)
    k0, k1, k2, k3 = from_poles(poles)
    # distance, its rate, what acts, disturbance, command
    model = np.zeros((5, 5))
    model[0, 1], model[1, 1], model[1, 2], model[1, 3] = 1.0, -DRAG, 1.0, 1.0
    model[2, 2], model[2, 4] = -1.0 / lag, 1.0 / lag
    ahead, one = expm(model * timing.horizon), expm(model * STEP)
    ratio = 1.0 / (1.0 + k3 * timing.hold)

    def step(state: Array, noise: Array) -> tuple[Array, float, float, float]:
        """As above."""
        x, known, (acting, last, zeta, slope, bend) = state[:n], state[n : n + 6], state[n + 6 :]
        y = plant.C @ x + noise
        known = A @ known + pushed * (0.5 * (last + acting))
        push = known[4] + known[5] + DRAG * known[2]
        now = np.array([known[0], known[1] + known[2], acting, push, x[n - 1]])
        p, v, *_ = ahead @ now
        sent, rising = zeta + timing.hold * slope, slope + timing.hold * bend
        a = sent + push - DRAG * v
        jerk = rising - DRAG * a
        wanted = -k0 * p - k1 * v - k2 * a - k3 * jerk + DRAG * jerk
        bend = bend + ratio * (wanted - bend)
        later = slope + STEP * bend
        zeta, slope = zeta + 0.5 * STEP * (slope + later), later
        after = known + L @ (y[:2] - np.array([known[0], known[1] + known[3]]))
        own = [(one @ now)[2], acting, zeta, slope, bend]
        return np.concatenate([plant.A @ x + plant.B[:, 0] * sent, after, own]), plant.e @ x, p, rising

    return closed(plant, step, n + 11)
