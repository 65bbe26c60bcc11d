"""Speed and yaw along a path: the paper's alpha (Def. 3.2) and beta (Def. 3.3).

Both are functions of where the vehicle is, never of time. On an implicit path they are expressions in x, y, z of the
mission; on a curve they are functions of the arc length s. All evaluate on floats and on any other scalars, so that the
law can differentiate them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from companion.calculus.expression import Expression
from companion.calculus.scalar import Scalar, atan2
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor
from companion.frames import Vec3

Variables = Mapping[str, Scalar]
"""What a mission's expressions may name: x, y, z (implicit paths) or s (curves), and its constants."""
Triple = tuple[Scalar, Scalar, Scalar]
Four = tuple[float, float, float, float]


class SpeedOverArc(Protocol):
    """A speed as a function of arc length."""

    def at(self, s: float) -> Four:
        """alpha m/s and its first three derivatives over s at arc length ``s``."""


@dataclass(frozen=True, slots=True)
class ConstantSpeed:
    """The same speed everywhere, m/s; negative runs against mu."""

    speed: float

    def value(self, variables: Variables) -> Scalar:
        """alpha, m/s."""
        return self.speed

    def at(self, s: float) -> Four:
        """See SpeedOverArc."""
        return (self.speed, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SpeedExpression:
    """An expression for the speed in m/s. ``constants``: what it may name beside x, y, z or s."""

    expression: Expression
    constants: Mapping[str, float]

    def value(self, variables: Variables) -> Scalar:
        """alpha, m/s."""
        return self.expression(variables)

    def at(self, s: float) -> Four:
        """See SpeedOverArc."""
        return self._over_arc(s)  # type: ignore[return-value]

    @cached_property
    def _over_arc(self) -> Function:
        return over_arc(lambda s: self.expression({**self.constants, "s": s}))


Speed = ConstantSpeed | SpeedExpression


@dataclass(frozen=True)
class ConstantYaw:
    """One heading, rad clockwise from north."""

    heading: float

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return self.heading

    def at(self, s: float) -> Four:
        """beta, rad, and its first three derivatives over s."""
        return (self.heading, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class YawExpression:
    """An expression for the heading in degrees clockwise from north."""

    expression: Expression
    constants: Mapping[str, float]

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return self.expression(variables) * (math.pi / 180.0)

    def at(self, s: float) -> Four:
        """beta, rad, and its first three derivatives over s."""
        return self._over_arc(s)  # type: ignore[return-value]

    @cached_property
    def _over_arc(self) -> Function:
        return over_arc(lambda s: self.expression({**self.constants, "s": s}) * (math.pi / 180.0))


@dataclass(frozen=True)
class TangentYaw:
    """The heading of travel, plus ``offset`` rad. Undefined where the path is vertical."""

    offset: float = 0.0

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return atan2(travel_n[1], travel_n[0]) + self.offset


@dataclass(frozen=True)
class LookAt:
    """The heading towards a point of the local frame. Undefined straight above and below it."""

    target_n: Vec3

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return atan2(self.target_n[1] - p_n[1], self.target_n[0] - p_n[0])


Yaw = ConstantYaw | YawExpression | TangentYaw | LookAt


def over_arc(function: Callable[[Scalar], Scalar]) -> Function:
    """Records f(s) and its first three derivatives. ValueError, ArithmeticError: it is nowhere defined."""
    tape = Tape()
    (s,) = tape.inputs("s")
    value = function(Taylor((s, 1.0, 0.0, 0.0)))
    series = value if isinstance(value, Taylor) else Taylor((value, 0.0, 0.0, 0.0))
    return tape.function("over_arc", [series.derivative(k) for k in range(4)])
