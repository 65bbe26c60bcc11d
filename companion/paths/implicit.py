"""A path given as in the paper's Definition 3.1: the points where h1(X) = h2(X) = 0."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

from companion.calculus.expression import Expression, parse
from companion.calculus.scalar import Scalar
from companion.frames import Vec3
from companion.paths.arc import ArcTable
from companion.paths.placement import Placement
from companion.paths.tracing import PathError, trace_curve

VARIABLES = ("x", "y", "z")


@dataclass(frozen=True)
class ImplicitPath:
    """``h1``, ``h2``: expressions in x, y, z of the mission and ``constants``. ``near``: a point of the mission near
    the component that is meant; None where only the law is wanted."""

    h1: Expression
    h2: Expression
    near: Vec3 | None
    constants: Mapping[str, float] = field(default_factory=dict)
    placement: Placement = field(default_factory=Placement)

    def variables(self, p_n: tuple[Scalar, Scalar, Scalar]) -> dict[str, Scalar]:
        """What an expression may name at a point of the vehicle's local frame; floats or any other scalars."""
        return {**self.constants, **dict(zip(VARIABLES, self.placement.to_mission(p_n), strict=True))}

    def h(self, p_n: tuple[Scalar, Scalar, Scalar]) -> tuple[Scalar, Scalar]:
        """(h1, h2) at a point of the vehicle's local frame."""
        values = self.variables(p_n)
        return self.h1(values), self.h2(values)

    @cached_property
    def table(self) -> ArcTable:
        """The curve in the vehicle's local frame, its arc length counted along mu from the point nearest to ``near``.
        PathError: h1 = h2 = 0 is no path there."""
        if self.near is None:
            raise PathError("is not known to lie anywhere: no point near it is given")
        constants = tuple(sorted(self.constants.items()))
        return _traced(self.h1.text, self.h2.text, self.near, constants, self.placement)


@lru_cache(maxsize=16)
def _traced(
    h1: str, h2: str, near: Vec3, constants: tuple[tuple[str, float], ...], placement: Placement
) -> ArcTable:  # fmt: skip
    """Once for many flights along the same path."""
    path = ImplicitPath(parse(h1, None), parse(h2, None), near, dict(constants), placement)
    return trace_curve(path.h, placement.to_local(near))
