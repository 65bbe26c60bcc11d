"""The motion of a rigid body under its rotors, gravity and drag: Newton and Euler, attitude as a quaternion.

    m v_n' = m g e3 + R_nb sum_i F_i + push - m (c + c2 |u_n|) u_n - m c_r (u_n - b b.u_n)      u_n = v_n - wind_n
    q'     = q * (0, w_b) / 2        J w_b' = sum_i (r_i x F_i + s_i k_i |F_i| e3) - w_b x J w_b - d w_b

summed rotor by rotor; nothing here knows a mixing matrix. b is body z in the world. The derivative is one unrolled
function on floats because it is evaluated four times a step. It is that of the velocity in the air, whose mean moves at
a constant velocity during a step; and it does not depend on the position, which the integrator uses.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from companion.calculus.scalar import Scalar
from companion.frames import Vec3
from companion.vehicle import Vehicle
from companion.world import Deviations
from sim_bridge.rotors import torque_per_newton

F = float
Rates = tuple[F, F, F, F, F, F, F, F, F, F]
"""d/dt of (u_n, q_nb, w_b)."""
Derivative = Callable[[F, F, F, F, F, F, F, F, F, F, F, F, F, F, F, F, F, F], Rates]
"""From (u_n, q_nb, w_b, the four thrusts in N, what else accelerates in m/s^2 NED, what else turns about z in N m) to
Rates. Gravity is among what accelerates."""


@dataclass(frozen=True, slots=True)
class Body:
    """What the equations need to know of a machine."""

    mass: float  # kg
    inertia: Vec3  # kg m^2, the diagonal of J
    gravity: float  # m/s^2
    drag: float  # 1/s
    angular_drag: float  # N m s
    torques_per_newton: tuple[Vec3, Vec3, Vec3, Vec3]  # m, FRD, one a rotor
    rotor_drag: float = 0.0  # 1/s
    quadratic_drag: float = 0.0  # 1/m


def true_vehicle(vehicle: Vehicle, truth: Deviations) -> Vehicle:
    """The vehicle as it really is: ``vehicle`` with what ``truth`` says otherwise."""
    return replace(
        vehicle,
        mass=vehicle.mass if truth.mass is None else truth.mass,
        inertia=vehicle.inertia if truth.inertia is None else truth.inertia,
        motor_lag=vehicle.motor_lag if truth.motor_lag is None else truth.motor_lag,
        drag=vehicle.drag if truth.drag is None else truth.drag,
        rotors=tuple(replace(rotor, thrust_max=rotor.thrust_max * truth.thrust_scale) for rotor in vehicle.rotors),
    )


def body_of(vehicle: Vehicle, truth: Deviations = Deviations()) -> Body:  # noqa: B008  frozen
    """The Body of a vehicle with four rotors. ValueError: it has another number of them.

    Where the rotors' own motion is told, their reaction is the motors' torque, which does not go with the thrust.
    """
    if len(vehicle.rotors) != 4:
        raise ValueError(f"{vehicle.name} has {len(vehicle.rotors)} rotors; the plant flies quadrotors")
    torques = [torque_per_newton(rotor) for rotor in vehicle.rotors]
    if truth.rotors is not None:
        torques = [(x, y, 0.0) for x, y, _ in torques]
    t0, t1, t2, t3 = torques
    return Body(
        vehicle.mass, vehicle.inertia, vehicle.gravity, vehicle.drag, truth.angular_drag, (t0, t1, t2, t3),
        truth.rotor_drag, truth.quadratic_drag,
    )  # fmt: skip


def derivative_of(body: Body, sqrt: Callable[[Scalar], Scalar] = math.sqrt) -> Derivative:
    """The derivative of a body's motion. ``sqrt``: of the numbers it is made of, floats or symbols of a tape."""
    (l0, m0, n0), (l1, m1, n1), (l2, m2, n2), (l3, m3, n3) = body.torques_per_newton
    jx, jy, jz = body.inertia
    per_mass, per_jx, per_jy, per_jz = 1.0 / body.mass, 1.0 / jx, 1.0 / jy, 1.0 / jz
    turn_x, turn_y, turn_z = (jy - jz) / jx, (jz - jx) / jy, (jx - jy) / jz
    c, d = body.drag, body.angular_drag
    c_r, c_2 = body.rotor_drag, body.quadratic_drag

    def derivative(
        un: F, ue: F, ud: F, qw: F, qx: F, qy: F, qz: F, p: F, q: F, r: F,
        f0: F, f1: F, f2: F, f3: F, an: F, ae: F, ad: F, turn: F,
    ) -> Rates:  # fmt: skip
        lift = -2.0 * per_mass * (f0 + f1 + f2 + f3)  # twice, for the third column of R_nb is 2 (..)
        return (
            lift * (qx * qz + qw * qy) - c * un + an,
            lift * (qy * qz - qw * qx) - c * ue + ae,
            lift * (0.5 - qx * qx - qy * qy) - c * ud + ad,
            -0.5 * (qx * p + qy * q + qz * r),
            0.5 * (qw * p + qy * r - qz * q),
            0.5 * (qw * q + qz * p - qx * r),
            0.5 * (qw * r + qx * q - qy * p),
            turn_x * q * r + per_jx * (l0 * f0 + l1 * f1 + l2 * f2 + l3 * f3 - d * p),
            turn_y * p * r + per_jy * (m0 * f0 + m1 * f1 + m2 * f2 + m3 * f3 - d * q),
            turn_z * p * q + per_jz * (n0 * f0 + n1 * f1 + n2 * f2 + n3 * f3 - d * r + turn),
        )

    def with_more_drag(
        un: F, ue: F, ud: F, qw: F, qx: F, qy: F, qz: F, p: F, q: F, r: F,
        f0: F, f1: F, f2: F, f3: F, an: F, ae: F, ad: F, turn: F,
    ) -> Rates:  # fmt: skip
        bn, be, bd = 2.0 * (qx * qz + qw * qy), 2.0 * (qy * qz - qw * qx), 1.0 - 2.0 * (qx * qx + qy * qy)
        along = c_r * (bn * un + be * ue + bd * ud)
        k = c_r + c_2 * sqrt(un * un + ue * ue + ud * ud)
        return derivative(
            un, ue, ud, qw, qx, qy, qz, p, q, r, f0, f1, f2, f3,
            an - k * un + along * bn, ae - k * ue + along * be, ad - k * ud + along * bd, turn,
        )  # fmt: skip

    return derivative if c_r == c_2 == 0.0 else with_more_drag
