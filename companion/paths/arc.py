"""A curve as a table over its arc length: where the nearest point is, how far, how long the curve is.

Between its knots the table is a quintic that shares position, unit tangent and curvature with the curve, so with
knots a tenth of a radian of turning apart it is good to about 1e-11 of the radius.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.calculus import machine_code
from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.frames import Vec3
from companion.paths.placement import Placement

NEWTON_STEPS = 8
"""at most, to the nearest arc length."""
NEAREST_TOLERANCE = 1e-4
"""m, the last step of a search. It leaves an error of its square over the radius: 1e-8 m of arc length, 1e-16 of
distance."""


class Knot(NamedTuple):
    """A point of a curve, its unit tangent, and the tangent's derivative over the arc length."""

    point: Vec3
    tangent: Vec3
    curvature: Vec3


Scalars = tuple[Scalar, Scalar, Scalar]
Piece = tuple[tuple[Scalar, ...], tuple[Scalar, ...], tuple[Scalar, ...]]


def quintic(a: Knot, b: Knot, length: float) -> Piece:
    """The polynomials in arc length that leave ``a`` and reach ``b`` after ``length``, highest power first."""
    x, y, z = (_quintic(a.point[i], a.tangent[i], a.curvature[i], b.point[i], b.tangent[i], b.curvature[i], length)
               for i in range(3))  # fmt: skip
    return (x, y, z)


def _quintic(p0: float, v0: float, a0: float, p1: float, v1: float, a1: float, h: float) -> tuple[float, ...]:
    d, v0h, v1h, a0h, a1h = p1 - p0, v0 * h, v1 * h, 0.5 * a0 * h * h, 0.5 * a1 * h * h
    return (
        (6.0 * d - 3.0 * (v0h + v1h) - a0h + a1h) / h**5,
        (-15.0 * d + 8.0 * v0h + 7.0 * v1h + 3.0 * a0h - 2.0 * a1h) / h**4,
        (10.0 * d - 6.0 * v0h - 4.0 * v1h - 3.0 * a0h + a1h) / h**3,
        0.5 * a0,
        v0,
        p0,
    )


def evaluate(piece: Piece, u: Scalar) -> tuple[Scalars, Scalars, Scalars]:
    """Point, first and second derivative of ``piece``, ``u`` after its beginning. Floats, or symbols of a tape."""
    (a5, a4, a3, a2, a1, a0), (b5, b4, b3, b2, b1, b0), (c5, c4, c3, c2, c1, c0) = piece
    return (
        (
            ((((a5 * u + a4) * u + a3) * u + a2) * u + a1) * u + a0,
            ((((b5 * u + b4) * u + b3) * u + b2) * u + b1) * u + b0,
            ((((c5 * u + c4) * u + c3) * u + c2) * u + c1) * u + c0,
        ),
        (
            (((5.0 * a5 * u + 4.0 * a4) * u + 3.0 * a3) * u + 2.0 * a2) * u + a1,
            (((5.0 * b5 * u + 4.0 * b4) * u + 3.0 * b3) * u + 2.0 * b2) * u + b1,
            (((5.0 * c5 * u + 4.0 * c4) * u + 3.0 * c3) * u + 2.0 * c2) * u + c1,
        ),
        (
            ((20.0 * a5 * u + 12.0 * a4) * u + 6.0 * a3) * u + 2.0 * a2,
            ((20.0 * b5 * u + 12.0 * b4) * u + 6.0 * b3) * u + 2.0 * b2,
            ((20.0 * c5 * u + 12.0 * c4) * u + 6.0 * c3) * u + 2.0 * c2,
        ),
    )


@lru_cache(maxsize=2)
def _evaluation(in_machine_code: bool) -> Function:
    """``evaluate``, recorded: of the coefficients of x, of y and of z, and of u."""
    tape = Tape()
    x, y, z = (tape.tuple_input(*(f"{axis}{power}" for power in range(6))) for axis in "xyz")
    (u,) = tape.inputs("u")
    return machine_code.function_of(tape, "evaluate", evaluate((x, y, z), u))


