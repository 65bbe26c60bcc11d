"""What several messages are made of."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.frames import Quaternion
from companion.mavlink.dialect import Value
from sim_bridge.autopilot.autopilot import Autopilot

Values = tuple[Value, ...]
"""The values of a message, flat and in wire order."""
Build = Callable[[Autopilot], Values | None]
"""Fills a message; None: there is nothing to send now."""

NAN = math.nan


def int16(value: float) -> int:
    """The nearest whole number that fits."""
    return round(value) if -32768.0 < value < 32767.0 else 32767 if value > 0.0 else -32768


def int32(value: float) -> int:
    """The nearest whole number that fits."""
    return round(value) if -2147483648.0 < value < 2147483647.0 else 2147483647 if value > 0.0 else -2147483648


def uint16(value: float) -> int:
    """The nearest whole number that fits."""
    return round(value) if 0.0 < value < 65535.0 else 65535 if value > 0.0 else 0


def degrees_e7(latitude: float, longitude: float) -> tuple[int, int]:
    """Latitude and longitude in 1e-7 degrees."""
    return round(latitude * 1e7), round(longitude * 1e7)


def heading_of(q: Quaternion) -> float:
    """The heading (rad, clockwise from north) of an attitude."""
    w, x, y, z = q
    return math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))


def level(heading: float) -> Quaternion:
    """The attitude without tilt that points to ``heading`` (rad)."""
    return (math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading))


def place(a: Autopilot) -> tuple[int, int]:
    """Where the vehicle thinks it is, in 1e-7 degrees."""
    return degrees_e7(*a.projection.reproject(*a.estimate.p_n[:2]))


def altitude_of(a: Autopilot) -> float:
    """m above the sea."""
    return a.home.altitude - a.estimate.p_n[2]


def pressure_at(altitude: float) -> float:
    """hPa of the standard atmosphere at an altitude (m above the sea)."""
    base = 1.0 - 2.25577e-5 * altitude
    return 1013.25 * float(base**5.25588) if base > 0.0 else 0.0
