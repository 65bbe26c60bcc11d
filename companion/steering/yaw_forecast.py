"""Yaw forecast: the yaw rates that the heading will ask for as the path goes on.

A vehicle that leans has to yaw even for a heading that stays. With the roll phi and the pitch theta of the thrust that
the path takes, and the heading psi asked for there,

    r = psi' cos(theta) cos(phi) - theta' sin(phi)               heading: the yaw of the ZYX angles
    r = psi' - (x y' - y x') / (1 + z)                           heading: the twist; (x, y, z) the thrust axis, down
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

from companion.frames import Heading, Vec3, wrap
from companion.steering.speed_governor import Capability, Course, Place

FORECAST_STEP = 0.1
"""s between the moments of a forecast. Engineering choice: a bend of a figure-eight is 0.6 s long."""
FORECAST_LENGTH = 5
"""Number of moments. Engineering choice: a yaw loop that knows 0.3 s ahead does nearly as well as one that knows a
second (bends of a figure-eight at 3 m/s and of a circle at 7 m/s)."""
SIZE_MIN = 1e-6
"""m/s^2, of a thrust that has a direction. Engineering choice: any that is no rounding."""
UPSIDE_DOWN = 0.1
"""Number: the least 1 + z that is divided by. Engineering choice: a tilt of 154 deg."""

Forecast = tuple[float, ...]
"""rad/s, at FORECAST_LENGTH moments."""


def rate_at(forecast: Forecast, t: float) -> float:
    """rad/s, ``t`` s after its first moment."""
    i = min(max(math.floor(t / FORECAST_STEP), 0), FORECAST_LENGTH - 2)
    return forecast[i] + (t / FORECAST_STEP - i) * (forecast[i + 1] - forecast[i])


class Leaning(NamedTuple):
    """An attitude. ``axis``: the body's down, world frame. ``heading``: rad."""

    axis: Vec3
    heading: float


def forecast_yaw_rates(course: Course, s: float, scale: float, capability: Capability, heading: Heading) -> Forecast:
    """The yaw rates of a vehicle that is on the path, at arc length ``s`` (m) now, and flies it at ``scale`` times the
    mission's speed."""
    way = course.direction if scale >= 0.0 else -course.direction
    step = way * course.speed(s) * abs(scale) * FORECAST_STEP
    attitudes = [
        _attitude(course.at(s + (k - 0.5) * step), abs(scale), way, capability) for k in range(FORECAST_LENGTH + 1)
    ]
    rate = _projected_rate if heading is Heading.PROJECTED else _twist_rate
    return tuple(rate(a, b) for a, b in pairwise(attitudes))


def _attitude(place: Place, scale: float, way: float, capability: Capability) -> Leaning:
    (kx, ky, kz), (tx, ty, tz), (dx, dy, dz) = place.curvature, place.tangent, capability.disturbance_n
    v = place.speed * scale
    v2, along = v * v, v * (place.speed_slope * scale + capability.drag * way)
    # gravity and disturbance less acceleration and drag: what the thrust has to carry
    x, y, z = dx - kx * v2 - tx * along, dy - ky * v2 - ty * along, capability.gravity + dz - kz * v2 - tz * along
    size = max(math.sqrt(x * x + y * y + z * z), SIZE_MIN)
    return Leaning((x / size, y / size, z / size), place.heading)


def _projected_rate(a: Leaning, b: Leaning) -> float:
    """rad/s, of the yaw between attitudes FORECAST_STEP apart."""
    pitch_a, across_a = _pitch_and_sine_of_roll(a)
    pitch_b, across_b = _pitch_and_sine_of_roll(b)
    turned = 0.5 * (a.axis[2] + b.axis[2]) * wrap(b.heading - a.heading)
    return (turned - 0.5 * (across_a + across_b) * wrap(pitch_b - pitch_a)) / FORECAST_STEP


def _pitch_and_sine_of_roll(leaning: Leaning) -> tuple[float, float]:
    (x, y, z), psi = leaning
    c, s = math.cos(psi), math.sin(psi)
    return math.atan2(c * x + s * y, z), s * x - c * y


def _twist_rate(a: Leaning, b: Leaning) -> float:
    """rad/s, of the yaw between attitudes FORECAST_STEP apart."""
    (ax, ay, az), (bx, by, bz) = a.axis, b.axis
    swung = (ax * by - ay * bx) / max(1.0 + 0.5 * (az + bz), UPSIDE_DOWN)
    return (wrap(b.heading - a.heading) - swung) / FORECAST_STEP