@dataclass(frozen=True)
class ArcTable:
    """``knots``: arc lengths, rising from 0 to ``length``. ``pieces``: for each interval the coefficients of x, y, z in
    s - knot, highest power first. ``closed``: the end is the beginning."""

    knots: tuple[float, ...]
    pieces: tuple[Piece, ...]
    closed: bool

    @property
    def length(self) -> float:
        """m."""
        return self.knots[-1]

    def moved(self, placement: Placement) -> ArcTable:
        """The table of the curve placed in the vehicle's local frame, its own coordinates being those of a mission."""
        axes = np.array([placement.turned(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]).T
        coefficients = axes @ np.array(self.pieces)
        coefficients[:, :, -1] += placement.origin_n
        pieces = tuple((tuple(x), tuple(y), tuple(z)) for x, y, z in coefficients.tolist())
        return ArcTable(self.knots, pieces, self.closed)

    def at(self, s: float) -> tuple[Vec3, Vec3, Vec3]:
        """Point, first and second derivative at arc length ``s``; wrapped where closed, clamped where open."""
        s = self.within(s)
        i = bisect_right(self.knots, s, 0, len(self.pieces)) - 1
        piece, u = self.pieces[i], s - self.knots[i]
        return _evaluation(True)(*piece, u) if machine_code.in_use else evaluate(piece, u)

    def within(self, s: float) -> float:
        """``s`` as an arc length of the curve."""
        return s % self.length if self.closed else min(max(s, 0.0), self.length)

    def nearest(self, p: Vec3, s: float, reach: float = math.inf) -> tuple[float, float]:
        """(arc length, distance) of the point nearest to ``p``, searched downhill from ``s`` and at most ``reach`` away
        from it: a curve that crosses itself is not left for its other branch."""
        px, py, pz = p
        moved = 0.0  # from s
        missed = 0.0  # square of the distance by which the point is not yet the nearest
        for _ in range(NEWTON_STEPS):
            (x, y, z), (tx, ty, tz), (kx, ky, kz) = self.at(s + moved)
            ex, ey, ez = px - x, py - y, pz - z
            along = ex * tx + ey * ty + ez * tz
            # past the evolute the nearest point is not near any more; the floor keeps the step downhill
            bend = 1.0 - (ex * kx + ey * ky + ez * kz)
            step = along / (bend if bend > 0.25 else 0.25)
            if not -reach <= moved + step <= reach:
                step = math.copysign(reach, step) - moved
            moved += step
            if -NEAREST_TOLERANCE < step < NEAREST_TOLERANCE:
                # right to the square of this step: the next would be nothing, and the distance there is known
                missed = step * (2.0 * along - step * bend)
                break
        return self.within(s + moved), math.sqrt(max(ex * ex + ey * ey + ez * ez - missed, 0.0))

    def locate(self, p: Vec3) -> tuple[float, float]:
        """(arc length, distance) of the nearest point of the whole curve."""
        s, points = self.samples(max(200, 4 * len(self.pieces)))
        distances = np.linalg.norm(points - np.array(p), axis=1)
        spacing = self.length / (len(s) - 1)
        candidates = sorted(range(len(s)), key=lambda i: distances[i])[:8]
        return min((self.nearest(p, float(s[i]), 2.0 * spacing) for i in candidates), key=lambda found: found[1])

    def difference(self, s: float, reference: float) -> float:
        """s - reference, the short way round where closed."""
        return math.remainder(s - reference, self.length) if self.closed else s - reference

    def samples(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """``count`` arc lengths from end to end, and their points as rows."""
        s = np.linspace(0.0, self.length, count)
        i = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.pieces) - 1)
        u = s - np.array(self.knots)[i]
        coefficients: NDArray[np.float64] = np.array(self.pieces)[i]
        points = np.zeros((count, 3))
        for power in range(coefficients.shape[2]):
            points = points * u[:, None] + coefficients[:, :, power]
        return s, points
