"""A parametrisation in polynomial pieces: as quick to evaluate with ten thousand pieces as with ten."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from companion.calculus.scalar import Scalar
from companion.calculus.straight import ArrayFunction, Function, Tape
from companion.paths.parametrisation import Derivatives
from companion.paths.placement import Placement

Coefficients = NDArray[np.float64]
"""Of one piece: 3 rows (x, y, z), highest power of u - knot first."""


@dataclass(frozen=True, eq=False)
class Piecewise:
    """``knots``: parameters, rising, one more than there are ``pieces``. Neighbours must join C^4."""

    knots: tuple[float, ...]
    pieces: tuple[Coefficients, ...]

    def __call__(self, u: float) -> Derivatives:
        """See Parametrisation. Before the first knot and after the last the end pieces go on."""
        i = min(max(bisect_right(self.knots, u) - 1, 0), len(self.pieces) - 1)
        function, coefficients = self._flat[i]
        v = function(u - self.knots[i], *coefficients)
        return v[0:3], v[3:6], v[6:9], v[9:12], v[12:15]

    def many(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """See Parametrisation."""
        index = np.clip(np.searchsorted(self.knots, u, side="right") - 1, 0, len(self.pieces) - 1)
        offset = u - np.array(self.knots)[index]
        sizes = np.array([piece.shape[1] for piece in self.pieces])
        values = np.empty((15, len(u)))
        for size in np.unique(sizes):
            row_of = np.cumsum(sizes == size) - 1
            rows = np.stack([piece.ravel() for piece in self.pieces if piece.shape[1] == size])
            mine = np.flatnonzero(sizes[index] == size)
            coefficients = rows[row_of[index[mine]]].T
            values[:, mine] = _of_degree(int(size) - 1)[1](offset[mine], *coefficients)
        return values.reshape(5, 3, len(u))

    def placed(self, placement: Placement) -> Piecewise:
        """See Parametrisation."""
        axes = np.array([placement.turned(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]).T
        pieces = [axes @ piece for piece in self.pieces]
        for piece in pieces:
            piece[:, -1] += placement.origin_n
        return Piecewise(self.knots, tuple(pieces))

    @cached_property
    def _flat(self) -> list[tuple[Function, tuple[float, ...]]]:
        return [(_of_degree(piece.shape[1] - 1)[0], tuple(map(float, piece.ravel()))) for piece in self.pieces]


@cache
def _of_degree(degree: int) -> tuple[Function, ArrayFunction]:
    """(u, 3 x (degree + 1) coefficients) -> gamma and four derivatives: Horner's scheme, repeated."""
    tape = Tape()
    (u,) = tape.inputs("u")
    rows = [list(tape.inputs(*(f"{axis}{i}" for i in range(degree, -1, -1)))) for axis in "xyz"]
    derivatives = [_horner(row, u) for row in rows]
    outputs = [derivatives[axis][k] for k in range(5) for axis in range(3)]
    return tape.function("pieces", outputs), tape.array_function("pieces", outputs)


def _horner(coefficients: Sequence[Scalar], u: Scalar) -> list[Scalar]:
    """The polynomial and its first four derivatives."""
    row = list(coefficients)
    values: list[Scalar] = []
    factorial = 1.0
    for k in range(5):
        for i in range(1, len(row)):
            row[i] = row[i] + row[i - 1] * u
        values.append(row.pop() * factorial if row else 0.0)
        factorial *= k + 1
    return values
