"""Frames and rotations: NED and FRD, quaternions, Euler angles. Nothing here knows about flying.

World frame ``n``: north, east, down. Body frame ``b``: forward, right, down. Quaternions are ``(w, x, y, z)`` and
rotate body into world: ``v_n = R_nb @ v_b``. Angles are radians. Everything is plain Python floats: a numpy 3-vector
costs more than ten times as much in a control loop.
"""

from __future__ import annotations

import enum
import math

Vec3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix3 = tuple[float, float, float, float, float, float, float, float, float]
"""A 3x3 matrix, row by row: ``(R00, R01, R02, R10, ...)``."""

TWO_PI = 2.0 * math.pi
"""rad."""


def clamped(value: float, low: float, high: float) -> float:
    """``value`` within ``low`` and ``high``; what is no number stays none."""
    return low if value < low else high if value > high else value


def wrap(angle: float) -> float:
    """The same angle in [-pi, pi]."""
    return math.remainder(angle, TWO_PI)


def normalised(q: Quaternion) -> Quaternion:
    """``q`` at unit length. Raises ZeroDivisionError for the zero quaternion."""
    w, x, y, z = q
    k = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return (w * k, x * k, y * k, z * k)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product ``a * b``: the rotation ``b`` first, then ``a``."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse rotation of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def from_rotation_vector(rotation: Vec3) -> Quaternion:
    """The unit quaternion of a turn by ``|rotation|`` radians about ``rotation`` (the exponential map)."""
    x, y, z = rotation
    angle = math.sqrt(x * x + y * y + z * z)
    k = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    return (math.cos(0.5 * angle), k * x, k * y, k * z)


def rotation_matrix(q: Quaternion) -> Matrix3:
    """R_nb of a unit quaternion."""
    w, x, y, z = q
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


def body_z_axis(q: Quaternion) -> Vec3:
    """The body's down axis in the world: the third column of R_nb."""
    w, x, y, z = q
    return (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))


def rotation_from_euler(psi: float, theta: float, phi: float) -> Matrix3:
    """R_nb of yaw psi, pitch theta, roll phi (ZYX): the matrix R of the paper's section II."""
    c_psi, s_psi = math.cos(psi), math.sin(psi)
    c_theta, s_theta = math.cos(theta), math.sin(theta)
    c_phi, s_phi = math.cos(phi), math.sin(phi)
    return (
        c_theta * c_psi, c_psi * s_theta * s_phi - c_phi * s_psi, c_phi * c_psi * s_theta + s_phi * s_psi,
        c_theta * s_psi, s_theta * s_phi * s_psi + c_phi * c_psi, c_phi * s_theta * s_psi - c_psi * s_phi,
        -s_theta, c_theta * s_phi, c_theta * c_phi,
    )  # fmt: skip


def quaternion_from_euler(psi: float, theta: float, phi: float) -> Quaternion:
    """The unit quaternion of yaw psi, pitch theta, roll phi (ZYX)."""
    c1, s1 = math.cos(0.5 * psi), math.sin(0.5 * psi)
    c2, s2 = math.cos(0.5 * theta), math.sin(0.5 * theta)
    c3, s3 = math.cos(0.5 * phi), math.sin(0.5 * phi)
    return (
        c1 * c2 * c3 + s1 * s2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
        c1 * s2 * c3 + s1 * c2 * s3,
        s1 * c2 * c3 - c1 * s2 * s3,
    )


def euler_from_rotation(r: Matrix3) -> Vec3:
    """(psi, theta, phi) of R_nb, with |theta| <= pi/2. At |theta| = pi/2 only psi - phi is determined."""
    return (math.atan2(r[3], r[0]), math.asin(max(-1.0, min(1.0, -r[6]))), math.atan2(r[7], r[8]))


class Heading(enum.Enum):
    """What counts as the heading of a leaning vehicle; of a level one it is all the same.

    ``PROJECTED``: of the forward axis seen from above, the yaw of the ZYX angles; undefined where that axis is
    vertical, and not to be turned by yawing where the thrust axis is level. ``TWIST``: of the forward axis once the
    thrust axis is swung upright the short way, 2 atan2(q_z, q_w); undefined only upside down.
    """

    PROJECTED = "projected"
    TWIST = "twist"

    __hash__ = object.__hash__  # members are the only ones of their kind; Enum's own goes by the name, in Python

    def of(self, r: Matrix3) -> float:
        """rad, clockwise from north seen from above."""
        if self is Heading.TWIST:
            return math.atan2(r[3] - r[1], r[0] + r[4])
        return math.atan2(r[3], r[0])


def tilt(r: Matrix3) -> float:
    """The angle between the body's down axis and the world's: 0 level, pi upside down."""
    return math.acos(max(-1.0, min(1.0, r[8])))


def to_world(r: Matrix3, v_b: Vec3) -> Vec3:
    """v_n = R_nb @ v_b."""
    x, y, z = v_b
    return (r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z)


def to_body(r: Matrix3, v_n: Vec3) -> Vec3:
    """v_b = R_nb^T @ v_n."""
    x, y, z = v_n
    return (r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z)


def upright_error(r: Matrix3) -> tuple[float, float]:
    """The rotation vector about body x and y that turns the body's down axis onto the world's, for small angles.

    Its length is the sine of the tilt; upside down it stays at a quarter turn's.
    """
    # the world's down axis in the body frame is the last row of R_nb; e3 x down = (-y, x, 0)
    x, y, z = r[6], r[7], r[8]
    if z >= 0.0:
        return (-y, x)
    size = math.hypot(x, y)
    return (-y / size, x / size) if size > 1e-9 else (1.0, 0.0)


def turned(r: Matrix3, w_b: Vec3, h: float) -> Matrix3:
    """R_nb after ``h`` s of body rates ``w_b`` (rad/s), to second order in the angle."""
    p, q, w = w_b[0] * h, w_b[1] * h, w_b[2] * h
    xx, yy, zz = 0.5 * p * p, 0.5 * q * q, 0.5 * w * w
    xy, xz, yz = 0.5 * p * q, 0.5 * p * w, 0.5 * q * w
    # I + S + S^2/2, S the matrix of the vector product with the angle
    a, b, c = 1.0 - yy - zz, xy - w, xz + q
    d, e, f = xy + w, 1.0 - xx - zz, yz - p
    g, i, k = xz - q, yz + p, 1.0 - xx - yy
    r0, r1, r2, r3, r4, r5, r6, r7, r8 = r
    return (
        r0 * a + r1 * d + r2 * g, r0 * b + r1 * e + r2 * i, r0 * c + r1 * f + r2 * k,
        r3 * a + r4 * d + r5 * g, r3 * b + r4 * e + r5 * i, r3 * c + r4 * f + r5 * k,
        r6 * a + r7 * d + r8 * g, r6 * b + r7 * e + r8 * i, r6 * c + r7 * f + r8 * k,
    )  # fmt: skip
