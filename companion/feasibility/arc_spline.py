"""A quintic spline over arc length, linear in its coefficients: the matrices that give it and three derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix, diags_array

Array = NDArray[np.float64]
DEGREE = 5
"""of the spline of the squared speed: alpha is then C^3 and more, as the law asks."""


@dataclass(frozen=True)
class ArcSpline:
    """``knots``: m, from end to end. ``period``: the length of a closed path, where the spline goes over into itself;
    None where it is open."""

    knots: Array
    period: float | None

    @property
    def count(self) -> int:
        """How many coefficients it has."""
        return len(self.knots) - 1 + (0 if self.period is not None else DEGREE)

    @property
    def sites(self) -> Array:
        """m, where each coefficient has its say (Greville's abscissae)."""
        t = self._extended
        sites = np.array([t[i + 1 : i + 1 + DEGREE].mean() for i in range(self.count)])
        result: Array = (
            sites % self.period if self.period is not None else np.clip(sites, self.knots[0], self.knots[-1])
        )
        return result

    @property
    def _extended(self) -> Array:
        k = self.knots
        if self.period is not None:
            return np.concatenate([k[-1 - DEGREE : -1] - self.period, k, k[1 : 1 + DEGREE] + self.period])
        # beyond the ends at the distances found inside them
        before, after = 2.0 * k[0] - k[DEGREE:0:-1], 2.0 * k[-1] - k[-2 : -2 - DEGREE : -1]
        return np.concatenate([before, k, after])

    def matrices(self, s: Array) -> list[csr_matrix]:
        """Coefficients -> the spline and its first three derivatives at ``s``, each (len(s), count)."""
        t = self._extended
        size = len(t) - DEGREE - 1
        to_derivative = diags_array(np.ones(size)).tocsr()
        found = []
        for order in range(4):
            degree = DEGREE - order
            inner = t[order : len(t) - order]
            found.append(csr_matrix(BSpline.design_matrix(s, inner, degree) @ to_derivative))
            # the derivative of a B-spline has the differences of its coefficients
            size = to_derivative.shape[0]
            width = inner[degree + 1 : degree + size] - inner[1:size]
            ends = [np.full(size - 1, -1.0), np.full(size - 1, 1.0)]
            difference = diags_array(ends, offsets=[0, 1], shape=(size - 1, size)).tocsr()
            to_derivative = diags_array(degree / width).tocsr() @ difference @ to_derivative
        if self.period is None:
            return found
        rows = np.arange(len(t) - DEGREE - 1)
        wrapped = csr_matrix((np.ones(len(rows)), (rows, rows % self.count)), shape=(len(rows), self.count))
        return [csr_matrix(matrix @ wrapped) for matrix in found]
