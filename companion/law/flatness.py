"""Flatness: from the wanted highest derivative of the position and of the heading to thrust and torques, or to rates.

Written with the rotation matrix, so nothing is singular in the translation but zeta = 0 (free fall, where the attitude
has no say). The heading is that of the body's forward axis projected on the ground, which is the paper's psi for
|theta| < 90 deg.
"""

from __future__ import annotations

from companion.calculus.scalar import Scalar, atan2
from companion.calculus.vectors import Rotation, Vector
from companion.law.motion import Model, Motion


def heading(R: Rotation) -> Scalar:
    """psi, rad, of the projected forward axis. Undefined where that axis is vertical (theta = +-90 deg)."""
    return atan2(R.e1.y, R.e1.x)


class HeadingRate:
    """psi_dot d = a q + c r: how body rates turn the heading.

    d = R00^2 + R10^2 (cos^2 theta), c = R22, a = R10 R02 - R00 R12, from Eq. (2) without Euler angles.
    """

    def __init__(self, R: Rotation) -> None:
        self.d = R.e1.x * R.e1.x + R.e1.y * R.e1.y
        self.c = R.e3.z
        self.a = R.e1.y * R.e3.x - R.e1.x * R.e3.y

    def of(self, w: Vector) -> Scalar:
        """psi_dot, rad/s, at body rates w."""
        return (self.a * w.y + self.c * w.z) / self.d

    def drift(self, R: Rotation, w: Vector) -> Scalar:
        """psi_ddot d - a q_dot - c r_dot: what turns the heading rate while the body accelerations are zero."""
        R_dot = R.dot(w)
        d_dot = 2.0 * (R.e1.x * R_dot.e1.x + R.e1.y * R_dot.e1.y)
        a_dot = R_dot.e1.y * R.e3.x + R.e1.y * R_dot.e3.x - R_dot.e1.x * R.e3.y - R.e1.x * R_dot.e3.y
        return a_dot * w.y + R_dot.e3.z * w.z - self.of(w) * d_dot


def body_acceleration(
    model: Model, motion: Motion, snap: Vector, jerk: Vector, psi_ddot: Scalar, yaw_divisor: Scalar
) -> tuple[Scalar, Vector]:
    """(zeta_ddot, w_dot) that give the position this snap and the heading this acceleration (level of motors).

    From (zeta b)'' = -m (S + c J), b = R e3. ``yaw_divisor`` stands for R22 where it divides, so that a caller can keep
    it away from zero: then the path is followed exactly and only the yaw degrades.
    """
    sigma = motion.R.to_body((snap + jerk * model.c) * -model.m)
    p, q, r = motion.w.components()
    zeta, zeta_dot = motion.zeta, motion.zeta_dot
    zeta_ddot = sigma.z + zeta * (p * p + q * q)
    q_dot = (sigma.x - 2.0 * zeta_dot * q) / zeta - r * p
    p_dot = -(sigma.y + 2.0 * zeta_dot * p) / zeta + r * q
    rate = HeadingRate(motion.R)
    r_dot = (psi_ddot * rate.d - rate.a * q_dot - rate.drift(motion.R, motion.w)) / yaw_divisor
    return zeta_ddot, Vector(p_dot, q_dot, r_dot)


def torques(model: Model, w: Vector, w_dot: Vector) -> Vector:
    """J w_dot + w x J w (Eq. 2)."""
    J = model.J
    momentum = Vector(J.x * w.x, J.y * w.y, J.z * w.z)
    return Vector(J.x * w_dot.x, J.y * w_dot.y, J.z * w_dot.z) + w.cross(momentum)


def body_rates(
    model: Model, motion: Motion, jerk: Vector, A: Vector, psi_dot: Scalar, yaw_divisor: Scalar
) -> tuple[Scalar, Vector]:
    """(zeta_dot, w) that give the position this jerk and the heading this rate (level of rates).

    From (zeta b)' = -m (J + c A).
    """
    sigma = motion.R.to_body((jerk + A * model.c) * -model.m)
    q = sigma.x / motion.zeta
    p = -sigma.y / motion.zeta
    rate = HeadingRate(motion.R)
    r = (psi_dot * rate.d - rate.a * q) / yaw_divisor
    return sigma.z, Vector(p, q, r)
