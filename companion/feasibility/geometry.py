"""Limits of the path itself, whatever the speed: how it bends, how it closes, how high it lies."""

from __future__ import annotations

import math

import numpy as np

from companion.feasibility.limits import Limit
from companion.feasibility.stations import Stations
from companion.fence import Fence
from companion.mission import Mission

RADIUS_MIN = 0.3
"""m; nearer to the path than its radius of curvature the closest point is one, and a vehicle is never nearer than this
to its path for sure."""
STRAIGHT = 1e6
"""m, the radius reported for a path without bends."""
CLEARANCE_MIN = 0.3
"""m above the ground."""
FENCE_MIN = 0.5
"""m inside the fence: what a gust may take."""
SPEED_JUMP_MAX = 2.0
"""% of the largest speed."""
YAW_JUMP_MAX = 1.0
"""degrees."""


def radius(at: Stations) -> Limit:
    """The radius of the tube in which the closest point is one: the distance to the evolute."""
    bend = np.linalg.norm(at.path[2], axis=0)
    i = int(np.argmax(bend))
    least = 1.0 / float(bend[i]) if bend[i] > 1.0 / STRAIGHT else STRAIGHT
    return Limit("path_radius_m", least, RADIUS_MIN, float(at.s[i]), least >= RADIUS_MIN, RADIUS_MIN / least)


def clearance(at: Stations, ground: float) -> Limit:
    """How far the path stays above the ``ground`` (m, down in the local frame)."""
    height = ground - at.path[0, 2]
    i = int(np.argmin(height))
    least = float(height[i])
    used = CLEARANCE_MIN / least if least > 0.0 else math.inf
    return Limit("ground_clearance_m", least, CLEARANCE_MIN, float(at.s[i]), least >= CLEARANCE_MIN, used)


def fence_limits(at: Stations, fence: Fence | None) -> list[Limit]:
    """How far the path stays inside the ``fence``, which is in the local frame; nothing where there is none."""
    if fence is None or not fence.areas:
        return []
    margins = [fence.margin((x, y, z)) for x, y, z in at.path[0].T.tolist()]
    i = int(np.argmin(margins))
    least = margins[i]
    used = FENCE_MIN / least if least > 0.0 else math.inf
    return [Limit("fence_m", least, FENCE_MIN, float(at.s[i]), least >= FENCE_MIN, used)]


def jumps(mission: Mission, at: Stations) -> list[Limit]:
    """How speed and heading meet themselves where a path closes."""
    if not mission.closed:
        return []
    fastest = float(np.max(np.abs(at.alpha[0])))
    speed = 100.0 * abs(float(at.alpha[0, -1] - at.alpha[0, 0])) / fastest
    turned = abs(math.degrees(math.remainder(float(at.beta[0, -1] - at.beta[0, 0]), math.tau)))
    end = float(at.s[-1])
    return [
        Limit(name, worst, most, end, worst <= most, worst / most)
        for name, worst, most in (
            ("speed_jump_percent", speed, SPEED_JUMP_MAX),
            ("yaw_jump_deg", turned, YAW_JUMP_MAX),
        )
    ]
