"""Fewer points to draw, the same picture. Never used for figures, only for drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
POINTS = 1600
"""About as many as a figure has pixels, twice over."""


def kept(*curves: Array, points: int = POINTS) -> NDArray[np.intp]:
    """Indices to draw of curves over a common axis: of every stretch the least and the greatest of each curve, so that
    no spike is lost."""
    count = len(curves[0])
    if count <= points:
        return np.arange(count)
    buckets = max(1, points // (2 * len(curves)))
    width = -(-count // buckets)
    starts = np.arange(0, count, width)
    chosen = [np.array([0, count - 1])]
    for curve in curves:
        # the last stretch may be short; what fills it up is never chosen
        filled = np.full(len(starts) * width, np.nan)
        filled[:count] = curve
        grid = filled.reshape(len(starts), width)
        chosen.append(starts + np.argmin(np.where(np.isnan(grid), np.inf, grid), axis=1))
        chosen.append(starts + np.argmax(np.where(np.isnan(grid), -np.inf, grid), axis=1))
    return np.unique(np.minimum(np.concatenate(chosen), count - 1))


def along(points: Array, count: int = POINTS) -> NDArray[np.intp]:
    """Indices to draw of a track in space, rows of ``points``: evenly along its length, so that neither a hover nor a
    dash gets more than its share."""
    if len(points) <= count:
        return np.arange(len(points))
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if walked[-1] == 0.0:
        return np.array([0, len(points) - 1])
    return np.unique(np.searchsorted(walked, np.linspace(0.0, walked[-1], count)).clip(0, len(points) - 1))
