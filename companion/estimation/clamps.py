"""The clamps on what is estimated: ||d - LPF(d)||, thrust scale, drag.

A vehicle that is restrained is not taken for one in a storm, and does not leap away when it is released.
"""

from __future__ import annotations

import math

from companion.estimation.kalman import Belief
from companion.estimation.kalman_step import DOWN, DRAG, EAST, GUST, NORTH, THRUST_SCALE
from companion.frames import Vec3, clamped

THRUST_SCALE_RANGE = (0.45, 2.2)
"""Ratio of thrust made to thrust asked for. Engineering choice: hover thrusts of half and twice the one of the
vehicle file."""
DRAG_RANGE = (0.0, 2.5)
"""1/s. Engineering choice: PX4's simulated quadrotor, which is draggy, has 1.0."""
DISTURBANCE_DEVIATION_MAX = 2.0
"""m/s^2, the largest ||d - LPF(d)||. Simulated: held for 4 s and let go, a vehicle then leaps 0.13 m; with 4 m/s^2
0.28 m."""
INITIAL_DEVIATION_MAX = 8.0
"""m/s^2, the same at first, when the disturbance may be anywhere a wind could put it. Engineering choice."""
INITIAL_PHASE = 4.0
"""s in which the clamp closes from its initial to its usual size. Engineering choice."""
DISTURBANCE_LPF_TIME = 5.0
"""s, time constant of LPF(d). Engineering choice: longer than a gust, shorter than a change of the weather."""
INITIAL_DISTURBANCE_LPF_TIME = 0.5
"""s, the same in the initial phase. Engineering choice."""


def clamp(belief: Belief, disturbance_lpf_n: Vec3, dt: float, flight_time: float) -> tuple[Belief, Vec3, bool]:
    """The clamps: ||d - LPF(d)||, scale, drag. Gives the belief, LPF(d), and whether the first one acts."""
    dx, dy, dz = belief.disturbance_n
    sx, sy, sz = disturbance_lpf_n
    ox, oy, oz = dx - sx, dy - sy, dz - sz
    off = math.sqrt(ox * ox + oy * oy + oz * oz)
    progress = flight_time / INITIAL_PHASE
    early = progress < 1.0
    radius = (
        INITIAL_DEVIATION_MAX + (DISTURBANCE_DEVIATION_MAX - INITIAL_DEVIATION_MAX) * progress
        if early
        else DISTURBANCE_DEVIATION_MAX
    )
    x, disturbance_saturated = belief.x, off > radius
    if disturbance_saturated:
        shrink = radius / off
        moved = list(x)
        for axis, beyond in ((NORTH, ox), (EAST, oy), (DOWN, oz)):
            moved[axis + GUST] -= beyond * (1.0 - shrink)
        x = tuple(moved)
    else:
        k = min(1.0, dt / (INITIAL_DISTURBANCE_LPF_TIME if early else DISTURBANCE_LPF_TIME))
        disturbance_lpf_n = (sx + k * ox, sy + k * oy, sz + k * oz)
    scale, drag = clamped(x[THRUST_SCALE], *THRUST_SCALE_RANGE), clamped(x[DRAG], *DRAG_RANGE)
    if scale != x[THRUST_SCALE] or drag != x[DRAG]:
        x = (*x[:THRUST_SCALE], scale, drag)
    limited = belief if x is belief.x else belief._replace(x=x)
    return limited, disturbance_lpf_n, disturbance_saturated
