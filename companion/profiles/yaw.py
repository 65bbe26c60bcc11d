"""beta: facing where, over displacement (Def. 3.3)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from companion.calculus.expression import Expression
from companion.calculus.scalar import Scalar, atan2
from companion.calculus.straight import Function
from companion.frames import Vec3
from companion.profiles.over_arc import ArcProfile, Four, over_arc
from companion.profiles.speed import Variables

Triple = tuple[Scalar, Scalar, Scalar]


@dataclass(frozen=True, slots=True)
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
        return self._over_arc(s)

    @cached_property
    def _over_arc(self) -> Function:
        return over_arc(lambda s: self.expression({**self.constants, "s": s}) * (math.pi / 180.0))


@dataclass(frozen=True, slots=True)
class YawProfile:
    """A heading in pieces over arc length, rad: it may go round and round."""

    profile: ArcProfile

    def at(self, s: float) -> Four:
        """beta, rad, and its first three derivatives over s."""
        return self.profile.at(s)


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


YawOverArc = ConstantYaw | YawExpression | YawProfile
"""What has ``at``."""
Yaw = ConstantYaw | YawExpression | YawProfile | TangentYaw | LookAt
