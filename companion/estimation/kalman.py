"""The Kalman filter of flight: position, velocity, and what the vehicle does not say.

    p' = v      v' = g e3 - kappa F - c v + d      d' = noise      beta' = -beta/2 s + noise      kappa', c' = noise
    measured: X = p, V = v + beta

``F``: the commanded thrust over mass, lagged by the motors, along the thrust axis (m/s^2), a mean over the step.
``kappa``: the thrust scale, thrust made over thrust commanded (hover thrust, mass, battery). ``c``: drag over mass,
which turns with the flight; ``d``: the disturbance, what is left, wind first of all. ``beta``: the reported velocity
minus the derivative of the reported position: an estimator that corrects its position does not put the correction into
its velocity, and a law that is fed both would fly (k1/k0) beta beside the path.

The covariance is full, kept as its upper triangle; a step is recorded once and printed as straight-line floats.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.estimation.translation import acceleration
from companion.frames import Vec3

PER_AXIS = 4
"""Numbers of the state that each axis has."""
AXES = 3
THRUST_SCALE = 12
"""Index in the state."""
DRAG = 13
"""Index in the state."""
SIZE = 14
UPPER = tuple((i, j) for i in range(SIZE) for j in range(i, SIZE))
AT = {pair: index for index, pair in enumerate(UPPER)}

BIAS_TIME = 2.0
"""s, time constant of the bias of the velocity. Flights on PX4's simulated quadrotor (0.3 to 1 Hz hold its power)."""
POSITION_Q = 1e-6
"""m^2/s, process noise. Same flights."""
VELOCITY_Q = 1e-3
"""m^2/s^3, process noise: 0.03 m/s^2 of residual acceleration per axis, measured. Same flights."""
BIAS_Q = 3e-3
"""m^2/s^3, process noise of the bias. Same flights."""
THRUST_SCALE_Q = 1e-5
"""1/s, process noise of the thrust scale. Same flights."""
DRAG_Q = 1e-4
"""1/s^3, process noise of the drag. Same flights."""
DISTURBANCE_Q: Vec3 = (0.3, 0.3, 0.03)
"""m^2/s^5, process noise. The vertical one is small, because in a hover it is not told from the thrust scale."""
POSITION_R_MIN = 1e-3**2
"""m^2, variance of PX4's own smooth position, quiet. Same flights."""
POSITION_Q_GAIN = 24.0
"""1/s. A position that is noisier also wanders: so many times the excess of its variance a second is added to its
process noise, and not taken for velocity. Sweep over the worlds of configs/worlds."""
PRIOR_POSITION_STD = 1e-2
"""m. Engineering choice: the vehicle's own estimate is where it says."""
PRIOR_VELOCITY_STD = 1e-1
"""m/s. Engineering choice."""
PRIOR_BIAS_STD = 0.07
"""m/s. Flights on PX4's simulated quadrotor: 1.5 to 4 cm/s."""
PRIOR_DISTURBANCE_STD: Vec3 = (0.7, 0.7, 0.22)
"""m/s^2. Engineering choice: a wind of 5 m/s on a vehicle with little drag; vertically a third of it."""


class Belief(NamedTuple):
    """``x``: (p, v, d, beta) of each axis, kappa, c. ``P``: its covariance, the upper triangle row by row."""

    x: tuple[float, ...]
    P: tuple[float, ...]

    @property
    def p_n(self) -> Vec3:
        """m."""
        return (self.x[0], self.x[4], self.x[8])

    @property
    def v_n(self) -> Vec3:
        """m/s, the derivative of the position."""
        return (self.x[1], self.x[5], self.x[9])

    @property
    def disturbance_n(self) -> Vec3:
        """m/s^2."""
        return (self.x[2], self.x[6], self.x[10])

    @property
    def bias_n(self) -> Vec3:
        """m/s, beta."""
        return (self.x[3], self.x[7], self.x[11])

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
    p_n: Vec3, v_n: Vec3, disturbance_n: Vec3, thrust_scale: tuple[float, float], drag: tuple[float, float]
) -> Belief:
    """Before the first update. ``thrust_scale``, ``drag`` (1/s): value and standard deviation."""
    x: list[float] = []
    deviations: list[float] = []
    for p, v, d, doubt in zip(p_n, v_n, disturbance_n, PRIOR_DISTURBANCE_STD, strict=True):
        x += [p, v, d, 0.0]
        deviations += [PRIOR_POSITION_STD, PRIOR_VELOCITY_STD, doubt, PRIOR_BIAS_STD]
    x += [thrust_scale[0], drag[0]]
    deviations += [thrust_scale[1], drag[1]]
    return Belief(tuple(x), tuple(deviations[i] ** 2 if i == j else 0.0 for i, j in UPPER))


def reset_position_velocity(belief: Belief, p_n: Vec3, v_n: Vec3) -> Belief:
    """``belief`` with position, velocity and bias reset (m, m/s) and their cross-covariances zeroed, as after a jump of
    the vehicle's own estimate; what is known of the forces stays."""
    x, P = list(belief.x), list(belief.P)
    for axis in range(AXES):
        place, speed, bias = PER_AXIS * axis, PER_AXIS * axis + 1, PER_AXIS * axis + 3
        x[place], x[speed], x[bias] = p_n[axis], v_n[axis], 0.0
        for moved, doubt in ((place, PRIOR_POSITION_STD), (speed, PRIOR_VELOCITY_STD), (bias, PRIOR_BIAS_STD)):
            for other in range(SIZE):
                P[AT[min(moved, other), max(moved, other)]] = doubt**2 if other == moved else 0.0
    return Belief(tuple(x), tuple(P))


