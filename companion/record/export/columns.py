"""A column of a recorded table as text: its unit, and its numbers with enough digits and no NaN."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UNITS = frozenset({"m", "m/s", "m/s^2", "rad", "rad/s", "s", "Hz", "N", "N/s", "1/s"})
DIGITS = 9
"""Significant digits: a millimetre in 100 km, a microsecond in 1000 s (engineering choice)."""
CLOCK_DECIMALS = 6
"""Of a time in s: microseconds."""


def unit_of(meaning: str) -> str:
    """The unit that a column's meaning begins with ("m/s, velocity", "Hz of states"); empty where it has none."""
    first = meaning.partition(" ")[0].rstrip(",")
    return first if first in UNITS else ""


def as_numbers(values: NDArray[Any], missing: str, decimals: int | None = None) -> list[str]:
    """Each value as text, ``missing`` where it is not finite. ``decimals``: behind the point, where it is a clock."""
    if values.dtype.kind in "iub":
        return list(map(str, values.tolist()))
    digits = f".{DIGITS}g" if decimals is None else f".{decimals}f"
    if np.isfinite(values).all():
        return [format(value, digits) for value in values.tolist()]
    finite = np.isfinite(values).tolist()
    return [format(value, digits) if known else missing for value, known in zip(values.tolist(), finite, strict=True)]
