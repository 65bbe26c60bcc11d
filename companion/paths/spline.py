"""A smooth curve through waypoints: the quintic spline, C^4, in a parameter that grows with the distance of the points.

Four continuous derivatives are what the law at motors needs; a cubic spline (two) makes it jump at every waypoint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from companion.frames import Vec3
from companion.paths.curve import Curve, Shape
from companion.paths.piecewise import Piecewise
from companion.paths.polyline import APART_MIN, line

SPACING = 0.75
"""The parameter between two waypoints over their distance to this power: 1 swings wide where a long leg meets a short
one, 0.5 bends sharply there."""


def spline(points: Sequence[Vec3], closed: bool) -> Curve:
    """The spline through ``points`` (m), three at least where closed, two where open. ValueError: no curve."""
    from scipy.interpolate import make_interp_spline  # takes longer to import than all the rest of a command

    p = np.array(points, dtype=float)
    if len(p) == 2 and not closed:
        return line(points[0], points[1])
    if closed and len(p) > 2 and np.linalg.norm(p[0] - p[-1]) < APART_MIN:
        p = p[:-1]
    if closed and len(p) < 3:
        raise ValueError(f"{len(p)} points do not make a closed curve; expected three points at least")
    steps = np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1)
    for i in np.flatnonzero((steps if closed else steps[:-1]) < APART_MIN):
        raise ValueError(f"points {i + 1} and {(i + 1) % len(p) + 1} are the same")
    if closed:
        u = np.concatenate([[0.0], np.cumsum(steps**SPACING)])
        bent = make_interp_spline(u, np.concatenate([p, p[:1]]), k=5, bc_type="periodic")
    else:
        u = np.concatenate([[0.0], np.cumsum(steps[:-1] ** SPACING)])
        free = [(3, np.zeros(3)), (4, np.zeros(3))]
        bent = make_interp_spline(u, p, k=5, bc_type=(free, free))
    # its knots are the waypoints, so each leg is one polynomial: its Taylor series at the leg's beginning
    series = np.stack([bent(u[:-1], nu=k) / math.factorial(k) for k in range(5, -1, -1)], axis=-1)
    knots = tuple(u.tolist())
    return Curve(Shape(Piecewise(knots, tuple(series)), knots[0], knots[-1], closed, knots[1:-1]))
