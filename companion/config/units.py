"""Units that are likely to be mixed up: said before they fly."""

from __future__ import annotations

import math
from typing import Any

from companion.config.faults import Key

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
OTHER_INERTIAS = ((1e4, "kg cm^2"), (1e7, "g cm^2"))
"""How many of another unit are a kg m^2."""


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


def plausible_inertia(inertia: list[float], mass: float, arm: float) -> None:
    """ValueError: no body of ``mass`` kg with rotors ``arm`` m from its centre has such moments of inertia."""
    radius = math.sqrt(max(inertia) / mass)
    if radius > 3.0 * arm:
        others = [unit for many, unit in OTHER_INERTIAS if math.sqrt(max(inertia) / many / mass) < arm]
        hint = f"; are they in {others[0]}?" if others else ""
        size = f"would be a body of {2.0 * radius:.2g} m, and its rotors are {arm:.2g} m from its centre"
        raise ValueError(f"{inertia} kg m^2 {size}{hint}")
    if radius < 0.02 * arm:
        raise ValueError(f"{inertia} kg m^2 would be a body of {2000.0 * radius:.2g} mm; expected more, in kg m^2")
