"""Units that are likely to be mixed up: said before they fly."""

from __future__ import annotations

import math
from typing import Any

from companion.config.syntax.faults import Key

_MIXED_UP = (
    ("_s", 1000.0, "ms", 0.001),
    ("_m", 1000.0, "mm", 0.01),
    ("_kg", 1000.0, "g", 0.05),
    ("_deg", 1e7, "1e-7 degrees", 1.0),
    ("lat", 1e7, "1e-7 degrees", 1.0),
    ("lon", 1e7, "1e-7 degrees", 1.0),
    *((name, 100.0, "percent", 0.05) for name in ("hover_thrust", "loss", "duplicated", "reordered", "charge")),
)
"""End of a key, how many of the other unit are one, its name, and the least that makes sense."""
RADIANS_WITHIN = 6e-4
"""How near to a multiple of 45 degrees in radians a number looks like one."""


def unit_hint(key: Key, given: Any, limit: float) -> str:
    """A question where a number that is too large would fit in another unit; nothing elsewhere."""
    name = next((part for part in reversed(key) if isinstance(part, str)), "")
    if not isinstance(given, int | float):
        return ""
    for end, many, unit, least in _MIXED_UP:
        if name.endswith(end) and least <= abs(given) / many <= abs(limit):
            return f" (in {unit}? {given / many:g} would fit)"
    return ""


def not_radians(degrees: float) -> float:
    """``degrees``. ValueError: it looks like an angle in radians."""
    eighths = degrees / (math.pi / 4.0)
    if 0 < abs(round(eighths)) <= 8 and abs(degrees - round(eighths) * math.pi / 4.0) < RADIANS_WITHIN:
        raise ValueError(f"{degrees:g} looks like radians; expected degrees, {round(eighths) * 45:g} perhaps")
    return degrees
