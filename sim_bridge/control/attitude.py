"""Attitude -> body rates: PX4's quaternion controller (Brescianini, Hehn, D'Andrea: Nonlinear Quadrocopter Attitude
Control, ETH Zurich 2013), which tilts first and turns the nose second.

The error is a turn about the thrust axis (twist) followed by the shortest tilt (swing); the twist is shortened by the
yaw weight before the whole is turned into rates. The vehicle does not follow what is wanted itself but a critically
damped model of it, which every new attitude moves on (PX4 since June 2026; MC_REF_FF is 0, as by default).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Quaternion, Vec3, conjugate, from_rotation_vector, multiply, normalised

GAINS: Vec3 = (4.0, 4.0, 2.8)  # 1/s, MC_ROLL_P, MC_PITCH_P, MC_YAW_P
YAW_WEIGHT = 0.4  # MC_YAW_WEIGHT
SMOOTHING = 50.0  # rad/s, MC_REF_W_N
RATE_MAX: Vec3 = (math.radians(220.0), math.radians(220.0), math.radians(200.0))  # MC_*RATE_MAX


class AttitudeReference(NamedTuple):
    """The model that is followed: its attitude, and the body rates (rad/s) at which it nears what is wanted."""

    q_nb: Quaternion
    nearing: Vec3 = (0.0, 0.0, 0.0)


def smooth_attitude(model: AttitudeReference, wanted: Quaternion, heading_rate: float, dt: float) -> AttitudeReference:
    """``model`` after ``dt`` s of nearing ``wanted``; a turn about world down (rad/s) it makes without being late."""
    w, *error = multiply(conjugate(model.q_nb), wanted)
    down = _down(model.q_nb)
    twice = math.copysign(2.0, w)
    # the exact solution of e'' = -2 wn e' - wn^2 e
    decay = math.exp(-SMOOTHING * dt)
    near, coast = 1.0 - (1.0 + SMOOTHING * dt) * decay, dt * decay
    pull, keep = SMOOTHING * SMOOTHING * dt * decay, (1.0 - SMOOTHING * dt) * decay
    rows = tuple(zip((twice * e for e in error), model.nearing, down, strict=True))
    x, y, z = (near * e + coast * n + d * heading_rate * dt for e, n, d in rows)
    p, q, r = (pull * e + keep * n for e, n, _ in rows)
    if abs(heading_rate) > 1e-7:  # who turns steadily wants a heading that the vehicle's own follows
        about_down = p * down[0] + q * down[1] + r * down[2]
        p, q, r = p - about_down * down[0], q - about_down * down[1], r - about_down * down[2]
    return AttitudeReference(normalised(multiply(model.q_nb, from_rotation_vector((x, y, z)))), (p, q, r))


def _down(q_nb: Quaternion) -> Vec3:
    """World down, in the body."""
    w, x, y, z = q_nb
    return (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))


def rates_for(q_nb: Quaternion, wanted: Quaternion, heading_rate: float = 0.0) -> Vec3:
    """Body rates (rad/s) that bring the attitude ``q_nb`` to ``wanted``, with a turn about world down fed forward."""
    w, x, y, z = multiply(conjugate(q_nb), wanted)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    level = math.hypot(w, z)
    if level > 1e-6:  # else the thrust axes are opposed: any way round is as short as another
        x, y = (w * x - z * y) / level, (w * y + z * x) / level
    half_twist = YAW_WEIGHT * math.atan2(z, w)
    c, s = math.cos(half_twist), math.sin(half_twist)
    p = 2.0 * GAINS[0] * (c * x + s * y)
    q = 2.0 * GAINS[1] * (c * y - s * x)
    r = 2.0 * GAINS[2] / YAW_WEIGHT * level * s
    if heading_rate != 0.0:
        x, y, z = _down(q_nb)
        p, q, r = p + x * heading_rate, q + y * heading_rate, r + z * heading_rate
    p_most, q_most, r_most = RATE_MAX
    return (max(-p_most, min(p_most, p)), max(-q_most, min(q_most, q)), max(-r_most, min(r_most, r)))
