"""The vehicle's motion as the law knows it: acceleration and jerk from attitude, rates and thrust (Eqs. 1, 2, 4)."""

from __future__ import annotations

from dataclasses import dataclass

from companion.calculus.scalar import Scalar
from companion.calculus.vectors import E3, Rotation, Vector


@dataclass(frozen=True, slots=True)
class Model:
    """What the law believes of the vehicle: m kg, J (diagonal) kg m^2, g m/s^2, linear drag over mass c 1/s."""

    m: Scalar
    J: Vector
    g: Scalar
    c: Scalar = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """The extended state chi, in the world frame but for the body rates. At the level of rates ``w`` and ``zeta_dot``
    are inputs and not used."""

    X: Vector  # m
    V: Vector  # m/s
    R: Rotation  # R_nb
    w: Vector  # rad/s, body
    zeta: Scalar  # N, thrust along -R e3
    zeta_dot: Scalar  # N/s
    disturbance: Vector  # m/s^2, an acceleration beyond the model


def acceleration(model: Model, motion: Motion) -> Vector:
    """A = g e3 - (zeta/m) R e3 + d - c V. Eq. (1) with linear drag and a disturbance: the paper has neither."""
    A: Vector = E3 * model.g - motion.R.e3 * (motion.zeta / model.m) + motion.disturbance - motion.V * model.c
    return A


def jerk(model: Model, motion: Motion, A: Vector) -> Vector:
    """J = -(zeta_dot R e3 + zeta R (q, -p, 0))/m - c A: Eq. (1) differentiated once."""
    b_dot = motion.R.dot(motion.w).e3
    J: Vector = -(motion.R.e3 * motion.zeta_dot + b_dot * motion.zeta) / model.m - A * model.c
    return J
