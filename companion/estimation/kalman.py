"""The Kalman filter of flight: position, velocity, what the vehicle does not say, and how its own estimate wanders.

Of each axis, and of the vehicle:

    P' = V + U                       P: the reported position              U' = -U / 0.5 s + noise
    V' = g e3 - k (F - E e3 x F) - c V + D + W                          B' = -B / 3.5 s + noise
    measured:  P and V + B           D: slow disturbance, W: gusts         W' = -W / 1 s + noise
    k' = c' = noise                  D' = noise (level), -D / 10 s + noise (vertical)
                                 E: the heading's error                 E' = -E / 3.2 s + noise

``F``: the commanded thrust over mass, lagged by the motors, along the thrust axis (m/s^2), a mean over the step.
``k``: the thrust scale, thrust made over thrust commanded (hover thrust, mass, battery). ``c``: drag over mass.

``U`` and ``B`` are the errors of the vehicle's own estimator (an EKF), as velocities: the reported position wanders
about the true one at U, smoothly and back again; the reported velocity is wrong by B. Both are coloured. A filter that
takes them for white (or the wander for motion that stays) is biased in a closed loop: the controller pushes the
reported position back to the path while its error returns by itself, so that thrust and drag seem to do more than they
do. On a recorded circle such a filter came to 1.4 times the thrust scale and drag in a minute and believed it.

In level flight k is hardly told from a vertical disturbance. What tells them apart is physics: air seldom pushes
a quadrotor up or down for long. So the vertical D is a process with a small stationary deviation, and what the
horizontals do not say goes to k. The level D also takes the tilt error of the vehicle's estimate, g times it, which
is not told from a steady wind and acts like one. The error E of the reported heading turns the thrust that leans: on a
circle that stays along the motion or against it, and would be taken for drag (0.02 1/s a degree at 5 m/s on 5 m). Each
axis has an E of its own, so that the axes stay apart.

The covariance is full, kept in parts by what the axes have in common; a step is recorded once and printed as
straight-line floats.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from companion.calculus import machine_code
from companion.calculus.machine_code import PackedNumbers, packed, unpacked
from companion.calculus.scalar import Scalar
from companion.estimation.kalman_step import (
    AT,
    AXES,
    DIAGONAL,
    DISTURBANCE,
    DOWN,
    DRAG,
    DRAG_Q,
    EAST,
    GUST,
    HEADING_ERROR,
    NORTH,
    PER_AXIS,
    POSITION,
    SIZE,
    THRUST_SCALE,
    THRUST_SCALE_Q,
    UPPER,
    VELOCITY,
    VELOCITY_ERROR,
    WANDER,
    step_of,
)
from companion.estimation.noise_levels import NoiseLevels
from companion.frames import Vec3

PRIOR_POSITION_STD = 1e-3
"""m. The reported position is what is followed, whatever the true one. Engineering choice."""
PRIOR_DISTURBANCE_STD: Vec3 = (1.5, 1.5, 0.05)
"""m/s^2. Engineering choice: a wind of 5 m/s on a vehicle with a third of the drag of PX4's simulated one; vertical the
stationary deviation."""


class Belief(NamedTuple):
    """``x``: (P, V, U, B, D, W, E) of each axis, k, c. Its covariance in three parts (see ``kalman_step``): ``S``,
    of each axis given k and c, an upper triangle row by row; ``G``, each axis over k and c, row by row; ``T``,
    of k and c. ``by_lag``: what x would be more, over seconds that the motors' lag is more; ``by_curve``: over what the
    thrust curve is more."""

    x: tuple[float, ...]
    S: PackedNumbers
    G: PackedNumbers
    T: tuple[float, float, float]
    by_lag: PackedNumbers = (0.0,) * SIZE
    by_curve: PackedNumbers = (0.0,) * SIZE

    @property
    def p_n(self) -> Vec3:
        """m, the reported position."""
        x = self.x
        return (x[NORTH + POSITION], x[EAST + POSITION], x[DOWN + POSITION])

    @property
    def v_n(self) -> Vec3:
        """m/s, the derivative of the reported position: V + U."""
        x = self.x
        return (
            x[NORTH + VELOCITY] + x[NORTH + WANDER],
            x[EAST + VELOCITY] + x[EAST + WANDER],
            x[DOWN + VELOCITY] + x[DOWN + WANDER],
        )

    @property
    def disturbance_n(self) -> Vec3:
        """m/s^2: D + W."""
        x = self.x
        return (
            x[NORTH + DISTURBANCE] + x[NORTH + GUST],
            x[EAST + DISTURBANCE] + x[EAST + GUST],
            x[DOWN + DISTURBANCE] + x[DOWN + GUST],
        )

    def apparent_disturbance_n(self, specific_thrust_n: Vec3) -> Vec3:
        """m/s^2, what acts on the reported motion beside thrust as reported and the drag of its velocity V + U: D + W +
        c U, and what the heading's error makes of the thrust. ``specific_thrust_n``: F, m/s^2."""
        (a, b, c), x, drag, scale = self.disturbance_n, self.x, self.x[DRAG], self.x[THRUST_SCALE]
        fx, fy, _ = specific_thrust_n
        return (
            a + drag * x[NORTH + WANDER] - scale * fy * x[NORTH + HEADING_ERROR],
            b + drag * x[EAST + WANDER] + scale * fx * x[EAST + HEADING_ERROR],
            c + drag * x[DOWN + WANDER],
        )

    @property
    def bias_n(self) -> Vec3:
        """m/s, the reported velocity minus the derivative of the reported position: B - U."""
        x = self.x
        return (
            x[NORTH + VELOCITY_ERROR] - x[NORTH + WANDER],
            x[EAST + VELOCITY_ERROR] - x[EAST + WANDER],
            x[DOWN + VELOCITY_ERROR] - x[DOWN + WANDER],
        )

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
        if index >= THRUST_SCALE:
            return self.T[0] if index == THRUST_SCALE else self.T[2]
        variance: float = variance_of(index, unpacked(self.S), unpacked(self.G), self.T)
        return variance

    def covariance(self) -> list[list[float]]:
        """Of the whole state, SIZE x SIZE; for who looks at it, not for the filter."""
        kk, kc, cc = self.T
        S, G = unpacked(self.S), unpacked(self.G)
        slopes = [*zip(G[::2], G[1::2], strict=True), (1.0, 0.0), (0.0, 1.0)]
        P = [[a * (kk * d + kc * e) + b * (kc * d + cc * e) for d, e in slopes] for a, b in slopes]
        for axis in range(AXES):
            for (i, j), value in zip(UPPER, S[len(UPPER) * axis :], strict=False):
                row, column = PER_AXIS * axis + i, PER_AXIS * axis + j
                P[row][column] += value
                if row != column:
                    P[column][row] += value
        return P


