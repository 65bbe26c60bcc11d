"""Circle, ellipse and helix. They run clockwise seen from above, from the mission's x axis on."""

from __future__ import annotations

import math

import numpy as np

from companion.calculus.scalar import Scalar, cos, sin
from companion.frames import Vec3
from companion.paths.curve import Curve, analytic

LEVEL = 1e-6
"""A normal this near to the horizontal has no upper side: then clockwise is seen from where it points."""


def circle(center: Vec3, radius: float, normal: Vec3, up: Vec3) -> Curve:
    """The circle of ``radius`` m about ``center``. ``normal``: of its plane; which of its two sides does not matter.
    ``up``: the mission's upward axis."""
    return ellipse(center, radius, radius, normal, up)


def ellipse(center: Vec3, a: float, b: float, normal: Vec3, up: Vec3) -> Curve:
    """The ellipse with semi-axes ``a`` m along the mission's x axis, laid into the plane, and ``b`` m across it."""
    first, second = plane_axes(normal, up)

    def gamma(u: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        x, y, z = (c + (a * p) * cos(u) + (b * q) * sin(u) for c, p, q in zip(center, first, second, strict=True))
        return x, y, z

    return analytic(gamma, 0.0, math.tau, True)


def helix(center: Vec3, radius: float, pitch: float, turns: float, up: Vec3) -> Curve:
    """``turns`` turns of ``radius`` m about a vertical axis, from the height of ``center`` on, climbing ``pitch`` m a
    turn (negative: sinking)."""
    first, second = plane_axes(up, up)
    climb = pitch / math.tau

    def gamma(u: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        x, y, z = (
            c + (radius * p) * cos(u) + (radius * q) * sin(u) + (climb * w) * u
            for c, p, q, w in zip(center, first, second, up, strict=True)
        )
        return x, y, z

    return analytic(gamma, 0.0, math.tau * turns, False)


def plane_axes(normal: Vec3, up: Vec3) -> tuple[Vec3, Vec3]:
    """Two unit axes of the plane: the mission's x axis laid into it (its y axis where that one stands on the plane),
    and the one a quarter turn later, clockwise seen from above. ValueError: the normal has no length."""
    n = np.array(normal, dtype=float)
    size = float(np.linalg.norm(n))
    if size < 1e-12:
        raise ValueError(f"{list(normal)} has no direction")
    n /= size
    if float(n @ np.array(up)) < -LEVEL:
        n = -n
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        first = np.array(axis) - n * (n @ np.array(axis))
        if float(np.linalg.norm(first)) > 0.1:
            break
    first /= np.linalg.norm(first)
    second = np.cross(-n, first)  # right-handed about the downward normal is clockwise from above
    return _triple(first), _triple(second)


def _triple(v: np.ndarray) -> Vec3:
    x, y, z = (float(c) + 0.0 for c in v)
    return (x, y, z)
