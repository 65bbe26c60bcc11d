"""Speed and yaw along a path: the paper's alpha (Def. 3.2) and beta (Def. 3.3).

Both are functions of where the vehicle is, never of time. They evaluate on floats and on any other scalars, so that the
law can differentiate them. ``variables`` are what a mission's expressions may name at a point: x, y, z of the mission
and its constants.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from companion.calculus.expression import Expression
from companion.calculus.scalar import Scalar, atan2
from companion.frames import Vec3

Variables = Mapping[str, Scalar]
Triple = tuple[Scalar, Scalar, Scalar]


@dataclass(frozen=True, slots=True)
class ConstantSpeed:
    """The same speed everywhere, m/s; negative runs against mu."""

    speed: float

    def value(self, variables: Variables) -> Scalar:
        """alpha, m/s."""
        return self.speed


@dataclass(frozen=True, slots=True)
class SpeedExpression:
    """An expression for the speed in m/s."""

    expression: Expression

    def value(self, variables: Variables) -> Scalar:
        """alpha, m/s."""
        return self.expression(variables)


Speed = ConstantSpeed | SpeedExpression


@dataclass(frozen=True, slots=True)
class ConstantYaw:
    """One heading, rad clockwise from north."""

    heading: float

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return self.heading


@dataclass(frozen=True, slots=True)
class YawExpression:
    """An expression for the heading in degrees clockwise from north."""

    expression: Expression

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return self.expression(variables) * (math.pi / 180.0)


@dataclass(frozen=True, slots=True)
class TangentYaw:
    """The heading of travel, plus ``offset`` rad. Undefined where the path is vertical."""

    offset: float = 0.0

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return atan2(travel_n[1], travel_n[0]) + self.offset


@dataclass(frozen=True, slots=True)
class LookAt:
    """The heading towards a point of the local frame. Undefined straight above and below it."""

    target_n: Vec3

    def value(self, variables: Variables, p_n: Triple, travel_n: Triple) -> Scalar:
        """beta, rad."""
        return atan2(self.target_n[1] - p_n[1], self.target_n[0] - p_n[0])


Yaw = ConstantYaw | YawExpression | TangentYaw | LookAt
