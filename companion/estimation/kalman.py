"""The Kalman filter of flight: position, velocity, what the vehicle does not say, and how its own estimate wanders.

Of each axis, and of the vehicle:

    P' = V + U                       P: the reported position              U' = -U / 0.5 s + noise
    V' = g e3 - kappa F - c V + D + W                                       B' = -B / 3.5 s + noise
    measured:  P and V + B           D: slow disturbance, W: gusts         W' = -W / 1 s + noise
    kappa' = c' = noise              D' = noise (level), -D / 10 s + noise (vertical)

``F``: the commanded thrust over mass, lagged by the motors, along the thrust axis (m/s^2), a mean over the step.
``kappa``: the thrust scale, thrust made over thrust commanded (hover thrust, mass, battery). ``c``: drag over mass.

``U`` and ``B`` are the errors of the vehicle's own estimator (an EKF), as velocities: the reported position wanders
about the true one at U, smoothly and back again; the reported velocity is wrong by B. Both are coloured. A filter that
takes them for white (or the wander for motion that stays) is biased in a closed loop: the controller pushes the
reported position back to the path while its error returns by itself, so that thrust and drag seem to do more than they
do. On a recorded circle such a filter came to 1.4 times the thrust scale and drag in a minute and believed it.

In level flight kappa is hardly told from a vertical disturbance. What tells them apart is physics: air seldom pushes
a quadrotor up or down for long. So the vertical D is a process with a small stationary deviation, and what the
horizontals do not say goes to kappa. The level D also takes the tilt error of the vehicle's estimate, g times it, which
is not told from a steady wind and acts like one.

The covariance is full, kept as its upper triangle; a step is recorded once and printed as straight-line floats.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.estimation.noise_levels import NoiseLevels
from companion.estimation.translation import acceleration
from companion.frames import Vec3

PER_AXIS = 6
"""Numbers of the state that each axis has: P, V, U, B, D, W."""
AXES = 3
"""north, east, down."""
POSITION, VELOCITY, WANDER, VELOCITY_ERROR, DISTURBANCE, GUST = range(PER_AXIS)
THRUST_SCALE = AXES * PER_AXIS
"""Index in the state."""
DRAG = THRUST_SCALE + 1
"""Index in the state."""
SIZE = THRUST_SCALE + 2
"""states in all."""
UPPER = tuple((i, j) for i in range(SIZE) for j in range(i, SIZE))
AT = {pair: index for index, pair in enumerate(UPPER)}

WANDER_TIME = 0.5
"""s, time constant of U. Spectrum of PX4's position error on a recorded circle, sensors shaking: that of its derivative
is flat to 0.3 Hz and falls from there."""
VELOCITY_ERROR_TIME = 3.5
"""s, time constant of B. Same session: 3 to 4 s."""
GUST_TIME = 1.0
"""s, time constant of W. Engineering choice: 5 m of gust at 5 m/s."""
DISTURBANCE_TIME: Vec3 = (1e9, 1e9, 10.0)
"""s, time constant of D: the wind stays, a vertical push does not."""
DISTURBANCE_Q: Vec3 = (0.01, 0.01, 0.002)
"""m^2/s^5, process noise of D. Level: a tilt error of 0.7 deg over 3 s, and wind; vertical: 0.1 m/s^2 stationary, the
prior that tells the thrust scale from it."""
POSITION_Q = 1e-8
"""m^2/s, process noise of P beyond its wander: none but rounding."""
VELOCITY_Q = 1e-4
"""m^2/s^3, process noise of V beyond D and W: the motors' noise."""
THRUST_SCALE_Q = 1e-5
"""1/s, process noise of kappa: 2.4 % in a minute, a battery that sags."""
DRAG_Q = 1e-4
"""1/s^3, process noise of c: a payload that turns, rotors that speed up."""
POSITION_R_MIN = 3e-4**2
"""m^2, variance of the reported position, sample by sample. Same session: 0.1 mm."""
POSITION_Q_GAIN = 24.0
"""1/s. A position that is noisier than that also wanders step by step: so many times the excess of its variance a
second is added to its process noise. Sweep over the worlds of configs/worlds."""
PRIOR_POSITION_STD = 1e-3
"""m. The reported position is what is followed, whatever the true one."""
PRIOR_DISTURBANCE_STD: Vec3 = (1.5, 1.5, 0.1)
"""m/s^2. Engineering choice: a wind of 5 m/s on a vehicle with a third of the drag of PX4's simulated one."""


