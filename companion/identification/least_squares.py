"""Nonlinear least squares whose standard deviations count that neighbouring residuals err alike.

The residuals of a flight are not white: gusts, vibration and the vehicle's estimate last. So the covariance of the
parameters is the sandwich (J'J)^-1 S (J'J)^-1, where S sums the scores over blocks of seconds rather than samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP_OF_SCALE = 1e-4
"""Ratio to a parameter's scale: how far it is moved to see what the residuals do (engineering choice). A step in
proportion to the value itself would be lost in rounding where the value is near 0."""

AT_BOUND = 1e-3
"""Ratio to a parameter's scale: nearer to a bound than this the search was stopped by it (engineering choice)."""


class Fitted(NamedTuple):
    """``values`` and their standard deviations ``std``, infinite where a value was not found: where the residuals do
    not know of it, or want it beyond its bounds."""

    values: Array
    std: Array


def fit(
    residuals: Callable[[Array], Array], blocks: NDArray[np.int64], start: Sequence[float], low: Sequence[float],
    high: Sequence[float], scale: Sequence[float], actual: Callable[[Array], Array] | None = None,
) -> Fitted:  # fmt: skip
    """The parameters between ``low`` and ``high`` with the least squares. ``blocks``: of each residual, which block it
    belongs to; priors have blocks of their own. ``scale``: the usual size of each parameter. ``actual``: the residuals
    whose spread counts, where ``residuals`` are those of projected data (two-stage least squares)."""
    from scipy.optimize import least_squares

    def slopes(values: Array) -> Array:
        return _jacobian(residuals, values, high, scale)

    found = least_squares(residuals, np.clip(start, low, high), slopes, bounds=(low, high), x_scale=scale, max_nfev=100)
    J = found.jac
    r = found.fun if actual is None else actual(found.x)
    inverse = np.linalg.pinv(J.T @ J)
    scores = np.zeros((int(blocks.max()) + 1, J.shape[1]))
    np.add.at(scores, blocks, J * r[:, None])
    covariance = inverse @ (scores.T @ scores) @ inverse
    # few blocks say little of their spread: what white residuals would give is the least
    white = inverse * float(r @ r) / max(1, len(r) - len(found.x))
    std = np.sqrt(np.maximum(np.maximum(np.diag(covariance), np.diag(white)), 0.0))
    room = np.minimum(found.x - np.asarray(low), np.asarray(high) - found.x)
    std[~J.any(axis=0) | (room < AT_BOUND * np.asarray(scale))] = np.inf
    return Fitted(np.asarray(found.x), std)


def _jacobian(
    residuals: Callable[[Array], Array], values: Array, high: Sequence[float], scale: Sequence[float]
) -> Array:
    """One column a parameter, by a step of STEP_OF_SCALE; at the upper bound the step goes inward."""
    here = residuals(values)
    columns = []
    for i, size in enumerate(scale):
        step = STEP_OF_SCALE * size
        if values[i] + step > high[i]:
            step = -step
        moved = values.copy()
        moved[i] += step
        columns.append((residuals(moved) - here) / step)
    return np.column_stack(columns)
