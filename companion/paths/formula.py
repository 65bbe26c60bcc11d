"""A parametrisation given by one formula for gamma(u), differentiated exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from companion.calculus.expression import Expression
from companion.calculus.scalar import Scalar
from companion.calculus.straight import ArrayFunction, Function, Tape
from companion.calculus.taylor import Taylor
from companion.paths.parametrisation import Derivatives
from companion.paths.placement import Placement

Gamma = Callable[[Scalar], tuple[Scalar, Scalar, Scalar]]


@dataclass(frozen=True)
class Formula:
    """``gamma``: a point from a parameter, of any scalars. ValueError, ArithmeticError: it is nowhere defined."""

    gamma: Gamma

    def __call__(self, u: float) -> Derivatives:
        """See Parametrisation."""
        v = self._one(u)
        return v[0:3], v[3:6], v[6:9], v[9:12], v[12:15]

    def many(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """See Parametrisation."""
        return self._many(u).reshape(5, 3, len(u))

    def placed(self, placement: Placement) -> Formula:
        """See Parametrisation."""
        gamma = self.gamma
        return Formula(lambda u: placement.to_local(gamma(u)))

    @cached_property
    def _one(self) -> Function:
        tape, outputs = self._record()
        return tape.function("gamma", outputs)

    @cached_property
    def _many(self) -> ArrayFunction:
        tape, outputs = self._record()
        return tape.array_function("gamma", outputs)

    def _record(self) -> tuple[Tape, list[Scalar]]:
        tape = Tape()
        (u,) = tape.inputs("u")
        along = Taylor((u, 1.0, 0.0, 0.0, 0.0))
        columns = [c if isinstance(c, Taylor) else Taylor((c, 0.0, 0.0, 0.0, 0.0)) for c in self.gamma(along)]
        return tape, [column.derivative(k) for k in range(5) for column in columns]


def written(x: Expression, y: Expression, z: Expression, constants: Mapping[str, float]) -> Formula:
    """gamma(u) as a mission writes it: expressions in u and the constants."""

    def gamma(u: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        values = {**constants, "u": u}
        return x(values), y(values), z(values)

    return Formula(gamma)