class Belief(NamedTuple):
    """``x``: (P, V, U, B, D, W) of each axis, kappa, c. ``P``: its covariance, the upper triangle row by row."""

    x: tuple[float, ...]
    P: tuple[float, ...]

    def of(self, kind: int) -> Vec3:
        """One of the six numbers of each axis."""
        x = self.x
        return (x[kind], x[kind + PER_AXIS], x[kind + 2 * PER_AXIS])

    @property
    def p_n(self) -> Vec3:
        """m, the reported position."""
        return self.of(POSITION)

    @property
    def v_n(self) -> Vec3:
        """m/s, the derivative of the reported position: V + U."""
        (a, b, c), (u, v, w) = self.of(VELOCITY), self.of(WANDER)
        return (a + u, b + v, c + w)

    @property
    def disturbance_n(self) -> Vec3:
        """m/s^2: D + W."""
        (a, b, c), (u, v, w) = self.of(DISTURBANCE), self.of(GUST)
        return (a + u, b + v, c + w)

    @property
    def apparent_disturbance_n(self) -> Vec3:
        """m/s^2, what acts on the reported motion beside thrust and the drag of its velocity V + U: D + W + c U."""
        (a, b, c), (u, v, w), drag = self.disturbance_n, self.of(WANDER), self.drag
        return (a + drag * u, b + drag * v, c + drag * w)

    @property
    def bias_n(self) -> Vec3:
        """m/s, the reported velocity minus the derivative of the reported position: B - U."""
        (a, b, c), (u, v, w) = self.of(VELOCITY_ERROR), self.of(WANDER)
        return (a - u, b - v, c - w)

    @property
    def thrust_scale(self) -> float:
        """Thrust made over thrust commanded."""
        return self.x[THRUST_SCALE]

    @property
    def drag(self) -> float:
        """1/s."""
        return self.x[DRAG]

    def variance(self, index: int) -> float:
        """Of one number of the state."""
        return self.P[AT[index, index]]


class Innovation(NamedTuple):
    """``residual``: measured minus predicted position (m) and velocity (m/s) of each axis, one after the other.
    ``variance``: as predicted."""

    residual: tuple[float, ...]
    variance: tuple[float, ...]


def initial_belief(
    p_n: Vec3, v_n: Vec3, disturbance_n: Vec3, thrust_scale: tuple[float, float], drag: tuple[float, float],
    noise: NoiseLevels,
) -> Belief:  # fmt: skip
    """Before the first update. ``thrust_scale``, ``drag`` (1/s): value and standard deviation."""
    x, P = [0.0] * SIZE, [0.0] * len(UPPER)
    for axis in range(AXES):
        at = PER_AXIS * axis
        x[at + DISTURBANCE] = disturbance_n[axis]
        P[AT[at + DISTURBANCE, at + DISTURBANCE]] = PRIOR_DISTURBANCE_STD[axis] ** 2
        P[AT[at + GUST, at + GUST]] = noise.gust[axis]
    for index, (value, deviation) in ((THRUST_SCALE, thrust_scale), (DRAG, drag)):
        x[index], P[AT[index, index]] = value, deviation**2
    return reset_position_velocity(Belief(tuple(x), tuple(P)), p_n, v_n, noise)


def reset_position_velocity(belief: Belief, p_n: Vec3, v_n: Vec3, noise: NoiseLevels) -> Belief:
    """``belief`` with position and velocity reset to what is reported (m, m/s), their errors to none, and their
    cross-covariances with all else zeroed, as after a jump of the vehicle's own estimate; what is known of the forces
    stays."""
    x, P = list(belief.x), list(belief.P)
    for axis in range(AXES):
        at = PER_AXIS * axis
        u, b = noise.wander[axis], noise.velocity_error[axis]
        x[at : at + 4] = p_n[axis], v_n[axis], 0.0, 0.0
        for moved, variance in enumerate((PRIOR_POSITION_STD**2, b + noise.velocity, u, b), at):
            for other in range(SIZE):
                P[AT[min(moved, other), max(moved, other)]] = variance if other == moved else 0.0
        P[AT[at + VELOCITY, at + VELOCITY_ERROR]] = -b
    return Belief(tuple(x), tuple(P))


def reset_disturbance(belief: Belief, p_n: Vec3, v_n: Vec3, disturbance_n: Vec3, noise: NoiseLevels) -> Belief:
    """``belief`` with position and velocity reset, and the disturbance (m/s^2) too."""
    there = reset_position_velocity(belief, p_n, v_n, noise)
    x = list(there.x)
    for axis in range(AXES):
        at = PER_AXIS * axis
        x[at + GUST] = disturbance_n[axis] - x[at + DISTURBANCE]
    return Belief(tuple(x), there.P)


def predict_and_update(
    belief: Belief, dt: float, specific_thrust_n: Vec3, gravity: float, p_n: Vec3, v_n: Vec3,
    noise: NoiseLevels, learning: bool, thrust_scale_q: float = THRUST_SCALE_Q,
) -> tuple[Belief, Innovation]:  # fmt: skip
    """``belief`` ``dt`` s later, after a measurement of position (m) and velocity (m/s).

    ``specific_thrust_n``: F, m/s^2. ``learning``: False freezes kappa and c. ``thrust_scale_q``: 1/s, process noise of
    kappa.
    """
    told = _STEP(
        dt, *specific_thrust_n, gravity, *p_n, *v_n, noise.position, noise.velocity, *noise.wander,
        *noise.velocity_error, *noise.gust, thrust_scale_q, 1.0 if learning else 0.0, *belief.x, *belief.P,
    )  # fmt: skip
    end = SIZE + len(UPPER)
    return Belief(told[:SIZE], told[SIZE:end]), Innovation(told[end : end + 6], told[end + 6 :])


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


_STEP = _recorded()
