"""One step of the Kalman filter, recorded once and printed as straight-line floats. The model is in ``kalman``."""

from __future__ import annotations

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.estimation.translation import acceleration
from companion.frames import Vec3

PER_AXIS = 6
"""Number of states of each axis: P, V, U, B, D, W. By definition of the model."""
AXES = 3
"""Number of axes: north, east, down. By definition."""
POSITION, VELOCITY, WANDER, VELOCITY_ERROR, DISTURBANCE, GUST = range(PER_AXIS)
NORTH, EAST, DOWN = (PER_AXIS * axis for axis in range(AXES))
"""Index of the first state of each axis."""
THRUST_SCALE = AXES * PER_AXIS
"""Index of the thrust scale in the state. By definition."""
DRAG = THRUST_SCALE + 1
"""Index of the drag in the state. By definition."""
SIZE = THRUST_SCALE + 2
"""Number of states in all. By definition."""
UPPER = tuple((i, j) for i in range(SIZE) for j in range(i, SIZE))
AT = {pair: index for index, pair in enumerate(UPPER)}
DIAGONAL = tuple(AT[i, i] for i in range(SIZE))
"""Where the variance of each state stands in the upper triangle."""

WANDER_TIME = 0.5
"""s, time constant of U. Spectrum of PX4's position error on a recorded circle, sensors shaking: that of its derivative
is flat to 0.3 Hz and falls from there."""
VELOCITY_ERROR_TIME = 3.5
"""s, time constant of B. Recorded in the same session: 3 to 4 s."""
GUST_TIME = 1.0
"""s, time constant of W. Engineering choice: 5 m of gust at 5 m/s."""
DISTURBANCE_TIME: Vec3 = (1e9, 1e9, 10.0)
"""s, time constant of D: the wind stays, a vertical push does not. Engineering choice."""
DISTURBANCE_Q: Vec3 = (0.01, 0.01, 0.002)
"""m^2/s^5, process noise of D. Level: a tilt error of 0.7 deg over 3 s, and wind; vertical: 0.1 m/s^2 stationary,
the prior that tells the thrust scale from it. Engineering choice."""
POSITION_Q = 1e-8
"""m^2/s, process noise of P beyond its wander: none but rounding. Engineering choice."""
VELOCITY_Q = 1e-4
"""m^2/s^3, process noise of V beyond D and W: the motors' noise. Engineering choice."""
THRUST_SCALE_Q = 1e-5
"""1/s, process noise of kappa: 2.4 % in a minute, a battery that sags. Engineering choice."""
DRAG_Q = 1e-4
"""1/s^3, process noise of c: a payload that turns, rotors that speed up. Engineering choice."""
POSITION_R_MIN = 3e-4**2
"""m^2, variance of the reported position, sample by sample. Recorded in the same session: 0.1 mm."""
POSITION_Q_GAIN = 24.0
"""1/s. A position that is noisier than that also wanders step by step: so many times the excess of its variance a
second is added to its process noise. Sweep over the worlds of configs/worlds."""

Rows = dict[int, list[tuple[int, Scalar]]]
"""Rows of the transition that are not those of the identity: index -> (column, factor)."""


def _recorded() -> Function:
    tape = Tape()
    (dt,) = tape.inputs("dt")
    F = tape.inputs("fx", "fy", "fz")
    (g,) = tape.inputs("g")
    measured = tape.inputs("xm", "ym", "zm", "vxm", "vym", "vzm")
    noise_p, noise_v = tape.inputs("rp", "rv")
    levels = [tape.inputs(*(f"{kind}{axis}" for axis in "xyz")) for kind in ("u", "b", "w")]
    scale_q, learn = tape.inputs("qk", "learn")
    x: list[Scalar] = list(tape.inputs(*(f"x{i}" for i in range(SIZE))))
    upper = tape.inputs(*(f"p{i}_{j}" for i, j in UPPER))
    P: list[list[Scalar]] = [[upper[AT[min(i, j), max(i, j)]] for j in range(SIZE)] for i in range(SIZE)]
    x, rows = _transition(x, dt, F, g)
    P = _propagated(P, rows)
    for axis in range(AXES):
        u, b, w = (level[axis] for level in levels)
        noises = (
            POSITION_Q + (noise_p - POSITION_R_MIN) * POSITION_Q_GAIN, VELOCITY_Q, u * (2.0 / WANDER_TIME),
            b * (2.0 / VELOCITY_ERROR_TIME), DISTURBANCE_Q[axis], w * (2.0 / GUST_TIME),
        )  # fmt: skip
        for i, noise in enumerate(noises, PER_AXIS * axis):
            P[i][i] = P[i][i] + noise * dt
    P[THRUST_SCALE][THRUST_SCALE] = P[THRUST_SCALE][THRUST_SCALE] + (scale_q * dt) * learn
    P[DRAG][DRAG] = P[DRAG][DRAG] + (DRAG_Q * dt) * learn
    innovations: list[Scalar] = []
    variances: list[Scalar] = []
    for axis in range(AXES):
        x = _updated(x, P, (PER_AXIS * axis,), measured[axis], noise_p, learn, innovations, variances)
    for axis in range(AXES):
        states = (PER_AXIS * axis + VELOCITY, PER_AXIS * axis + VELOCITY_ERROR)
        x = _updated(x, P, states, measured[3 + axis], noise_v, learn, innovations, variances)
    return tape.function("kalman", [*x, *(P[i][j] for i, j in UPPER), *innovations, *variances])


