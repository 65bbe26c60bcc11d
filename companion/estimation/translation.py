"""The translation of a quadrotor, once for everything that reckons with it."""

from __future__ import annotations

from companion.calculus.scalar import Scalar

Scalar3 = tuple[Scalar, Scalar, Scalar]


def acceleration(
    specific_thrust_n: Scalar3, v_n: Scalar3, gravity: Scalar, drag: Scalar, disturbance_n: Scalar3
) -> Scalar3:
    """A = g e3 - F - c V + d, m/s^2, world frame (Eq. 1 of the paper, with linear drag and a disturbance).

    ``specific_thrust_n``: F, m/s^2, the thrust over mass that really acts, along the body's z axis (up is -z).
    ``drag``: c, 1/s. Floats, or symbols of a tape.
    """
    (fx, fy, fz), (vx, vy, vz), (dx, dy, dz) = specific_thrust_n, v_n, disturbance_n
    return dx - fx - drag * vx, dy - fy - drag * vy, gravity + dz - fz - drag * vz
