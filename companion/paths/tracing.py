"""Follows the curve h1 = h2 = 0 once around, by predictor and corrector, into an arc-length table.

What Definition 3.1 asks for is found here: that the gradients are independent on the curve and that the curve closes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Gradient, Taylor
from companion.calculus.vectors import Vector
from companion.frames import Vec3
from companion.paths.arc import ArcTable, Knot, Piece, evaluate, quintic
from companion.vehicle import CompanionError

PathFunction = Callable[[tuple[Scalar, Scalar, Scalar]], tuple[Scalar, Scalar]]

TURN_MAX = 0.1
"""rad of turning between two knots."""
STRAY_MAX = 1e-9
"""How far the table may stray from the curve between two knots, over the distance of the knots."""
LENGTH_MAX = 100_000.0
"""m of an implicit path: one that has not closed by then never will."""
KNOTS_MAX = 20_000
"""of an implicit path's table."""
STEP_MIN = 1e-6
"""m: where shorter steps would be needed, the curve is no curve."""
REGULARITY_MIN = 1e-3
"""The least sine of the angle between the gradients on the curve."""


class PathError(CompanionError):
    """There is no path: says what is wrong and where."""


@dataclass(frozen=True, slots=True)
class _Curve:
    """h1 = h2 = 0 near a point. ``local``: x, y, z -> h1, h2, the gradients, mu, d mu/ds, the gradients' sine."""

    local: Function

    def values(self, p: Vec3) -> tuple[float, ...]:
        try:
            values = self.local(*p)
        except ZeroDivisionError:
            what = "the gradients of h1 and h2 are parallel there, or something is divided by zero"
            raise PathError(f"is not regular at {_place(p)}: {what}") from None
        except (ValueError, ArithmeticError) as error:
            raise PathError(f"h1 or h2 is not defined at {_place(p)}: {error}") from None
        if not math.isfinite(sum(values)):
            raise PathError(f"h1 or h2 is not finite at {_place(p)}")
        return values

    def correction(self, p: Vec3) -> Vec3:
        """The shortest step from ``p`` to where the linearised h1 and h2 vanish."""
        h1, h2, *gradients = self.values(p)[:8]
        a, b = gradients[:3], gradients[3:]
        aa, ab, bb = _dot(a, a), _dot(a, b), _dot(b, b)
        determinant = aa * bb - ab * ab
        if determinant <= 1e-12 * aa * bb:
            raise PathError(f"is not regular at {_place(p)}: the gradients of h1 and h2 are parallel there")
        m1, m2 = (bb * h1 - ab * h2) / determinant, (aa * h2 - ab * h1) / determinant
        return (-m1 * a[0] - m2 * b[0], -m1 * a[1] - m2 * b[1], -m1 * a[2] - m2 * b[2])

    def project(self, p: Vec3, reach: float) -> Vec3:
        """The point of the curve next to ``p``, by Newton's method. PathError: none within ``reach``."""
        here = p
        for _ in range(60):
            step = self.correction(here)
            size = math.hypot(*step)
            if size < 1e-13 * (1.0 + math.hypot(*here)):
                return here
            shrink = min(1.0, 0.5 * reach / size)
            here = (here[0] + shrink * step[0], here[1] + shrink * step[1], here[2] + shrink * step[2])
            if math.dist(here, p) > reach:
                break
        if size < 1e-9 * (1.0 + math.hypot(*here)):  # as good as rounding lets it be
            return here
        raise PathError(f"has no point near {_place(p)}: h1 and h2 do not both vanish there")

    def knot(self, p: Vec3) -> Knot:
        """The curve at one of its points. PathError: it is not regular there."""
        values = self.values(p)
        if values[14] < REGULARITY_MIN:
            raise PathError(f"is not regular at {_place(p)}: the gradients of h1 and h2 are parallel there")
        return Knot(p, values[8:11], values[11:14])  # type: ignore[arg-type]