def _transition(x: list[Scalar], dt: Scalar, F: tuple[Scalar, ...], g: Scalar) -> tuple[list[Scalar], Rows]:
    """x ``dt`` s later, and the transition's rows: each lag exactly in its decay to first order, P to second order."""
    kappa, c = x[THRUST_SCALE], x[DRAG]
    half = dt * dt * 0.5
    velocity, pushes = [], []
    for axis in range(AXES):
        at = PER_AXIS * axis
        velocity.append(x[at + VELOCITY])
        pushes.append(x[at + DISTURBANCE] + x[at + GUST])
    accelerations = acceleration(
        (kappa * F[0], kappa * F[1], kappa * F[2]), (velocity[0], velocity[1], velocity[2]), g, c,
        (pushes[0], pushes[1], pushes[2]),
    )  # fmt: skip
    later, rows = list(x), Rows()
    for axis in range(AXES):
        p, v, u, b, d, w = range(PER_AXIS * axis, PER_AXIS * (axis + 1))
        a = accelerations[axis]
        later[p], later[v] = x[p] + dt * (x[v] + x[u]) + half * a, x[v] + dt * a
        rows[p] = [(p, 1.0), (v, dt), (u, dt)]
        rows[v] = [(v, 1.0 - dt * c), (d, dt), (w, dt), (THRUST_SCALE, -(dt * F[axis])), (DRAG, -(dt * x[v]))]
        times = (WANDER_TIME, VELOCITY_ERROR_TIME, DISTURBANCE_TIME[axis], GUST_TIME)
        for i, time in zip((u, b, d, w), times, strict=True):
            if time > 1e6:
                continue
            keep = 1.0 / (1.0 + dt * (1.0 / time))  # positive at any step
            later[i] = x[i] * keep
            rows[i] = [(i, keep)]
    return later, rows


def _propagated(P: list[list[Scalar]], rows: Rows) -> list[list[Scalar]]:
    """F P F^T."""

    def combined(factors: list[tuple[int, Scalar]], of: list[Scalar]) -> Scalar:
        total: Scalar = 0.0
        for column, factor in factors:
            total = total + of[column] * factor
        return total

    half = [
        [combined(rows[i], [P[k][j] for k in range(SIZE)]) for j in range(SIZE)] if i in rows else list(P[i])
        for i in range(SIZE)
    ]
    result: list[list[Scalar]] = [[0.0] * SIZE for _ in range(SIZE)]
    for i, j in UPPER:
        result[i][j] = result[j][i] = combined(rows[j], half[i]) if j in rows else half[i][j]
    return result


def _updated(
    x: list[Scalar], P: list[list[Scalar]], states: tuple[int, ...], measured: Scalar, noise: Scalar, learn: Scalar,
    innovations: list[Scalar], variances: list[Scalar],
) -> list[Scalar]:  # fmt: skip
    """x after a measurement of the sum of ``states``; P is changed in place.

    Joseph's form with gain rows of zero for what is frozen: only the covariance among the frozen stays as it was.
    """
    predicted: Scalar = 0.0
    cross: list[Scalar] = [0.0] * SIZE
    for state in states:
        predicted = predicted + x[state]
        cross = [total + P[i][state] for i, total in enumerate(cross)]
    variance: Scalar = noise
    for state in states:
        variance = variance + cross[state]
    residual = measured - predicted
    inverse = 1.0 / variance
    innovations.append(residual)
    variances.append(variance)
    gains = [value * inverse for value in cross]
    for i, j in UPPER:
        taken = gains[i] * cross[j]
        P[i][j] = P[j][i] = P[i][j] - (taken * learn if i >= THRUST_SCALE else taken)
    frozen = (THRUST_SCALE, DRAG)
    return [
        value + (gain * residual) * (learn if i in frozen else 1.0)
        for i, (value, gain) in enumerate(zip(x, gains, strict=True))
    ]


STEP = _recorded()
"""(dt, F, g, measurement, noise, state, covariance) -> (state, covariance, innovations, variances)."""
