"""A path given by a parametrisation gamma(u): any regular curve, closed or open, in any parameter.

The law needs gamma and its derivatives at a parameter; everybody else needs arc length. A Curve answers both: its
``table`` is the curve over its arc length, and ``parameter`` and ``arc`` go from one to the other.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Tape
from companion.calculus.taylor import Taylor
from companion.frames import Vec3
from companion.paths.arc import ArcTable, Knot, Piece, evaluated, quintic
from companion.paths.placement import Placement
from companion.paths.tracing import KNOTS_MAX, LENGTH_MAX, STEP_MIN, STRAY_MAX, TURN_MAX, PathError

Derivatives = tuple[Vec3, Vec3, Vec3, Vec3, Vec3]
"""gamma and its first four derivatives over the parameter."""
Parametrisation = Callable[[Scalar], tuple[Scalar, Scalar, Scalar]]

CLOSED_WITHIN = 1e-6
"""m and relative: how well the ends of a closed curve must meet, in position and direction."""
NEWTON_STEPS = 12


@dataclass(frozen=True)
class Curve:
    """``derivatives``: of the parameter, in the mission's coordinates. ``begin``, ``end``: the range of the parameter.
    ``breaks``: parameters where pieces join, which a table must not step across."""

    derivatives: Callable[[float], Derivatives]
    begin: float
    end: float
    closed: bool
    placement: Placement = field(default_factory=Placement)
    breaks: tuple[float, ...] = ()

    def placed(self, placement: Placement) -> Curve:
        """The same curve elsewhere."""
        return replace(self, placement=placement)

    def at(self, u: float) -> Derivatives:
        """gamma and four derivatives in the vehicle's local frame; ``u`` is wrapped or clamped to its range."""
        point, *rest = self.derivatives(self.within(u))
        placement = self.placement
        a, b, c, d = (placement.turned(derivative) for derivative in rest)
        return placement.to_local(point), a, b, c, d

    def within(self, u: float) -> float:
        """``u`` as a parameter of the curve."""
        if self.closed:
            return self.begin + (u - self.begin) % (self.end - self.begin)
        return min(max(u, self.begin), self.end)

    def closest(self, p_n: Vec3, u: float) -> tuple[float, Derivatives]:
        """The parameter nearest to ``p_n``, searched downhill from ``u``, and the derivatives there."""
        px, py, pz = p_n
        step_max = 0.1 * (self.end - self.begin)
        derivatives = self.at(u)
        for _ in range(NEWTON_STEPS):
            (x, y, z), (gx, gy, gz), (hx, hy, hz), _, _ = derivatives
            ex, ey, ez = px - x, py - y, pz - z
            n2 = gx * gx + gy * gy + gz * gz
            step = (gx * ex + gy * ey + gz * ez) / max(n2 - (hx * ex + hy * ey + hz * ez), 0.25 * n2)
            step = max(-step_max, min(step_max, step))
            further = u + step if self.closed else self.within(u + step)
            if abs(further - u) * math.sqrt(n2) < 1e-10:
                break
            u = further
            derivatives = self.at(u)
        return u, derivatives

    @cached_property
    def table(self) -> ArcTable:
        """The curve over its arc length, in the vehicle's local frame. PathError: it is not regular, or not closed."""
        return self._measured[0]

    def arc(self, u: float) -> float:
        """m, the arc length at ``u``."""
        _, parameters, pieces = self._measured
        u = self.within(u)
        i = min(max(bisect_right(parameters, u) - 1, 0), len(pieces) - 1)
        return self.table.knots[i] + pieces[i](u - parameters[i])

    def parameter(self, s: float) -> float:
        """The parameter at arc length ``s``."""
        table, parameters, _ = self._measured
        s = table.within(s)
        i = min(max(bisect_right(table.knots, s) - 1, 0), len(table.pieces) - 1)
        share = (s - table.knots[i]) / (table.knots[i + 1] - table.knots[i])
        u = parameters[i] + share * (parameters[i + 1] - parameters[i])
        for _ in range(NEWTON_STEPS):
            step = (s - table.knots[i] - self._measured[2][i](u - parameters[i])) / math.hypot(*self.at(u)[1])
            u += step
            if abs(step) < 1e-13 * max(1.0, abs(u)):
                break
        return u

    @cached_property
    def _measured(self) -> tuple[ArcTable, list[float], list[Callable[[float], float]]]:
        return measured(self)


