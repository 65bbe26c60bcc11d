"""Places along a path, many at once: path, speed and yaw there, each with its derivatives over arc length."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.calculus.scalar import Scalar
from companion.calculus.straight import ArrayFunction, Tape
from companion.calculus.taylor import Gradient, Taylor
from companion.calculus.vectors import Vector
from companion.frames import Heading, Vec3
from companion.law.implicit import Position, Specification
from companion.law.reference import flow, tangent
from companion.mission import Mission
from companion.paths.curve import Curve
from companion.paths.implicit import ImplicitPath
from companion.profiles import AutoSpeed

Array = NDArray[np.float64]

PLACES, PLACES_MAX = 2000, 200_000
PER_KNOT = 4
"""Places along a path: so many at least, and so many to every interval of its tables."""


@dataclass(frozen=True)
class Stations:
    """``s``: m, of n places. ``path``: the point and its four derivatives over arc length, (5, 3, n), local NED.
    ``alpha``: the speed and three, (4, n), m/s; nan where it is not known yet. ``beta``: the yaw and two, (3, n), rad.
    ``sine``: between the gradients of h1 and h2, 1 on a curve. ``heading``: the kind that ``beta`` is.
    ``wind_n``: the steady velocity of the air, m/s."""

    s: Array
    path: Array
    alpha: Array
    beta: Array
    sine: Array
    heading: Heading = Heading.PROJECTED
    wind_n: Vec3 = (0.0, 0.0, 0.0)

    def with_speed(self, alpha: Array) -> Stations:
        """The same places at another speed."""
        return replace(self, alpha=alpha)


def places(mission: Mission) -> Array:
    """Arc lengths close enough together to miss nothing, from end to end."""
    knots = set(mission.table.knots)
    for profile in (mission.speed, mission.yaw):
        knots |= {s for s in getattr(getattr(profile, "profile", None), "knots", ()) if 0.0 < s < mission.table.length}
    edges = np.array(sorted({*knots, *np.linspace(0.0, mission.table.length, PLACES // PER_KNOT + 1).tolist()}))
    parts = PER_KNOT if PER_KNOT * len(edges) <= PLACES_MAX else 1
    shares = np.arange(parts) / parts
    inner = edges[:-1, None] + shares * np.diff(edges)[:, None]
    return np.append(inner.ravel(), edges[-1])


def stations_along(mission: Mission, s: Array) -> Stations:
    """The mission at arc lengths ``s``. ValueError, ArithmeticError: speed or yaw is not defined somewhere."""
    path = mission.path
    result = _on_implicit(mission, path, s) if isinstance(path, ImplicitPath) else _on_curve(mission, path, s)
    speed, yaw = mission.speed_over_arc, mission.yaw_over_arc
    alpha = np.array([speed.at(x) for x in s.tolist()]).T if speed is not None else result.alpha
    beta = np.array([yaw.at(x)[:3] for x in s.tolist()]).T if yaw is not None else result.beta
    return replace(result, alpha=alpha, beta=beta, heading=mission.heading)


def _on_curve(mission: Mission, curve: Curve, s: Array) -> Stations:
    path = curve.over_arc(s)
    beta = np.full((3, len(s)), np.nan)
    if mission.yaw_over_arc is None:
        beta = _facing(mission)(*path[:4].reshape(12, len(s)))
    return Stations(s, path, np.full((4, len(s)), np.nan), beta, np.ones(len(s)))


def _facing(mission: Mission) -> ArrayFunction:
    """(point and three derivatives over arc length) -> the yaw along the path or towards a point, and two."""
    tape = Tape()
    c = [Vector(*tape.inputs(*(f"c{k}{axis}" for axis in "xyz"))) for k in range(4)]
    point = tuple(Taylor(v) for v in zip(*(d.components() for d in (c[0], c[1], c[2] * 0.5)), strict=True))
    travel = tuple(
        Taylor(v) * mission.direction for v in zip(*(d.components() for d in (c[1], c[2], c[3] * 0.5)), strict=True)
    )
    yaw: Any = mission.yaw
    return tape.array_function("facing", _derivatives(yaw.value({}, point, travel), 3))


def _on_implicit(mission: Mission, path: ImplicitPath, s: Array) -> Stations:
    points = np.array([mission.table.at(x)[0] for x in s.tolist()]).T
    values = _flowing(mission, path)(*points)
    curve = np.concatenate([points[None], values[:12].reshape(4, 3, len(s))])
    return Stations(s, curve, values[12:16], values[16:19], values[19])


def _flowing(mission: Mission, path: ImplicitPath) -> ArrayFunction:
    """(x, y, z) on the path -> its derivatives over arc length (4 x 3), alpha (4), beta (3), the gradients' sine."""
    tape = Tape()
    X = Vector(*tape.inputs("x", "y", "z"))
    whole = mission.specification(mission.direction)

    def unit(p: Position, mu: Position) -> Scalar:
        return 1.0

    specification = Specification(path.h, unit, whole.beta)
    along = flow(specification, X, 4)
    derivatives = [coordinate.derivative(k) for k in (1, 2, 3, 4) for coordinate in along]
    alpha, beta = [0.0] * 4, [0.0] * 3
    if mission.speed_over_arc is None and not isinstance(mission.speed, AutoSpeed):
        alpha = _derivatives(whole.alpha(along, tangent(specification, along)), 4)
    if mission.yaw_over_arc is None:
        beta = _derivatives(whole.beta(along, tangent(specification, along)), 3)
    return tape.array_function("flowing", [*derivatives, *alpha, *beta, _sine(specification, X)])


def _sine(specification: Specification, X: Vector) -> Scalar:
    seeds = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    x, y, z = (Gradient(coordinate, seed) for coordinate, seed in zip(X.components(), seeds, strict=True))
    one, two = (Vector(*h.partials) for h in specification.h((x, y, z)))
    return one.cross(two).norm() / (one.norm() * two.norm())


def _derivatives(value: Scalar, count: int) -> list[Scalar]:
    if not isinstance(value, Taylor):
        return [value, *(0.0 for _ in range(count - 1))]
    return [value.derivative(k) for k in range(count)]
