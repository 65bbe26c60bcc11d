"""Flatness: from the wanted highest derivative of the position and of the heading to thrust and torques, or to rates.

Written with the rotation matrix, so nothing is singular in the translation but zeta = 0 (free fall, where the attitude
has no say). The heading is that of the body's forward axis projected on the ground, which is the paper's psi for
|theta| < 90 deg; or, as an option for steep flight, the twist: what is left of the attitude once the thrust axis is
swung upright the short way.
"""

from __future__ import annotations

from companion.calculus.scalar import Scalar, atan2
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Rotation, Vector
from companion.frames import Heading
from companion.law.motion import Model, Motion


def heading(R: Rotation, kind: Heading) -> Scalar:
    """psi, rad. Projected: undefined where the forward axis is vertical (theta = +-90 deg). Twist: 2 atan2(q_z, q_w),
    undefined upside down."""
    if kind is Heading.TWIST:
        return atan2(R.e1.y - R.e2.x, R.e1.x + R.e2.y)
    return atan2(R.e1.y, R.e1.x)


class HeadingRate:
    """psi_dot d = by_p p + by_q q + by_r r: how body rates turn the heading.

    Projected, from Eq. (2) without Euler angles: d = R00^2 + R10^2 (cos^2 theta), by_p = 0, by_q = R10 R02 - R00 R12,
    by_r = R22. Twist: psi_dot = r + (b_x b_y' - b_y b_x')/(1 + b_z), b being the thrust axis R e3. As b' = w x b in the
    world frame, the bracket is w_z - b_z r = R20 p + R21 q: d = by_r = 1 + R22, by_p = R20, by_q = R21.
    """

    def __init__(self, R: Rotation, kind: Heading) -> None:
        self._R, self._kind = R, kind
        self.by_p, self.by_q, self.by_r, self.d = _coefficients(R, kind)

    def of(self, w: Vector) -> Scalar:
        """psi_dot, rad/s, at body rates w."""
        return (self.by_p * w.x + self.by_q * w.y + self.by_r * w.z) / self.d

    def drift(self, w: Vector) -> Scalar:
        """psi_ddot d - by_p p_dot - by_q q_dot - by_r r_dot: what turns the heading rate without body accelerations."""
        moving = _coefficients(_moving(self._R, self._R.dot(w)), self._kind)
        by_p, by_q, by_r, d = (value.derivative(1) if isinstance(value, Taylor) else 0.0 for value in moving)
        return by_p * w.x + by_q * w.y + by_r * w.z - self.of(w) * d


def _coefficients(R: Rotation, kind: Heading) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    if kind is Heading.TWIST:
        upright = R.e3.z + 1.0
        return R.e1.z, R.e2.z, upright, upright
    return 0.0, R.e1.y * R.e3.x - R.e1.x * R.e3.y, R.e3.z, R.e1.x * R.e1.x + R.e1.y * R.e1.y


def _moving(R: Rotation, R_dot: Rotation) -> Rotation:
    """R as a series in time, to first order."""

    def series(axis: Vector, axis_dot: Vector) -> Vector:
        return Vector(*(Taylor(pair) for pair in zip(axis.components(), axis_dot.components(), strict=True)))

    return Rotation(series(R.e1, R_dot.e1), series(R.e2, R_dot.e2), series(R.e3, R_dot.e3))


def body_acceleration(
    model: Model, motion: Motion, snap: Vector, jerk: Vector, psi_ddot: Scalar, rate: HeadingRate, yaw_divisor: Scalar
) -> tuple[Scalar, Vector]:
    """(zeta_ddot, w_dot) that give the position this snap and the heading this acceleration (level of motors).

    From (zeta b)'' = -m (S + c J), b = R e3. ``rate``: of the heading, at this attitude. ``yaw_divisor`` stands for its
    by_r where that divides, so that a caller can keep it away from zero: then the path is followed exactly and only the
    yaw degrades.
    """
    sigma = motion.R.to_body((snap + jerk * model.c) * -model.m)
    p, q, r = motion.w.components()
    zeta, zeta_dot = motion.zeta, motion.zeta_dot
    zeta_ddot = sigma.z + zeta * (p * p + q * q)
    q_dot = (sigma.x - 2.0 * zeta_dot * q) / zeta - r * p
    p_dot = -(sigma.y + 2.0 * zeta_dot * p) / zeta + r * q
    r_dot = (psi_ddot * rate.d - rate.by_p * p_dot - rate.by_q * q_dot - rate.drift(motion.w)) / yaw_divisor
    return zeta_ddot, Vector(p_dot, q_dot, r_dot)


def torques(model: Model, w: Vector, w_dot: Vector) -> Vector:
    """J w_dot + w x J w (Eq. 2)."""
    J = model.J
    momentum = Vector(J.x * w.x, J.y * w.y, J.z * w.z)
    return Vector(J.x * w_dot.x, J.y * w_dot.y, J.z * w_dot.z) + w.cross(momentum)


def body_rates(
    model: Model, motion: Motion, jerk: Vector, A: Vector, psi_dot: Scalar, rate: HeadingRate, yaw_divisor: Scalar
) -> tuple[Scalar, Vector]:
    """(zeta_dot, w) that give the position this jerk and the heading this rate (level of rates).

    From (zeta b)' = -m (J + c A).
    """
    sigma = motion.R.to_body((jerk + A * model.c) * -model.m)
    q = sigma.x / motion.zeta
    p = -sigma.y / motion.zeta
    r = (psi_dot * rate.d - rate.by_p * p - rate.by_q * q) / yaw_divisor
    return sigma.z, Vector(p, q, r)
