"""The outputs h1..h4 of an implicitly given path and their time derivatives (Eq. 3 and the Lie derivatives of Eq. 8).

The path is h1(X) = h2(X) = 0 with any smooth h1, h2; the speed is alpha(X), the yaw beta(X). Everything is evaluated
along X(t) = X + V t + A t^2/2 (+ J t^3/6) in truncated Taylor arithmetic, with gradients beside the values. The only
thing left unknown is the highest derivative of the position: the snap S at the level of motors (order 4), the jerk J at
the level of rates (order 3). In it the outputs are affine:

    h1^(n) = drift + grad h1 . S      h2^(n) = drift + grad h2 . S      h3^(n-1) = drift + mu . S
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from companion.calculus.scalar import Scalar
from companion.calculus.taylor import Gradient, Taylor
from companion.calculus.vectors import Vector
from companion.frames import Heading

Position = tuple[Scalar, Scalar, Scalar]
PathFunction = Callable[[Position], tuple[Scalar, Scalar]]
Function = Callable[[Position, Position], Scalar]


@dataclass(frozen=True, slots=True)
class Specification:
    """What is to be flown: h = (h1, h2) of the position (Def. 3.1), alpha (Def. 3.2) and beta (Def. 3.3) of the
    position and the unit tangent mu (the paper's take the position only). ``heading``: whose beta is."""

    h: PathFunction
    alpha: Function
    beta: Function
    heading: Heading = Heading.PROJECTED


@dataclass(frozen=True, slots=True)
class Outputs:
    """The outputs at one state.

    ``h1``, ``h2``, ``h3``: series whose highest coefficient lacks the term of the unknown derivative. ``beta``: the
    wanted yaw. ``mu``: the unit tangent (Eq. 7). ``alpha``: the wanted speed.
    """

    h1: Taylor
    h2: Taylor
    h3: Taylor
    beta: Taylor
    grad1: Vector
    grad2: Vector
    mu: Vector
    alpha: Scalar


def series(derivatives: tuple[Vector, ...]) -> tuple[Taylor, Taylor, Taylor]:
    """X(t) from (X, V, A, ...): one order more than given, its last coefficient zero for the unknown."""
    factors = [1.0, 1.0, 0.5, 1.0 / 6.0]
    columns = zip(*(d.components() for d in derivatives), strict=True)
    x, y, z = (
        Taylor((*(value * factor for value, factor in zip(column, factors, strict=False)), 0.0)) for column in columns
    )
    return x, y, z


def outputs(specification: Specification, derivatives: tuple[Vector, ...], factor: Taylor) -> Outputs:
    """The outputs at (X, V, A) for the level of rates, at (X, V, A, J) for that of motors.

    ``factor``: a series in time that multiplies alpha (the ramp at the start, a speed factor); Taylor((1.0, 0, ...))
    for the paper's law. ValueError or ArithmeticError where an expression is outside its domain.
    """
    order = len(derivatives)
    along = series(derivatives)
    x, y, z = along
    seeded = (Gradient(x, (1.0, 0.0, 0.0)), Gradient(y, (0.0, 1.0, 0.0)), Gradient(z, (0.0, 0.0, 1.0)))
    h1, h2 = (_with_gradient(h, order) for h in specification.h(seeded))
    grad1, grad2 = (Vector(*(_series(d, order) for d in h.partials)) for h in (h1, h2))
    normal = grad1.cross(grad2)
    mu = normal / normal.norm()
    velocity = Vector(*(coordinate.differentiated() for coordinate in along))
    alpha = _series(specification.alpha(along, mu.components()), order)
    beta = _series(specification.beta(along, mu.components()), order)
    return Outputs(
        h1=h1.value,
        h2=h2.value,
        h3=mu @ velocity - factor * alpha,
        beta=beta,
        grad1=_at_zero(grad1),
        grad2=_at_zero(grad2),
        mu=_at_zero(mu),
        alpha=alpha.c[0],
    )


def arc_along(p_n: Position, mu: Position) -> Taylor:
    """The arc length from the present on, s' = mu . V, as a series in time; its highest coefficient lacks the term of
    the unknown derivative. On the path it is eta's (section IV.B); off it, to first order in the distance."""
    velocity = [coordinate.differentiated() for coordinate in p_n]
    speed = mu[0] * velocity[0] + mu[1] * velocity[1] + mu[2] * velocity[2]
    return Taylor((0.0, *(c / (k + 1) for k, c in enumerate(speed.c))))


def _series(value: Scalar, order: int) -> Taylor:
    return value if isinstance(value, Taylor) else Taylor((value, *(0.0 for _ in range(order))))


def _with_gradient(value: Scalar, order: int) -> Gradient:
    if not isinstance(value, Gradient):
        value = Gradient(value, (0.0, 0.0, 0.0))
    return Gradient(_series(value.value, order), value.partials)


def _at_zero(vector: Vector) -> Vector:
    return Vector(vector.x.c[0], vector.y.c[0], vector.z.c[0])
