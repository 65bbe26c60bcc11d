"""What the filter predicts, against what comes: its normalised innovations squared (NIS), a state or a second ahead.

The prediction is the textbook's, in matrices, of the model at the head of companion.estimation.kalman: the filter's own
step always takes a measurement.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from companion.estimation import kalman_step as model
from companion.estimation.estimator import EstimatorState
from companion.estimation.kalman_step import AXES, DRAG, PER_AXIS, SIZE, THRUST_SCALE
from companion.estimation.noise_levels import NoiseLevels
from companion.frames import Vec3
from companion.vehicle import VehicleState

Array = NDArray[np.float64]
NIS_BOUNDS = (1.237, 14.449)
"""95 % of chi squared with six degrees of freedom: position and velocity of three axes."""


def predict(
    x: Array, P: Array, dt: float, F: Vec3, gravity: float, noise: NoiseLevels, learning: bool = True
) -> tuple[Array, Array]:
    """Mean and covariance ``dt`` s later. See ``linearised``."""
    new, A, Q = linearised(x, dt, F, gravity, noise, learning)
    return new, A @ P @ A.T + np.diag(Q)


def linearised(
    x: Array, dt: float, F: Vec3, gravity: float, noise: NoiseLevels, learning: bool = True
) -> tuple[Array, Array, Array]:
    """Mean ``dt`` s later, transition of its deviations, variances of the process noise. ``F``: the commanded thrust
    over mass, lagged by the motors, m/s^2; ``learning``: False freezes k and c."""
    k, c = x[THRUST_SCALE], x[DRAG]
    A, new, Q = np.eye(SIZE), x.copy(), np.zeros(SIZE)
    if learning:
        Q[THRUST_SCALE:] = model.THRUST_SCALE_Q, model.DRAG_Q
    lifting = (F[0] ** 2 + F[1] ** 2) * noise.tilt_error * 2.0 / model.DISTURBANCE_TIME[2]
    position_q = model.POSITION_Q + model.POSITION_Q_GAIN * (noise.position - model.POSITION_R_MIN)
    for axis in range(AXES):
        p, v, u, b, d, w, e = range(PER_AXIS * axis, PER_AXIS * (axis + 1))
        across = (-F[1], F[0], 0.0)[axis]
        f = F[axis] - x[e] * across
        a = (gravity if axis == 2 else 0.0) - k * f - c * x[v] + x[d] + x[w]
        new[p], new[v] = x[p] + dt * (x[v] + x[u]) + 0.5 * dt * dt * a, x[v] + dt * a
        A[p, [v, u]] = dt
        A[v, [v, d, w, e]] = 1.0 - c * dt, dt, dt, k * across * dt
        A[v, [THRUST_SCALE, DRAG]] = -f * dt, -x[v] * dt
        lags = (
            (u, model.WANDER_TIME, noise.wander[axis]), (b, model.VELOCITY_ERROR_TIME, noise.velocity_error[axis]),
            (w, model.GUST_TIME, noise.gust[axis]), (e, model.HEADING_ERROR_TIME, noise.heading_error),
        )  # fmt: skip
        for i, time, level in lags:
            A[i, i], Q[i] = 1.0 / (1.0 + dt / time), 2.0 * level / time
            new[i] = x[i] * A[i, i]
        A[d, d] = 1.0 / (1.0 + dt / model.DISTURBANCE_TIME[axis])
        new[d], Q[d] = x[d] * A[d, d], noise.disturbance_q[axis] + (lifting if axis == 2 else 0.0)
        Q[p], Q[v] = position_q, model.VELOCITY_Q
    return new, A, Q * dt


def measurement(noise: NoiseLevels) -> tuple[Array, Array]:
    """What is measured of the state (position m, velocity m/s), and the covariance of its noise."""
    H = np.zeros((2 * AXES, SIZE))
    for axis in range(AXES):
        H[axis, PER_AXIS * axis + model.POSITION] = 1.0
        H[AXES + axis, [PER_AXIS * axis + model.VELOCITY, PER_AXIS * axis + model.VELOCITY_ERROR]] = 1.0
    return H, np.diag([noise.position] * AXES + [noise.velocity] * AXES)


def normalised_innovation(x: Array, P: Array, p_n: Vec3, v_n: Vec3, noise: NoiseLevels) -> float:
    """The square of what is measured minus what is predicted (position m, velocity m/s), over its covariance."""
    H, R = measurement(noise)
    S = H @ P @ H.T + R
    off = np.array([*p_n, *v_n]) - H @ x
    return float(off @ np.linalg.solve(S, off))


class Forecast:
    """The NIS of predictions ``ahead`` s long, one after the other: ``found`` has (stamp, NIS)."""

    def __init__(self, ahead: float, gravity: float) -> None:
        self._ahead, self._gravity = ahead, gravity
        self._begun: tuple[float, NoiseLevels, Array, Array] | None = None
        self._last: tuple[VehicleState, float] | None = None
        self.found: list[tuple[float, float]] = []

    def take(self, state: VehicleState, thrust: float, known: EstimatorState) -> None:
        """The next state, the thrust over mass there as commanded and lagged (m/s^2), and the filter updated with it."""
        if self._last is not None and state.t_boot <= self._last[0].t_boot:
            return
        if self._begun is not None and self._last is not None:
            at, noise, x, P = self._begun
            before, thrust_before = self._last
            half, mean = 0.5, 0.5 * (thrust + thrust_before)
            (ox, oy, oz), (a, b, c) = before.z_axis_n, state.z_axis_n
            F = (half * mean * (ox + a), half * mean * (oy + b), half * mean * (oz + c))
            x, P = predict(x, P, state.t_boot - before.t_boot, F, self._gravity, noise)
            self._begun = at, noise, x, P
            if state.t_boot - at >= self._ahead - 1e-6:
                self.found.append((state.t_boot, normalised_innovation(x, P, state.p_n, state.v_n, noise)))
                self._begun = None
        if self._begun is None:
            belief = known.belief
            self._begun = state.t_boot, known.noise, np.array(belief.x), np.array(belief.covariance())
        self._last = state, thrust


def nis_line(ahead: str, values: Sequence[float]) -> str:
    """What came of predictions so far ``ahead``, in a line."""
    above = 100.0 * np.mean([value >= NIS_BOUNDS[1] for value in values])
    return (
        f"NIS {ahead} ahead: mean {np.mean(values):.2f} of 6, inside {100.0 * share_inside(values):.0f} %,"
        f" above {above:.1f} %, of {len(values)}"
    )


def share_inside(values: Sequence[float]) -> float:
    """Of normalised innovations: the share within NIS_BOUNDS."""
    return float(np.mean([NIS_BOUNDS[0] < value < NIS_BOUNDS[1] for value in values]))