def reset_disturbance(belief: Belief, p_n: Vec3, v_n: Vec3, disturbance_n: Vec3) -> Belief:
    """``belief`` with position, velocity and bias reset, and the disturbance (m/s^2) too."""
    there = reset_position_velocity(belief, p_n, v_n)
    x = list(there.x)
    x[2], x[6], x[10] = disturbance_n
    return Belief(tuple(x), there.P)


def predict_and_update(
    belief: Belief, dt: float, specific_thrust_n: Vec3, gravity: float, p_n: Vec3, v_n: Vec3,
    noise: tuple[float, float], learning: bool,
) -> tuple[Belief, Innovation]:  # fmt: skip
    """``belief`` ``dt`` s later, after a measurement of position (m) and velocity (m/s).

    ``specific_thrust_n``: F, m/s^2. ``noise``: variances of the measurements. ``learning``: False freezes kappa and c.
    """
    told = _STEP(
        dt, *specific_thrust_n, gravity, *p_n, *v_n, *noise, 1.0 if learning else 0.0, *belief.x, *belief.P
    )  # fmt: skip
    end = SIZE + len(UPPER)
    return Belief(told[:SIZE], told[SIZE:end]), Innovation(told[end : end + 6], told[end + 6 :])


def _recorded() -> Function:
    tape = Tape()
    (dt,) = tape.inputs("dt")
    F = tape.inputs("fx", "fy", "fz")
    (g,) = tape.inputs("g")
    measured = tape.inputs("xm", "ym", "zm", "vxm", "vym", "vzm")
    noise_x, noise_v, learn = tape.inputs("rx", "rv", "learn")
    x: list[Scalar] = list(tape.inputs(*(f"x{i}" for i in range(SIZE))))
    upper = tape.inputs(*(f"p{i}_{j}" for i, j in UPPER))
    P: list[list[Scalar]] = [[upper[AT[min(i, j), max(i, j)]] for j in range(SIZE)] for i in range(SIZE)]
    thrust_scale, c = x[THRUST_SCALE], x[DRAG]
    half = dt * dt * 0.5
    # rows of the transition that are not those of the identity: index -> (column, factor)
    rows: dict[int, list[tuple[int, Scalar]]] = {}
    predict_measurement = list(x)
    accelerations = acceleration(
        (thrust_scale * F[0], thrust_scale * F[1], thrust_scale * F[2]), (x[1], x[5], x[9]), g, c, (x[2], x[6], x[10])
    )
    for axis in range(AXES):
        p, v, d, b = range(PER_AXIS * axis, PER_AXIS * axis + 4)
        a = accelerations[axis]
        predict_measurement[p], predict_measurement[v] = x[p] + dt * x[v] + half * a, x[v] + dt * a
        predict_measurement[b] = x[b] * (1.0 - dt * (1.0 / BIAS_TIME))
        rows[p] = [
            (p, 1.0), (v, dt - half * c), (d, half), (THRUST_SCALE, -(half * F[axis])), (DRAG, -(half * x[v]))
        ]  # fmt: skip
        rows[v] = [(v, 1.0 - dt * c), (d, dt), (THRUST_SCALE, -(dt * F[axis])), (DRAG, -(dt * x[v]))]
        rows[b] = [(b, 1.0 - dt * (1.0 / BIAS_TIME))]
    x, P = predict_measurement, _propagated(P, rows)
    for axis in range(AXES):
        noises = (POSITION_Q + (noise_x - POSITION_R_MIN) * POSITION_Q_GAIN, VELOCITY_Q, DISTURBANCE_Q[axis], BIAS_Q)
        for i, noise in enumerate(noises, PER_AXIS * axis):
            P[i][i] = P[i][i] + noise * dt
    P[THRUST_SCALE][THRUST_SCALE] = P[THRUST_SCALE][THRUST_SCALE] + (THRUST_SCALE_Q * dt) * learn
    P[DRAG][DRAG] = P[DRAG][DRAG] + (DRAG_Q * dt) * learn
    innovations: list[Scalar] = []
    variances: list[Scalar] = []
    for axis in range(AXES):
        place = PER_AXIS * axis
        x = _updated(x, P, (place,), measured[axis], noise_x, learn, innovations, variances)
    for axis in range(AXES):
        speed, bias = PER_AXIS * axis + 1, PER_AXIS * axis + 3
        x = _updated(x, P, (speed, bias), measured[3 + axis], noise_v, learn, innovations, variances)
    return tape.function("kalman", [*x, *(P[i][j] for i, j in UPPER), *innovations, *variances])


def _propagated(P: list[list[Scalar]], rows: dict[int, list[tuple[int, Scalar]]]) -> list[list[Scalar]]:
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
    """x after a measurement of the sum of the states ``states``; P is changed in place.

    Joseph's form with gain rows of zero for what is frozen: only the covariance among the frozen stays as it was.
    """
    predict_measurement: Scalar = 0.0
    cross: list[Scalar] = [0.0] * SIZE
    for state in states:
        predict_measurement = predict_measurement + x[state]
        cross = [total + P[i][state] for i, total in enumerate(cross)]
    variance: Scalar = noise
    for state in states:
        variance = variance + cross[state]
    residual = measured - predict_measurement
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
