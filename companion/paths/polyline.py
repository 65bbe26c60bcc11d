"""Straight legs with rounded corners, C^4: what a survey is made of. A line is one leg.

A corner is rounded by one polynomial. On the straight legs gamma = corner + t e, |e| = 1, so going from e1 to e2

    gamma = corner + t e1 + d phi(t/d) (e2 - e1),      phi'' = 35/32 (1 - x^2)^3 on [-1, 1]

phi is 0 before -1 and x after 1, and joins both with four continuous derivatives. It passes the corner at a distance of
d phi(0) |e2 - e1| = 35/256 d 2 sin(turn/2), which is the farthest it strays from the legs' own corner.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from companion.frames import Vec3
from companion.paths.curve import Curve, Shape
from companion.paths.piecewise import Coefficients, Piecewise

# phi(x), highest power first, from phi'' = 35/32 (1 - 3x^2 + 3x^4 - x^6), phi(-1) = phi'(-1) = 0
PHI = np.array([-5.0 / 256.0, 0.0, 7.0 / 64.0, 0.0, -35.0 / 128.0, 0.0, 35.0 / 64.0, 0.5, 35.0 / 256.0])
SPLIT = 0.5
"""The share of a leg that a corner at its end may take."""
TURN_MAX = math.radians(175.0)
"""rad between two legs, beyond which no blend is wide enough."""
APART_MIN = 1e-3
"""m between neighbouring points."""


def line(begin: Vec3, end: Vec3) -> Curve:
    """The straight line between two points. ValueError: they are one."""
    return polyline([begin, end], closed=False, tolerance=0.0)


def polyline(points: Sequence[Vec3], closed: bool, tolerance: float | Sequence[float]) -> Curve:
    """The legs between ``points``, each corner rounded so that the path passes it within ``tolerance`` m (one for all,
    or one each), and nearer where the legs are short. ValueError: says which points cannot be joined."""
    p = np.array(points, dtype=float)
    if closed and len(p) > 2 and np.linalg.norm(p[0] - p[-1]) < APART_MIN:
        p = p[:-1]
    ahead = np.roll(p, -1, axis=0) - p
    if not closed:
        ahead = ahead[:-1]
    lengths = np.linalg.norm(ahead, axis=1)
    for same in np.flatnonzero(lengths < APART_MIN):
        raise ValueError(f"points {same + 1} and {(same + 1) % len(p) + 1} are the same")
    legs = ahead / lengths[:, None]
    within = np.broadcast_to(np.asarray(tolerance, dtype=float), len(points))
    count = len(legs)
    corners = range(count) if closed else range(1, count)  # corner i is where leg i begins
    reach = np.zeros(count + 1)
    for i in corners:
        turn = math.acos(max(-1.0, min(1.0, float(legs[i - 1] @ legs[i]))))
        if turn > TURN_MAX:
            raise ValueError(f"turns back on itself at point {i + 1}; expected a turn of less than 175 degrees")
        side = SPLIT * min(lengths[i - 1], lengths[i])
        wanted = float(within[i]) / (PHI[-1] * 2.0 * math.sin(0.5 * turn)) if turn > 1e-9 else 0.0
        reach[i] = min(side, wanted)
    if closed:
        reach[count] = reach[0]
    pieces: list[Coefficients] = []
    knots = [reach[0]]  # the parameter is the distance along the legs; a closed path begins after its first corner
    at = 0.0
    for i in range(count):
        straight = lengths[i] - reach[i] - reach[i + 1]
        if straight > 1e-9:
            pieces.append(np.stack([legs[i], p[i] + reach[i] * legs[i]], axis=1))
            knots.append(at + lengths[i] - reach[i + 1])
        at += lengths[i]
        following = (i + 1) % count
        if reach[i + 1] > 0.0 and (closed or i + 1 < count):
            pieces.append(_corner(p[(i + 1) % len(p)], legs[i], legs[following], reach[i + 1]))
            knots.append(at + reach[i + 1])
    # as Python's own floats: numpy's would spread from here to every command, and are slow
    first, *inner, last = (float(knot) for knot in knots)
    shape = Shape(Piecewise((first, *inner, last), tuple(pieces)), first, last, closed, tuple(inner))
    return Curve(shape)


def _corner(corner: np.ndarray, before: np.ndarray, after: np.ndarray, reach: float) -> Coefficients:
    """The rounded corner as a polynomial of the distance from its beginning, ``reach`` m before the corner."""
    blend = PHI * reach / reach ** np.arange(8.0, -1.0, -1.0)
    coefficients = np.outer(after - before, _shifted(blend, -reach))
    coefficients[:, -1] += corner - reach * before
    coefficients[:, -2] += before
    return coefficients


def _shifted(polynomial: np.ndarray, by: float) -> np.ndarray:
    """The coefficients of f(x + by)."""
    row = polynomial.copy()
    for end in range(len(row), 1, -1):
        for i in range(1, end):
            row[i] += row[i - 1] * by
    return row