def trace_curve(h: PathFunction, near: Vec3) -> ArcTable:
    """The closed curve through the point next to ``near``. PathError: there is none, it ends, or is not regular."""
    try:
        curve = _Curve(_record(h))
    except (ValueError, ArithmeticError):
        raise PathError("is nowhere regular: the gradients of h1 and h2 are parallel or undefined everywhere") from None
    first = here = curve.knot(curve.project(near, reach=1e4))
    pieces: list[Piece] = []
    lengths = [0.0]
    step = _comfortable(first, 1.0)
    closing = False
    while not closing:
        if len(pieces) > KNOTS_MAX or lengths[-1] > LENGTH_MAX:
            followed = f"followed for {lengths[-1]:.4g} m to {_place(here.point)}"
            raise PathError(f"does not close: {followed}; expected a loop")
        closing = len(pieces) > 1 and _lies_ahead(first, here, step)
        try:
            there = first if closing else curve.knot(curve.project(_ahead(here, step), reach=0.5 * step))
            piece, length, stray = _segment(curve, here, there)
            turned = math.acos(max(-1.0, min(1.0, _dot(here.tangent, there.tangent))))
            tolerance = STRAY_MAX * length + 1e-13 * math.hypot(*there.point)
            if turned > 1.5 * TURN_MAX or stray > tolerance:
                raise PathError("turns too sharply for this step")
        except PathError:
            if step < STEP_MIN:
                what = "there it ends, has a corner, crosses itself, or the gradients of h1 and h2 are parallel"
                raise PathError(f"cannot be followed past {_place(here.point)}: {what}") from None
            step *= 0.5
            closing = False
            continue
        pieces.append(piece)
        lengths.append(lengths[-1] + length)
        here = there
        step = _comfortable(here, 1.5 * step if stray < 0.03 * tolerance else step)
    return ArcTable(tuple(lengths), tuple(pieces), closed=True)


def _comfortable(knot: Knot, step: float) -> float:
    return min(step, TURN_MAX / max(math.hypot(*knot.curvature), 1e-9))


def _ahead(knot: Knot, step: float) -> Vec3:
    x, y, z = (
        p + step * m + 0.5 * step * step * k for p, m, k in zip(knot.point, knot.tangent, knot.curvature, strict=True)
    )
    return (x, y, z)


def _lies_ahead(first: Knot, here: Knot, step: float) -> bool:
    """Whether the curve's beginning is reached within this step."""
    away = (first.point[0] - here.point[0], first.point[1] - here.point[1], first.point[2] - here.point[2])
    along = _dot(away, here.tangent)
    return 0.0 < along <= 1.3 * step and math.hypot(*away) < 1.05 * along and _dot(here.tangent, first.tangent) > 0.9


_NODES = [(float(x), float(w)) for x, w in zip(*np.polynomial.legendre.leggauss(6), strict=True)]
"""of Gauss and Legendre's quadrature with six points."""


def _segment(curve: _Curve, a: Knot, b: Knot) -> tuple[Piece, float, float]:
    """The quintic from ``a`` to ``b``, its length, and how far it strays from the curve at its middle."""
    length = math.dist(a.point, b.point)
    for _ in range(20):
        piece = quintic(a, b, length)
        speeds = (weight * math.hypot(*evaluate(piece, 0.5 * length * (node + 1.0))[1]) for node, weight in _NODES)
        measured = 0.5 * length * sum(speeds)
        if abs(measured - length) < 1e-13 * length:
            break
        length = measured
    return piece, length, math.hypot(*curve.correction(evaluate(piece, 0.5 * length)[0]))


def _record(h: PathFunction) -> Function:
    """The function of ``_Curve``."""
    tape = Tape()
    x, y, z = tape.inputs("x", "y", "z")
    values, gradients = _with_gradients(h, (x, y, z))
    normal = gradients[0].cross(gradients[1])
    area = normal.norm()
    mu = normal / area
    sine = area / (gradients[0].norm() * gradients[1].norm())
    moving = (Taylor((x, mu.x)), Taylor((y, mu.y)), Taylor((z, mu.z)))
    _, (g1, g2) = _with_gradients(h, moving)
    turning = g1.cross(g2)
    turning = turning / turning.norm()
    change = [component.c[1] for component in turning.components()]
    outputs = [*values, *gradients[0].components(), *gradients[1].components(), *mu.components(), *change, sine]
    return tape.function("local", outputs)


def _with_gradients(h: PathFunction, at: tuple[Scalar, Scalar, Scalar]) -> tuple[list[Scalar], tuple[Vector, Vector]]:
    seeds = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    x, y, z = (Gradient(coordinate, seed) for coordinate, seed in zip(at, seeds, strict=True))
    flat = Taylor((0.0, 0.0)) if isinstance(at[0], Taylor) else 0.0
    results = [result if isinstance(result, Gradient) else Gradient(result, (0.0, 0.0, 0.0)) for result in h((x, y, z))]
    first, second = (Vector(*(flat + partial for partial in result.partials)) for result in results)
    return [result.value for result in results], (first, second)


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _place(p: Vec3) -> str:
    return f"north {p[0]:z.2f}, east {p[1]:z.2f}, height {-p[2]:z.2f} m"
