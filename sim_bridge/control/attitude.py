"""Attitude -> body rates: PX4's quaternion controller (Brescianini, Hehn, D'Andrea: Nonlinear Quadrocopter Attitude
Control, ETH Zurich 2013), which tilts first and turns the nose second.

The error is a turn about the thrust axis (twist) followed by the shortest tilt (swing); the twist is shortened by the
yaw weight before the whole is turned into rates.
"""

from __future__ import annotations

import math

from companion.frames import Quaternion, Vec3, conjugate, multiply

GAINS: Vec3 = (4.0, 4.0, 2.8)  # 1/s, MC_ROLL_P, MC_PITCH_P, MC_YAW_P
YAW_WEIGHT = 0.4  # MC_YAW_WEIGHT
RATE_MAX: Vec3 = (math.radians(220.0), math.radians(220.0), math.radians(200.0))  # MC_*RATE_MAX


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
        w, x, y, z = q_nb
        p += 2.0 * (x * z - w * y) * heading_rate
        q += 2.0 * (y * z + w * x) * heading_rate
        r += (1.0 - 2.0 * (x * x + y * y)) * heading_rate
    p_most, q_most, r_most = RATE_MAX
    return (max(-p_most, min(p_most, p)), max(-q_most, min(q_most, q)), max(-r_most, min(r_most, r)))
