"""The fit of both: what it finds, and how sure of it it is."""

from __future__ import annotations

import numpy as np
import pytest

from companion.identification.least_squares import Array, fit

T = np.linspace(0.0, 10.0, 2001)
"""s: of the samples."""
BLOCKS = (T / 0.05).astype(np.int64)
NOISE = np.random.default_rng(5).normal(0.0, 0.3, len(T))


def slope_fitted(true: float, low: float, high: float, start: float = 0.3) -> tuple[float, float]:
    """The slope of a line in noise, and its standard deviation."""
    seen = true * T + NOISE

    def misses(theta: Array) -> Array:
        assert low <= theta[0] <= high, "looked beyond its bounds"
        return theta[0] * T - seen

    found = fit(misses, BLOCKS, (start,), (low,), (high,), (0.3,))
    return float(found.values[0]), float(found.std[0])


@pytest.mark.parametrize("true", [0.2, 1e-3, -1e-4])
def test_a_slope_is_as_sure_near_nothing_as_elsewhere(true: float) -> None:
    white = 0.3 / float(np.sqrt(np.sum(T**2)))
    value, std = slope_fitted(true, -1.0, 1.0)
    assert value == pytest.approx(true, abs=4.0 * white)
    assert std > 0.7 * white, f"{value} +- {std}: white noise alone leaves {white}"


@pytest.mark.parametrize("true", [-0.05, 1.5])
def test_a_value_at_its_bound_is_not_found(true: float) -> None:
    value, std = slope_fitted(true, 0.0, 1.0)
    assert value == pytest.approx(np.clip(true, 0.0, 1.0), abs=1e-3) and std == float("inf")