def variance_of(index: int, S: Sequence[Scalar], G: Sequence[Scalar], T: Sequence[Scalar]) -> Scalar:
    """Of one number of an axis, from the parts of the covariance. Floats, or symbols of a tape."""
    (kk, kc, cc), k, c = T, G[2 * index], G[2 * index + 1]
    return S[DIAGONAL[index]] + (k * k * kk + 2.0 * k * c * kc + c * c * cc)


class Innovation(NamedTuple):
    """``residual``: measured minus predicted position (m) and velocity (m/s) of each axis, one after the other.
    ``variance``: as predicted. ``by_lag``: what the residual would be more, over s of lag; ``by_curve``: over the
    thrust curve."""

    residual: tuple[float, ...]
    variance: tuple[float, ...]
    by_lag: tuple[float, ...]
    by_curve: tuple[float, ...] = (0.0,) * (2 * AXES)


def initial_belief(
    p_n: Vec3, v_n: Vec3, disturbance_n: Vec3, thrust_scale: tuple[float, float], drag: tuple[float, float],
    noise: NoiseLevels,
) -> Belief:  # fmt: skip
    """Before the first update. ``thrust_scale``, ``drag`` (1/s): value and standard deviation."""
    x, S = [0.0] * SIZE, [0.0] * (AXES * len(UPPER))
    for axis in range(AXES):
        at = PER_AXIS * axis
        x[at + DISTURBANCE] = disturbance_n[axis]
        S[DIAGONAL[at + DISTURBANCE]] = PRIOR_DISTURBANCE_STD[axis] ** 2
        if at == DOWN:  # the thrust of a hover leans by as much as the disturbance is level
            S[DIAGONAL[at + DISTURBANCE]] += noise.tilt_error * (disturbance_n[0] ** 2 + disturbance_n[1] ** 2)
        S[DIAGONAL[at + GUST]] = noise.gust[axis]
        S[DIAGONAL[at + HEADING_ERROR]] = noise.heading_error
    x[THRUST_SCALE], x[DRAG] = thrust_scale[0], drag[0]
    T = (thrust_scale[1] ** 2, 0.0, drag[1] ** 2)
    return reset_position_velocity(Belief(tuple(x), tuple(S), (0.0,) * (2 * AXES * PER_AXIS), T), p_n, v_n, noise)


