"""The law as the paper writes it: xi, b, D of the extended system and u = D^-1 (-b + v) (Eqs. 8 and 9).

This form is for the reader, for ``companion law`` and for the tests. What flies is the factored form (``feedback`` and
``flatness``), which needs no 4x4 matrix; the two are equal to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.calculus.scalar import Scalar
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Vector
from companion.law.flatness import HeadingRate
from companion.law.gains import Gains, Level
from companion.law.implicit import Specification, outputs
from companion.law.motion import Model, Motion, acceleration, jerk


@dataclass(frozen=True, slots=True)
class Linearisation:
    """``xi``: the outputs and their derivatives below the relative degree, output after output (13 or 9 numbers).
    ``b``: L_f^r h, 4 numbers. ``D``: the decoupling matrix, 4 rows of 4. ``gradients``: grad h1, grad h2."""

    xi: tuple[Scalar, ...]
    b: tuple[Scalar, Scalar, Scalar, Scalar]
    D: tuple[tuple[Scalar, Scalar, Scalar, Scalar], ...]
    gradients: tuple[Vector, Vector]


def linearise(specification: Specification, level: Level, model: Model, motion: Motion, psi: Scalar) -> Linearisation:
    """xi, b and D at a state. ``psi``: the heading, as the caller counts it; h4 = psi - beta is not wrapped.

    The inputs are (zeta_ddot, u2, u3, u4) at the level of motors, Lemma 4.1; (zeta_dot, p, q, r) at that of rates.
    """
    m, zeta, R = model.m, motion.zeta, motion.R
    A = acceleration(model, motion)
    rate = HeadingRate(R, specification.heading)
    unit = Taylor((1.0, *(0.0 for _ in range(level.value))))
    by_thrust = -R.e3 / m  # the unknown derivative of the position, per unit of zeta's highest derivative
    by_roll = R.e2 * (zeta / m)  # ... of body acceleration (or rate) p
    by_pitch = -R.e1 * (zeta / m)  # ... q; r does not move the vehicle
    if level is Level.MOTORS:
        known = outputs(specification, (motion.X, motion.V, A, jerk(model, motion, A)), unit)
        w = motion.w
        p, q, r = w.components()
        J = model.J
        momentum = Vector(J.x * p, J.y * q, J.z * r)
        free = -w.cross(momentum)
        w_dot = Vector(free.x / J.x, free.y / J.y, free.z / J.z)  # with no torque
        b_dot = R.dot(w).e3
        b_ddot = R.to_world(Vector(r * p + w_dot.y, r * q - w_dot.x, -p * p - q * q))
        drift = -(b_dot * (2.0 * motion.zeta_dot) + b_ddot * zeta) / m - jerk(model, motion, A) * model.c
        psi_dot = rate.of(w)
        psi_drift = (rate.drift(w) + rate.by_p * w_dot.x + rate.by_q * w_dot.y + rate.by_r * w_dot.z) / rate.d
        columns = (by_thrust, by_roll / J.x, by_pitch / J.y)
        yaw_row = (0.0, rate.by_p / (J.x * rate.d), rate.by_q / (J.y * rate.d), rate.by_r / (J.z * rate.d))
        xi4: tuple[Scalar, ...] = (psi - known.beta.derivative(0), psi_dot - known.beta.derivative(1))
    else:
        known = outputs(specification, (motion.X, motion.V, A), unit)
        drift = A * -model.c
        psi_drift = 0.0
        columns = (by_thrust, by_roll, by_pitch)
        yaw_row = (0.0, rate.by_p / rate.d, rate.by_q / rate.d, rate.by_r / rate.d)
        xi4 = (psi - known.beta.derivative(0),)
    n1, _, n3, n4 = level.degrees
    xi = (
        *(known.h1.derivative(k) for k in range(n1)),
        *(known.h2.derivative(k) for k in range(n1)),
        *(known.h3.derivative(k) for k in range(n3)),
        *xi4,
    )
    b = (
        known.h1.derivative(n1) + known.grad1 @ drift,
        known.h2.derivative(n1) + known.grad2 @ drift,
        known.h3.derivative(n3) + known.mu @ drift,
        psi_drift - known.beta.derivative(n4),
    )
    rows = (known.grad1, known.grad2, known.mu)
    c1, c2, c3 = columns
    D = (*((row @ c1, row @ c2, row @ c3, 0.0) for row in rows), yaw_row)
    return Linearisation(xi, b, D, (known.grad1, known.grad2))


def linear_feedback(gains: Gains, xi: Sequence[float]) -> tuple[float, float, float, float]:
    """v_i = -k_0 xi_1^i - ... - k_{r_i-1} xi_{r_i}^i (Eq. 9)."""
    v = []
    at = 0
    for k in gains.each:
        v.append(-sum(gain * value for gain, value in zip(k, xi[at : at + len(k)], strict=True)))
        at += len(k)
    return (v[0], v[1], v[2], v[3])


def solve(D: Sequence[Sequence[float]], b: Sequence[float], v: Sequence[float]) -> tuple[float, ...]:
    """u = D^-1 (-b + v) (Eq. 8). numpy.linalg.LinAlgError: D is singular."""
    return tuple(float(u) for u in np.linalg.solve(np.array(D), np.array(v) - np.array(b)))