def measured(curve: Curve) -> tuple[ArcTable, list[float], list[Callable[[float], float]]]:
    """The arc-length table, the parameter at each of its knots, and in each interval the arc length over the parameter.

    PathError: the curve stops, has a corner, or should be closed and is not.
    """
    span = curve.end - curve.begin
    here = _knot(curve, curve.begin)
    knots, parameters, lengths = [here], [curve.begin], [0.0]
    pieces: list[Piece] = []
    arcs: list[Callable[[float], float]] = []
    step = span / 16.0
    joins = sorted({b for b in curve.breaks if curve.begin < b < curve.end} | {curve.end})
    while parameters[-1] < curve.end:
        if len(pieces) > KNOTS_MAX or lengths[-1] > LENGTH_MAX:
            raise PathError(f"is longer than {LENGTH_MAX / 1000:g} km, or turns too often")
        u = parameters[-1]
        ahead = next(join for join in joins if join > u)
        ends = u + 1.25 * step >= ahead
        v = ahead if ends else u + step
        # the derivatives at a join belong to the piece that ends there
        there = _knot(curve, v if not ends else v - 1e-12 * span)
        arc, length = _arc_over(curve, u, v)
        turned = math.acos(max(-1.0, min(1.0, _dot(here.tangent, there.tangent))))
        piece = quintic(here, there, length)
        middle = evaluated(piece, 0.5 * length)[0]
        exact = curve.at(_solve(arc, 0.5 * length, v - u) + u)[0]
        stray = math.dist(middle, exact)
        if (
            turned > 1.5 * TURN_MAX or stray > STRAY_MAX * length + 1e-12 * math.hypot(*exact)
        ) and step > STEP_MIN * span:
            step *= 0.5
            continue
        if turned > 0.8:
            raise PathError(f"has a corner at {_place(there.point)}; expected a smooth curve")
        pieces.append(piece)
        arcs.append(arc)
        parameters.append(v)
        lengths.append(lengths[-1] + length)
        here = _knot(curve, v) if v < curve.end else there
        knots.append(here)
        if turned < 0.5 * TURN_MAX and stray < 0.03 * STRAY_MAX * length:
            step *= 1.6
    if curve.closed:
        first, last = knots[0], _knot(curve, curve.end - 1e-12 * span)
        gap = math.dist(first.point, last.point)
        if gap > CLOSED_WITHIN * max(1.0, lengths[-1]):
            raise PathError(f"does not close: its ends are {gap:.3g} m apart")
        if math.dist(first.tangent, last.tangent) > 1e-3:
            raise PathError("has a corner where it closes; expected the same direction at both ends")
    return ArcTable(tuple(lengths), tuple(pieces), curve.closed), parameters, arcs


def _knot(curve: Curve, u: float) -> Knot:
    try:
        point, g1, g2, *_ = curve.at(u) if u < curve.end else _end(curve)
    except (ValueError, ArithmeticError) as error:
        raise PathError(f"is not defined at u = {u:.4g}: {error}") from None
    n2 = _dot(g1, g1)
    if not math.isfinite(sum(point) + n2 + sum(g2)):
        raise PathError(f"is not finite at u = {u:.4g}")
    if n2 < 1e-12:
        raise PathError(f"stops at {_place(point)} (u = {u:.4g}); expected a curve that always moves on")
    n = math.sqrt(n2)
    tangent = (g1[0] / n, g1[1] / n, g1[2] / n)
    along = _dot(g2, tangent)
    x, y, z = ((g - along * t) / n2 for g, t in zip(g2, tangent, strict=True))
    return Knot(point, tangent, (x, y, z))


def _end(curve: Curve) -> Derivatives:
    return curve.at(curve.end - 1e-12 * (curve.end - curve.begin)) if curve.closed else curve.at(curve.end)


_NODES = (
    (-0.9324695142031521, 0.1713244923791704), (-0.6612093864662645, 0.3607615730481386),
    (-0.2386191860831969, 0.4679139345726910), (0.2386191860831969, 0.4679139345726910),
    (0.6612093864662645, 0.3607615730481386), (0.9324695142031521, 0.1713244923791704),
)  # fmt: skip
"""Gauss and Legendre, 6 points."""


def _arc_over(curve: Curve, u: float, v: float) -> tuple[Callable[[float], float], float]:
    """The arc length from ``u`` as a function of the parameter passed, and the whole to ``v``.

    Between, it is the integral of the cubic through the speeds at the ends and the thirds, scaled to the exact whole.
    """
    h = v - u

    def speed(share: float) -> float:
        # just inside, so that a join is seen from its own side
        return math.hypot(*curve.at(u + (1e-9 + share * (1.0 - 2e-9)) * h)[1])

    whole = 0.5 * h * sum(weight * speed(0.5 * (1.0 + node)) for node, weight in _NODES)
    a, b, c, d = speed(0.0), speed(1.0 / 3.0), speed(2.0 / 3.0), speed(1.0)
    k0, k1 = a, 0.5 * (-11.0 * a + 18.0 * b - 9.0 * c + 2.0 * d)
    k2, k3 = 4.5 * (2.0 * a - 5.0 * b + 4.0 * c - d), 4.5 * (-a + 3.0 * b - 3.0 * c + d)
    scale = whole / (h * (k0 + k1 / 2.0 + k2 / 3.0 + k3 / 4.0))

    def arc(passed: float) -> float:
        t = passed / h
        return scale * passed * (k0 + t * (k1 / 2.0 + t * (k2 / 3.0 + t * k3 / 4.0)))

    return arc, whole


def _solve(arc: Callable[[float], float], length: float, span: float) -> float:
    """The parameter passed after ``length``: a monotone function inverted."""
    low, high = 0.0, span
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if arc(middle) < length else (low, middle)
    return 0.5 * (low + high)


def analytic(gamma: Parametrisation, begin: float, end: float, closed: bool) -> Curve:
    """A curve from one formula for gamma(u). ValueError, ArithmeticError: it is nowhere defined."""
    tape = Tape()
    (u,) = tape.inputs("u")
    along = Taylor((u, 1.0, 0.0, 0.0, 0.0))
    columns = [c if isinstance(c, Taylor) else Taylor((c, 0.0, 0.0, 0.0, 0.0)) for c in gamma(along)]
    function = tape.function("gamma", [column.derivative(k) for k in range(5) for column in columns])

    def derivatives(u: float) -> Derivatives:
        v = function(u)
        return v[0:3], v[3:6], v[6:9], v[9:12], v[12:15]  # type: ignore[return-value]

    return Curve(derivatives, begin, end, closed)


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _place(p: Vec3) -> str:
    return f"north {p[0]:.2f}, east {p[1]:.2f}, height {-p[2]:.2f} m"
