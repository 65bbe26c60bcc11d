"""The smooth motion that the automatic modes follow: a point whose acceleration and jerk are limited.

Values in, values out. The point is led to a place or along a velocity; what leads it decides where it ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Vec3


class TrajectoryLimits(NamedTuple):
    """Limits of a position reference: PX4's defaults."""

    cruise: float = 5.0
    """m/s level (MPC_XY_CRUISE)"""
    climb: float = 3.0
    """m/s up (MPC_Z_V_AUTO_UP)"""
    sink: float = 1.5
    """m/s down (MPC_Z_V_AUTO_DN)"""
    acceleration: float = 3.0
    """m/s^2 (MPC_ACC_HOR)"""
    jerk: float = 4.0
    """m/s^3 (MPC_JERK_AUTO)"""
    acceleration_up: float = 4.0
    """m/s^2 to stop a climb (MPC_ACC_UP_MAX)"""


class Reference(NamedTuple):
    """A moving point in NED: m, m/s, m/s^2."""

    p_n: Vec3
    v_n: Vec3
    a_n: Vec3 = (0.0, 0.0, 0.0)


def arrival_speed(distance: float, most: float, limits: TrajectoryLimits) -> float:
    """The speed from which a point can come to rest in ``distance`` (m), jerk included: PX4's rule of thumb."""
    b = 4.0 * limits.acceleration * limits.acceleration / limits.jerk
    return min(most, 0.5 * (math.sqrt(b * b + 8.0 * limits.acceleration * distance) - b))


def towards(reference: Reference, place: Vec3, limits: TrajectoryLimits, step: float) -> Reference:
    """The reference one step (s) further on its way to ``place``, where it comes to rest."""
    x, y, z = reference.p_n
    dx, dy, dz = place[0] - x, place[1] - y, place[2] - z
    horizontal = math.hypot(dx, dy)
    scale = arrival_speed(horizontal, limits.cruise, limits) / horizontal if horizontal > 0.0 else 0.0
    if dz > 0.0:
        vertical = arrival_speed(dz, limits.sink, limits)
    else:
        vertical = arrival_speed(-dz, limits.climb, limits._replace(acceleration=limits.acceleration_up))
    return along(reference, (dx * scale, dy * scale, math.copysign(vertical, dz)), limits, step)


def along(reference: Reference, velocity: Vec3, limits: TrajectoryLimits, step: float) -> Reference:
    """The reference one step (s) on, its velocity brought nearer to ``velocity`` as fast as ``limits`` allows."""
    (x, y, z), (vx, vy, vz), (ax, ay, az) = reference
    bx, by = _acceleration(velocity[0] - vx, velocity[1] - vy, limits, step)
    bz, _ = _acceleration(velocity[2] - vz, 0.0, limits, step)
    dx, dy = _limit_length(bx - ax, by - ay, limits.jerk * step)
    dz, _ = _limit_length(bz - az, 0.0, limits.jerk * step)
    ax, ay, az = ax + dx, ay + dy, az + dz
    vx, vy, vz = vx + ax * step, vy + ay * step, vz + az * step
    return Reference((x + vx * step, y + vy * step, z + vz * step), (vx, vy, vz), (ax, ay, az))


def _acceleration(dx: float, dy: float, limits: TrajectoryLimits, step: float) -> tuple[float, float]:
    """The acceleration that closes a gap in velocity soonest and can still be taken back in time."""
    gap = math.hypot(dx, dy)
    if gap == 0.0:
        return (0.0, 0.0)
    scale = min(limits.acceleration, math.sqrt(2.0 * limits.jerk * gap), gap / (4.0 * step)) / gap
    return (dx * scale, dy * scale)


def _limit_length(x: float, y: float, most: float) -> tuple[float, float]:
    length = math.hypot(x, y)
    return (x, y) if length <= most else (x * most / length, y * most / length)
