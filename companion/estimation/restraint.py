"""Whether something holds the vehicle: it stands still, and the forces on it say that it should not."""

from __future__ import annotations

import math

from companion.frames import Vec3

RESTRAINED_SPEED_MAX = 0.25
"""m/s: slower than this a vehicle that is to move may be restrained. Engineering choice."""
UNEXPLAINED_VELOCITY_MIN = 0.5
"""m/s of velocity that it should have come to and has not, from which on it is restrained. Engineering choice."""
UNEXPLAINED_VELOCITY_TIME = 1.0
"""s, time constant in which such velocity is forgotten. Engineering choice."""
RELEASE_SPEED = 0.12
"""m/s: so fast towards where its thrust points a vehicle that was restrained is free again. Engineering choice."""


def is_restrained(unexplained_velocity_n: Vec3) -> bool:
    """Whether a vehicle is held that should have come to that velocity (m/s) and stands still."""
    x, y, z = unexplained_velocity_n
    return x * x + y * y + z * z > UNEXPLAINED_VELOCITY_MIN * UNEXPLAINED_VELOCITY_MIN


def unexplained_velocity(before: Vec3, dt: float, a_n: Vec3, v_n: Vec3) -> Vec3:
    """m/s that a vehicle that stands still should have come to, ``dt`` s after ``before``; zero once it moves.

    ``a_n``: m/s^2, by the forces on one that stands. ``v_n``: m/s. One that was restrained is free as soon as it moves
    the way it is pushed.
    """
    vx, vy, vz = v_n
    x, y, z = before
    released = is_restrained(before) and vx * x + vy * y + vz * z > RELEASE_SPEED * math.sqrt(x * x + y * y + z * z)
    if released or vx * vx + vy * vy + vz * vz > RESTRAINED_SPEED_MAX * RESTRAINED_SPEED_MAX:
        return (0.0, 0.0, 0.0)
    keep = 1.0 - dt / UNEXPLAINED_VELOCITY_TIME
    ax, ay, az = a_n
    return (keep * x + dt * ax, keep * y + dt * ay, keep * z + dt * az)
