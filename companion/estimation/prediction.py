"""Where the vehicle will be when a command acts."""

from __future__ import annotations

from companion.frames import Vec3, from_rotation_vector, multiply
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
