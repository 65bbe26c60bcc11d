"""A path given by a parametrisation gamma(u): any regular curve, closed or open, in any parameter.

The law needs gamma and its derivatives at a parameter; everybody else needs arc length. A Curve answers both: its
``table`` is the curve over its arc length, and ``parameter`` and ``arc`` go from one to the other. A shape is measured
once, wherever it is then placed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from companion.frames import Vec3
from companion.paths.arc import ArcTable
from companion.paths.formula import Formula, Gamma
from companion.paths.measuring import ArcMap, measured, over_arc
from companion.paths.parametrisation import Derivatives, Parametrisation
from companion.paths.placement import Placement
from companion.paths.tracing import PathError

NEWTON_STEPS = 12
"""at most, to the nearest parameter."""
REACH = 3.0
"""m along the curve that the closest point may lie from where it is sought, and as much again as the curve is away: a
curve that crosses itself is not left for its other branch."""


@dataclass(frozen=True)
class Shape:
    """A curve in the mission's coordinates. ``begin``, ``end``: the range of the parameter. ``breaks``: parameters
    where pieces join, which a table must not step across."""

    parametrisation: Parametrisation
    begin: float
    end: float
    closed: bool
    breaks: tuple[float, ...] = ()

    @cached_property
    def measured(self) -> tuple[ArcTable, ArcMap]:
        """Its table, and the way between parameter and arc length. PathError: it is not regular, or does not close."""
        try:
            return measured(self.parametrisation.many, self.begin, self.end, self.closed, self.breaks)
        except (ValueError, ArithmeticError) as error:
            raise PathError(f"is nowhere defined: {error}") from None


@dataclass(frozen=True)
class Curve:
    """A shape, placed in the vehicle's local frame."""

    shape: Shape
    placement: Placement = field(default_factory=Placement)

    @property
    def closed(self) -> bool:
        """Whether its end is its beginning."""
        return self.shape.closed

    def placed(self, placement: Placement) -> Curve:
        """The same curve elsewhere."""
        return self if placement == self.placement else replace(self, placement=placement)

    def at(self, u: float) -> Derivatives:
        """gamma and four derivatives in the vehicle's local frame; ``u`` is wrapped or clamped to its range."""
        return self._local(self.within(u))

    def within(self, u: float) -> float:
        """``u`` as a parameter of the curve."""
        begin, end = self.shape.begin, self.shape.end
        return begin + (u - begin) % (end - begin) if self.shape.closed else min(max(u, begin), end)

    def closest(self, p_n: Vec3, u: float) -> tuple[float, Derivatives]:
        """The parameter nearest to ``p_n``, searched downhill from ``u``, and the derivatives there."""
        px, py, pz = p_n
        derivatives = self.at(u)
        (x, y, z), (gx, gy, gz), *_ = derivatives
        reach = (REACH + math.dist(p_n, (x, y, z))) / math.sqrt(gx * gx + gy * gy + gz * gz)
        low, high = u - reach, u + reach
        if not self.shape.closed:
            low, high = max(low, self.shape.begin), min(high, self.shape.end)
        for _ in range(NEWTON_STEPS):
            (x, y, z), (gx, gy, gz), (hx, hy, hz), _, _ = derivatives
            ex, ey, ez = px - x, py - y, pz - z
            n2 = gx * gx + gy * gy + gz * gz
            # past the evolute the nearest point is not near any more; the floor keeps the step downhill
            step = (gx * ex + gy * ey + gz * ez) / max(n2 - (hx * ex + hy * ey + hz * ez), 0.25 * n2)
            further = max(low, min(high, u + step))
            if abs(further - u) * math.sqrt(n2) < 1e-10:
                break
            u = further
            derivatives = self.at(u)
        return u, derivatives

    @cached_property
    def table(self) -> ArcTable:
        """The curve over its arc length, in the vehicle's local frame. PathError: it is not regular, or not closed."""
        table = self.shape.measured[0]
        return table if self.placement == Placement() else table.moved(self.placement)

    def arc(self, u: float) -> float:
        """m, the arc length at ``u``."""
        table, arc_map = self.shape.measured
        return arc_map.arc(self.within(u), table.knots)

    def parameter(self, s: float) -> float:
        """The parameter at arc length ``s``."""
        table, arc_map = self.shape.measured
        return arc_map.parameter(table.within(s), table.knots)

    def over_arc(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """gamma and its first four derivatives over arc length, at many: shape (5, 3, len(s)), local frame."""
        u = np.array([self.parameter(float(x)) for x in s])
        return over_arc(self._local.many(u))

    @cached_property
    def _local(self) -> Parametrisation:
        return self.shape.parametrisation.placed(self.placement)


def analytic(gamma: Gamma, begin: float, end: float, closed: bool) -> Curve:
    """A curve from one formula for gamma(u)."""
    return Curve(Shape(Formula(gamma), begin, end, closed))
