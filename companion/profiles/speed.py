"""alpha: how fast, over displacement (Def. 3.2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from companion.calculus.expression import Expression
from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function
from companion.profiles.over_arc import ArcProfile, Four, over_arc

Variables = Mapping[str, Scalar]
"""What a mission's expressions may name: x, y, z (implicit paths) or s (curves), and its constants."""


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
        return self._over_arc(s)

    @cached_property
    def _over_arc(self) -> Function:
        return over_arc(lambda s: self.expression({**self.constants, "s": s}))


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """A speed in pieces over arc length: a table's, or what ``auto`` came to. m/s."""

    profile: ArcProfile

    def at(self, s: float) -> Four:
        """See SpeedOverArc."""
        return self.profile.at(s)


@dataclass(frozen=True, slots=True)
class AutoSpeed:
    """The fastest speed that keeps the vehicle's limits: not a speed yet, but what one is made of for a vehicle.

    ``direction``: +1 along mu, -1 against. ``speed_max``: m/s, or None for the vehicle's own. ``margin``: the share of
    every limit that may be used. ``caps``: (arc length m, speed m/s): from there on no faster than that, in their
    order; empty for none.
    """

    direction: float = 1.0
    speed_max: float | None = None
    margin: float = 0.9
    caps: tuple[tuple[float, float], ...] = ()

    def at(self, s: float) -> Four:
        """ValueError: it is not a speed yet."""
        raise ValueError("the fastest speed is not known before the vehicle is")


Speed = ConstantSpeed | SpeedExpression | SpeedProfile | AutoSpeed
