"""What every parametrisation gamma(u) answers, whatever it is made of."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from companion.frames import Vec3
from companion.paths.placement import Placement

Derivatives = tuple[Vec3, Vec3, Vec3, Vec3, Vec3]
"""gamma and its first four derivatives over the parameter."""


class Parametrisation(Protocol):
    """A curve as a function of a parameter, C^4."""

    def __call__(self, u: float) -> Derivatives:
        """gamma and its derivatives at ``u``. ValueError, ArithmeticError: not defined there."""

    def many(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same at many parameters: shape (5 derivatives, 3 coordinates, len(u)); nan where not defined."""

    def placed(self, placement: Placement) -> Parametrisation:
        """The same curve in the vehicle's local frame, its own coordinates being those of a mission."""
