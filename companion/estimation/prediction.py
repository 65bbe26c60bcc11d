"""Where the vehicle will be when a command acts."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.response import (
    STEP,
    YAW_LAG,
    YAW_TORQUE_LAG,
    Inner,
    Response,
    Sent,
    axis_step,
    lift_step,
)
from companion.frames import Quaternion, Vec3, from_rotation_vector, multiply, normalised
from companion.vehicle import VehicleState


def advanced(state: VehicleState, a_n: Vec3, w_dot_b: Vec3, h: float) -> VehicleState:
    """``state`` after ``h`` s of acceleration (m/s^2, world) and body acceleration (rad/s^2), to second order in h."""
    (x, y, z), (vx, vy, vz), (p, q, r) = state.p_n, state.v_n, state.w_b
    ax, ay, az = a_n
    p_dot, q_dot, r_dot = w_dot_b
    half = 0.5 * h
    turned = from_rotation_vector(
        (h * (p + half * p_dot), h * (q + half * q_dot), h * (r + half * r_dot)),
    )
    return VehicleState(
        state.t_boot + h,
        (x + h * (vx + half * ax), y + h * (vy + half * ay), z + h * (vz + half * az)),
        (vx + h * ax, vy + h * ay, vz + h * az),
        multiply(state.q_nb, turned),
        (p + h * p_dot, q + h * q_dot, r + h * r_dot),
        state.resets,
    )


class Known(NamedTuple):
    """What is known of the forces: ``scale``: acceleration made over lift asked for; ``drag`` 1/s; ``disturbance_n``
    and ``gravity`` m/s^2."""

    scale: float
    drag: float
    disturbance_n: Vec3
    gravity: float


class Ahead(NamedTuple):
    """A predicted state: m, m/s, attitude, rad/s."""

    p_n: Vec3
    v_n: Vec3
    q_nb: Quaternion
    w_b: Vec3


def predicted(
    p_n: Vec3, v_n: Vec3, q_nb: Quaternion, inner: Inner, known: Known, response: Response,
    sent: tuple[Sent, ...], begin: float, horizon: float,
) -> Ahead:  # fmt: skip
    """Where the vehicle is ``horizon`` s after ``begin``, under the commands already sent and the last of them held."""
    steps = max(1, math.ceil(horizon / STEP - 1e-9))
    h = round(horizon / steps, 6)
    half = 0.5 * h
    yy, yd, dy, dd, ay, ad = axis_step(response.lag, response.motor_lag, h)
    zz, zd, ez, ed, az, bz = axis_step(YAW_LAG, YAW_TORQUE_LAG, h)
    left, mean = lift_step(response.motor_lag, h)
    (x, y, z), (vx, vy, vz) = p_n, v_n
    qw, qx, qy, qz = q_nb
    (wp, wq, wr), (pd, qd, rd), f, trim = inner
    scale, c, (dx, dy_n, dz), g = known
    last = len(sent) - 1
    i = 0
    bx, by, bz_n = 2.0 * (qx * qz + qw * qy), 2.0 * (qy * qz - qw * qx), 1.0 - 2.0 * (qx * qx + qy * qy)
    t = begin + half
    for _ in range(steps):
        while i < last and sent[i + 1].at <= t:
            i += 1
        _, (sp, sq, sr), lift = sent[i]
        sr += trim
        yp, yq, yr = wp - sp, wq - sq, wr - sr
        # half the angles turned in this step, each axis by its own loop
        hp, hq, hr = (
            0.5 * (sp * h + ay * yp + ad * pd),
            0.5 * (sq * h + ay * yq + ad * qd),
            0.5 * (sr * h + az * yr + bz * rd),
        )
        wp, pd = sp + yy * yp + yd * pd, dy * yp + dd * pd
        wq, qd = sq + yy * yq + yd * qd, dy * yq + dd * qd
        wr, rd = sr + zz * yr + zd * rd, ez * yr + ed * rd
        turn2 = hp * hp + hq * hq + hr * hr
        cw, sw = 1.0 - 0.5 * turn2, 1.0 - turn2 / 6.0
        hp, hq, hr = hp * sw, hq * sw, hr * sw
        qw, qx, qy, qz = (
            qw * cw - qx * hp - qy * hq - qz * hr,
            qx * cw + qw * hp + qy * hr - qz * hq,
            qy * cw + qw * hq - qx * hr + qz * hp,
            qz * cw + qw * hr + qx * hq - qy * hp,
        )
        ox, oy, oz = bx, by, bz_n
        bx, by, bz_n = 2.0 * (qx * qz + qw * qy), 2.0 * (qy * qz - qw * qx), 1.0 - 2.0 * (qx * qx + qy * qy)
        pull = 0.5 * scale * (lift + mean * (f - lift))
        f = lift + left * (f - lift)
        # without drag; then drag on the velocity in the middle of the step
        ax, ay_n, az_n = dx - pull * (ox + bx), dy_n - pull * (oy + by), g + dz - pull * (oz + bz_n)
        ax -= c * (vx + half * (ax - c * vx))
        ay_n -= c * (vy + half * (ay_n - c * vy))
        az_n -= c * (vz + half * (az_n - c * vz))
        x, y, z = x + h * (vx + half * ax), y + h * (vy + half * ay_n), z + h * (vz + half * az_n)
        vx, vy, vz = vx + h * ax, vy + h * ay_n, vz + h * az_n
        t += h
    return Ahead((x, y, z), (vx, vy, vz), normalised((qw, qx, qy, qz)), (wp, wq, wr))
