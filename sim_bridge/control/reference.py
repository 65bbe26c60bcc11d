"""The smooth motion that the automatic modes follow: a point whose acceleration and jerk are limited.

Values in, values out. The point is led to a place or along a velocity; what leads it decides where it ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Vec3


class TrajectoryLimits(NamedTuple):
    """Limits of a reference, PX4's MPC_* defaults: m/s level, up and down; m/s^2; m/s^3; m/s^2 to stop a climb."""

    cruise: float = 5.0
    climb: float = 3.0
    sink: float = 1.5
    acceleration: float = 3.0
    jerk: float = 4.0
    lift: float = 4.0


class Reference(NamedTuple):
    """A moving point in NED: m, m/s, m/s^2."""

    p_n: Vec3
    v_n: Vec3
    a_n: Vec3 = (0.0, 0.0, 0.0)


def arrival_speed(distance: float, most: float, pace: TrajectoryLimits) -> float:
    """The speed from which a point can come to rest in ``distance`` (m), jerk included: PX4's rule of thumb."""
    b = 4.0 * pace.acceleration * pace.acceleration / pace.jerk
    return min(most, 0.5 * (math.sqrt(b * b + 8.0 * pace.acceleration * distance) - b))


def towards(reference: Reference, place: Vec3, pace: TrajectoryLimits, step: float) -> Reference:
    """The reference one step (s) further on its way to ``place``, where it comes to rest."""
    x, y, z = reference.p_n
    dx, dy, dz = place[0] - x, place[1] - y, place[2] - z
    level = math.hypot(dx, dy)
    share = arrival_speed(level, pace.cruise, pace) / level if level > 0.0 else 0.0
    if dz > 0.0:
        vertical = arrival_speed(dz, pace.sink, pace)
    else:
        vertical = arrival_speed(-dz, pace.climb, pace._replace(acceleration=pace.lift))
    return along(reference, (dx * share, dy * share, math.copysign(vertical, dz)), pace, step)


def along(reference: Reference, velocity: Vec3, pace: TrajectoryLimits, step: float) -> Reference:
    """The reference one step (s) on, its velocity brought nearer to ``velocity`` as fast as ``pace`` allows."""
    (x, y, z), (vx, vy, vz), (ax, ay, az) = reference
    bx, by = _acceleration(velocity[0] - vx, velocity[1] - vy, pace, step)
    bz, _ = _acceleration(velocity[2] - vz, 0.0, pace, step)
    dx, dy = _shortened(bx - ax, by - ay, pace.jerk * step)
    dz, _ = _shortened(bz - az, 0.0, pace.jerk * step)
    ax, ay, az = ax + dx, ay + dy, az + dz
    vx, vy, vz = vx + ax * step, vy + ay * step, vz + az * step
    return Reference((x + vx * step, y + vy * step, z + vz * step), (vx, vy, vz), (ax, ay, az))


def _acceleration(dx: float, dy: float, pace: TrajectoryLimits, step: float) -> tuple[float, float]:
    """The acceleration that closes a gap in velocity soonest and can still be taken back in time."""
    gap = math.hypot(dx, dy)
    if gap == 0.0:
        return (0.0, 0.0)
    share = min(pace.acceleration, math.sqrt(2.0 * pace.jerk * gap), gap / (4.0 * step)) / gap
    return (dx * share, dy * share)


def _shortened(x: float, y: float, most: float) -> tuple[float, float]:
    length = math.hypot(x, y)
    return (x, y) if length <= most else (x * most / length, y * most / length)