def reset_position_velocity(belief: Belief, p_n: Vec3, v_n: Vec3, noise: NoiseLevels) -> Belief:
    """``belief`` with position and velocity reset to what is reported (m, m/s), their errors to none, and their
    cross-covariances with all else zeroed, as after a jump of the vehicle's own estimate; what is known of the forces
    stays."""
    x, T = list(belief.x), belief.T
    S, G, by_lag, by_curve = (list(unpacked(part)) for part in (belief.S, belief.G, belief.by_lag, belief.by_curve))
    for axis in range(AXES):
        at, first = PER_AXIS * axis, len(UPPER) * axis
        u, b = noise.wander[axis], noise.velocity_error[axis]
        x[at : at + 4] = p_n[axis], v_n[axis], 0.0, 0.0
        by_lag[at : at + 4] = by_curve[at : at + 4] = (0.0,) * 4
        G[2 * at : 2 * (at + 4)] = (0.0,) * 8
        for moved, variance in enumerate((PRIOR_POSITION_STD**2, b + noise.velocity, u, b)):
            for other in range(PER_AXIS):
                S[first + AT[min(moved, other), max(moved, other)]] = variance if other == moved else 0.0
        S[first + AT[VELOCITY, VELOCITY_ERROR]] = -b
    return Belief(tuple(x), packed(S), packed(G), T, packed(by_lag), packed(by_curve))


def reset_disturbance(belief: Belief, p_n: Vec3, v_n: Vec3, disturbance_n: Vec3, noise: NoiseLevels) -> Belief:
    """``belief`` with position and velocity reset, and the disturbance (m/s^2) too."""
    there = reset_position_velocity(belief, p_n, v_n, noise)
    x = list(there.x)
    for axis in range(AXES):
        at = PER_AXIS * axis
        x[at + GUST] = disturbance_n[axis] - x[at + DISTURBANCE]
    return there._replace(x=tuple(x))


def predict_and_update(
    belief: Belief, dt: float, specific_thrust_n: Vec3, gravity: float, p_n: Vec3, v_n: Vec3,
    noise: NoiseLevels, learning: bool, thrust_scale_q: float = THRUST_SCALE_Q, drag_q: float = DRAG_Q,
    thrust_by_lag_n: Vec3 = (0.0, 0.0, 0.0), thrust_by_curve_n: Vec3 = (0.0, 0.0, 0.0),
) -> tuple[Belief, Innovation]:  # fmt: skip
    """``belief`` ``dt`` s later, after a measurement of position (m) and velocity (m/s).

    ``specific_thrust_n``: F, m/s^2. ``learning``: False freezes k and c. ``thrust_scale_q``: 1/s, ``drag_q``:
    1/s^3, process noise of k and of c. ``thrust_by_lag_n``: dF/dL, m/s^3; ``thrust_by_curve_n``: dF/db, m/s^2.
    """
    x, S, G, T, by_lag, by_curve, *seen = step_of(learning, machine_code.in_use)(
        dt, specific_thrust_n, gravity, p_n, v_n, *noise, thrust_scale_q, drag_q, thrust_by_lag_n, thrust_by_curve_n,
        *belief,
    )  # fmt: skip
    return Belief(x, S, G, T, by_lag, by_curve), Innovation(*seen)
