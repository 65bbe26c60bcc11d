"""The Kalman filter of flight: position, velocity, and what the vehicle does not say.

    p' = v      v' = g e3 - kappa F - c v + d      d' = noise      beta' = -beta/2 s + noise      kappa', c' = noise
    measured: X = p, V = v + beta

``F``: the lift asked for, as the motors made it, along the thrust axis (m/s^2), a mean over the step. ``kappa``: the
acceleration made over that asked for (hover thrust, mass, battery). ``c``: drag over mass, which turns with the flight;
``d``: what is left, wind first of all. ``beta``: the reported velocity over the derivative of the reported position: an
estimator that corrects its position does not put the correction into its velocity, and a law that is fed both would fly
(k1/k0) beta beside the path.

The covariance is full, kept as its upper triangle; a step is recorded once and printed as straight-line floats.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.frames import Vec3

PER_AXIS, AXES = 4, 3
KAPPA, DRAG = 12, 13
SIZE = 14
UPPER = tuple((i, j) for i in range(SIZE) for j in range(i, SIZE))
AT = {pair: index for index, pair in enumerate(UPPER)}

BETA_TIME = 2.0
"""s, after which a difference between velocity and moving position has lost its worth."""
NOISE_P, NOISE_V, NOISE_BETA, NOISE_KAPPA, NOISE_DRAG = 1e-6, 1e-3, 3e-3, 1e-5, 1e-4
SMOOTH_X, ROUGH = 1e-3**2, 24.0
"""m^2 and 1/s. A position that is noisier than PX4's own smooth estimate also jolts: its wander is taken for motion of
the position itself, ``ROUGH`` times the excess of its variance a second, and not for velocity."""
NOISE_D: Vec3 = (0.3, 0.3, 0.03)
"""Variance per second. The vertical disturbance is kept slow, because in a hover it is not told from kappa."""
PRIOR_P, PRIOR_V, PRIOR_BETA = 1e-2, 1e-1, 0.07
PRIOR_D: Vec3 = (0.7, 0.7, 0.22)
"""Standard deviations of a first belief."""


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
    def kappa(self) -> float:
        """Acceleration made over lift asked for."""
        return self.x[KAPPA]

    @property
    def drag(self) -> float:
        """1/s."""
        return self.x[DRAG]

    def variance(self, index: int) -> float:
        """Of one number of the state."""
        return self.P[AT[index, index]]


class Surprise(NamedTuple):
    """What the measurements differed by from what was expected (position and velocity of each axis), and the variance
    that was expected of it."""

    innovation: tuple[float, ...]
    variance: tuple[float, ...]


def first_belief(
    p_n: Vec3, v_n: Vec3, disturbance_n: Vec3, kappa: tuple[float, float], drag: tuple[float, float]
) -> Belief:
    """A belief with nothing flown yet. ``kappa``, ``drag``: value and standard deviation."""
    x: list[float] = []
    deviations: list[float] = []
    for p, v, d, doubt in zip(p_n, v_n, disturbance_n, PRIOR_D, strict=True):
        x += [p, v, d, 0.0]
        deviations += [PRIOR_P, PRIOR_V, doubt, PRIOR_BETA]
    x += [kappa[0], drag[0]]
    deviations += [kappa[1], drag[1]]
    return Belief(tuple(x), tuple(deviations[i] ** 2 if i == j else 0.0 for i, j in UPPER))


def seated(belief: Belief, p_n: Vec3, v_n: Vec3) -> Belief:
    """``belief`` put to another place and velocity (an estimator that jumped, a vehicle that was stopped): what is
    known of the forces stays, and owes nothing to the jump."""
    x, P = list(belief.x), list(belief.P)
    for axis in range(AXES):
        place, speed, bias = PER_AXIS * axis, PER_AXIS * axis + 1, PER_AXIS * axis + 3
        x[place], x[speed], x[bias] = p_n[axis], v_n[axis], 0.0
        for moved, doubt in ((place, PRIOR_P), (speed, PRIOR_V), (bias, PRIOR_BETA)):
            for other in range(SIZE):
                P[AT[min(moved, other), max(moved, other)]] = doubt**2 if other == moved else 0.0
    return Belief(tuple(x), tuple(P))


def calmed(belief: Belief, p_n: Vec3, v_n: Vec3, disturbance_n: Vec3) -> Belief:
    """``belief`` seated, its disturbance put back to what it was."""
    there = seated(belief, p_n, v_n)
    x = list(there.x)
    x[2], x[6], x[10] = disturbance_n
    return Belief(tuple(x), there.P)


def stepped(
    belief: Belief, dt: float, lift_n: Vec3, gravity: float, p_n: Vec3, v_n: Vec3,
    noise: tuple[float, float], learning: bool,
) -> tuple[Belief, Surprise]:  # fmt: skip
    """``belief`` ``dt`` s later, after a measurement. ``lift_n``: F. ``noise``: variances of a measured position and
    velocity. ``learning``: False leaves kappa and c as they are."""
    told = _STEP(
        dt, *lift_n, gravity, *p_n, *v_n, *noise, 1.0 if learning else 0.0, *belief.x, *belief.P
    )  # fmt: skip
    end = SIZE + len(UPPER)
    return Belief(told[:SIZE], told[SIZE:end]), Surprise(told[end : end + 6], told[end + 6 :])


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
    kappa, c = x[KAPPA], x[DRAG]
    half = dt * dt * 0.5
    # rows of the transition that are not those of the identity: index -> (column, factor)
    rows: dict[int, list[tuple[int, Scalar]]] = {}
    expected = list(x)
    for axis in range(AXES):
        p, v, d, b = range(PER_AXIS * axis, PER_AXIS * axis + 4)
        a = x[d] - kappa * F[axis] - c * x[v] + (g if axis == 2 else 0.0)
        expected[p], expected[v] = x[p] + dt * x[v] + half * a, x[v] + dt * a
        expected[b] = x[b] * (1.0 - dt * (1.0 / BETA_TIME))
        rows[p] = [
            (p, 1.0), (v, dt - half * c), (d, half), (KAPPA, -(half * F[axis])), (DRAG, -(half * x[v]))
        ]  # fmt: skip
        rows[v] = [(v, 1.0 - dt * c), (d, dt), (KAPPA, -(dt * F[axis])), (DRAG, -(dt * x[v]))]
        rows[b] = [(b, 1.0 - dt * (1.0 / BETA_TIME))]
    x, P = expected, _propagated(P, rows)
    for axis in range(AXES):
        noises = (NOISE_P + (noise_x - SMOOTH_X) * ROUGH, NOISE_V, NOISE_D[axis], NOISE_BETA)
        for i, noise in enumerate(noises, PER_AXIS * axis):
            P[i][i] = P[i][i] + noise * dt
    P[KAPPA][KAPPA] = P[KAPPA][KAPPA] + (NOISE_KAPPA * dt) * learn
    P[DRAG][DRAG] = P[DRAG][DRAG] + (NOISE_DRAG * dt) * learn
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
    x: list[Scalar], P: list[list[Scalar]], seen: tuple[int, ...], measured: Scalar, noise: Scalar, learn: Scalar,
    innovations: list[Scalar], variances: list[Scalar],
) -> list[Scalar]:  # fmt: skip
    """x after a measurement of the sum of the states ``seen``; P is changed in place.

    Joseph's form with gain rows of zero for what is frozen: only the covariance among the frozen stays as it was.
    """
    expected: Scalar = 0.0
    cross: list[Scalar] = [0.0] * SIZE
    for state in seen:
        expected = expected + x[state]
        cross = [total + P[i][state] for i, total in enumerate(cross)]
    variance: Scalar = noise
    for state in seen:
        variance = variance + cross[state]
    innovation = measured - expected
    inverse = 1.0 / variance
    innovations.append(innovation)
    variances.append(variance)
    gains = [value * inverse for value in cross]
    for i, j in UPPER:
        taken = gains[i] * cross[j]
        P[i][j] = P[j][i] = P[i][j] - (taken * learn if i >= KAPPA else taken)
    frozen = (KAPPA, DRAG)
    return [
        value + (gain * innovation) * (learn if i in frozen else 1.0)
        for i, (value, gain) in enumerate(zip(x, gains, strict=True))
    ]


_STEP = _recorded()
