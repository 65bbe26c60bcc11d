"""How well a flight tells the thrust curve and the motors' lag: the Cramer-Rao bound under the filter's own noise.

Whatever is estimated of two constants, from positions and velocities as they come and with all else as the filter has it,
is no nearer to them than this. The sensitivity s of the filter's state to such a constant goes through the filter,

    s -> (I - K H) (A s + B dt),      information += (H s)^T S^-1 H s

``B``: what the constant makes of the acceleration. Of a curve m that THR_MDL_FAC does not know of, at a hover of one
half: F m / 2 (F / F_hover - 1); of the lag, the derivative of the lagged thrust by it.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.estimation.estimator import EstimatorState
from companion.estimation.kalman_step import AXES, PER_AXIS, SIZE, VELOCITY
from companion.vehicle import VehicleState
from trials.prediction import linearised, measurement

Array = NDArray[np.float64]
HOVER_SHARE = 0.5
"""Normalised thrust of a hover, of PX4's simulated quadrotor."""


class Known(NamedTuple):
    """At a state: it, the thrust over mass there as commanded and lagged (m/s^2), and the filter updated with it."""

    state: VehicleState
    thrust: float
    estimator: EstimatorState


class Bound(NamedTuple):
    """Least standard deviations: of the curve, and of the lag (s); ``together``: of neither is the other known."""

    curve: float
    lag: float
    together: tuple[float, float]


def bound(flown: list[Known], gravity: float, motor_lag: float) -> Bound:
    """Of the states of a flight, one after another."""
    x, P = np.array(flown[0].estimator.belief.x), np.array(flown[0].estimator.belief.covariance())
    s, information = np.zeros((SIZE, 2)), np.zeros((2, 2))
    by_lag = 0.0  # derivative of the lagged thrust by the lag
    at = [PER_AXIS * axis + VELOCITY for axis in range(AXES)]
    for before, now in itertools.pairwise(flown):
        dt = now.state.t_boot - before.state.t_boot
        if dt <= 0.0:
            continue
        axis = 0.5 * np.add(before.state.z_axis_n, now.state.z_axis_n)
        thrust, noise, belief = 0.5 * (before.thrust + now.thrust), before.estimator.noise, before.estimator.belief
        by_lag += (dt / motor_lag) * (-(now.thrust - before.thrust) / dt - by_lag)
        by_curve = thrust * HOVER_SHARE * (thrust * belief.thrust_scale / gravity - 1.0)
        x = np.array(belief.x)
        F = thrust * axis
        _, A, Q = linearised(x, dt, (float(F[0]), float(F[1]), float(F[2])), gravity, noise)
        s = A @ s
        s[at, 0] -= dt * belief.thrust_scale * by_curve * axis
        s[at, 1] -= dt * belief.thrust_scale * by_lag * axis
        P = A @ P @ A.T + np.diag(Q)
        H, R = measurement(noise)
        inverse = np.linalg.inv(H @ P @ H.T + R)
        seen = H @ s
        information += seen.T @ inverse @ seen
        gain = P @ H.T @ inverse
        s, P = s - gain @ seen, P - gain @ H @ P
    curve, lag = 1.0 / np.sqrt(np.diag(information))
    both = np.sqrt(np.diag(np.linalg.inv(information)))
    return Bound(float(curve), float(lag), (float(both[0]), float(both[1])))
