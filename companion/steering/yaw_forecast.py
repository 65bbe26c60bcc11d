"""Yaw forecast: the yaw rates that the heading will ask for as the path goes on.

A vehicle that leans has to yaw even for a heading that stays. With the roll phi and the pitch theta of the thrust that
the path takes, and the heading psi asked for there,

    r = psi' cos(theta) cos(phi) - theta' sin(phi)               heading: the yaw of the ZYX angles
    r = psi' - (x y' - y x') / (1 + z)                           heading: the twist; (x, y, z) the thrust axis, down
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from companion.calculus import machine_code
from companion.calculus.scalar import Scalar, atan2, cos, maximum, sin, sqrt, wrap
from companion.calculus.straight import Function, Tape
from companion.frames import Heading, clamped
from companion.steering.speed_governor import Capability, Course

FORECAST_STEP = 0.1
"""s between the moments of a forecast. Engineering choice: a bend of a figure-eight is 0.6 s long."""
FORECAST_LENGTH = 5
"""Number of moments. Engineering choice: a yaw loop that knows 0.3 s ahead does nearly as well as one that knows a
second (bends of a figure-eight at 3 m/s and of a circle at 7 m/s)."""
SIZE_MIN = 1e-6
"""m/s^2, of a thrust that has a direction. Engineering choice: any that is no rounding."""
UPSIDE_DOWN = 0.1
"""Number: the least 1 + z that is divided by. Engineering choice: a tilt of 154 deg."""

Forecast = Sequence[float]
"""rad/s, at FORECAST_LENGTH moments."""


def rate_at(forecast: Forecast, t: float) -> float:
    """rad/s, ``t`` s after its first moment."""
    u = t / FORECAST_STEP
    i = math.floor(clamped(u, 0.0, FORECAST_LENGTH - 2.0))
    return forecast[i] + (u - i) * (forecast[i + 1] - forecast[i])


class Leaning(NamedTuple):
    """An attitude. ``axis``: the body's down, world frame. ``heading``: rad."""

    axis: tuple[Scalar, Scalar, Scalar]
    heading: Scalar


def forecast_yaw_rates(course: Course, s: float, scale: float, capability: Capability, heading: Heading) -> Forecast:
    """The yaw rates of a vehicle that is on the path, at arc length ``s`` (m) now, and flies it at ``scale`` times the
    mission's speed."""
    way = course.direction if scale >= 0.0 else -course.direction
    step = way * course.speed(s) * abs(scale) * FORECAST_STEP
    rows = course.rows
    places: list[float | tuple[float, ...]] = []
    for k in range(FORECAST_LENGTH + 1):
        i, j, share = course.between(s + (k - 0.5) * step)
        places += (share, rows[i], rows[j])
    return recorded_forecast(heading, machine_code.in_use)(
        abs(scale), way, course.spacing, capability.drag, capability.disturbance_n, capability.gravity, *places
    )


@lru_cache(maxsize=4)
def recorded_forecast(heading: Heading, in_machine_code: bool) -> Function:
    """(scale, way, spacing, drag, disturbance, gravity, and for moments FORECAST_STEP apart the share and two rows of a
    course) -> yaw rates half way from each to the next. ``in_machine_code``: whether that is in use."""
    tape = Tape()
    scale, way, spacing, drag = tape.inputs("f", "way", "h", "c")
    disturbance_n, (gravity,) = tape.tuple_input("dx", "dy", "dz"), tape.inputs("g")
    attitudes = []
    for k in range(FORECAST_LENGTH + 1):
        (share,) = tape.inputs(f"u{k}")
        before, after = (tape.tuple_input(*(f"{side}{k}_{i}" for i in range(8))) for side in "ab")
        here = [a + share * (b - a) for a, b in zip(before[:7], after[:7], strict=True)]
        slope = (after[6] - before[6]) / spacing
        axis = _thrust_axis(here[:3], here[3:6], scale * here[6], scale * slope, way, drag, disturbance_n, gravity)
        attitudes.append(Leaning(axis, before[7] + share * wrap(after[7] - before[7])))
    rate = _projected_rate if heading is Heading.PROJECTED else _twist_rate
    return machine_code.function_of(tape, "forecast", [rate(a, b) for a, b in pairwise(attitudes)])


def _thrust_axis(
    tangent: list[Scalar], curvature: list[Scalar], v: Scalar, slope: Scalar, way: Scalar, drag: Scalar,
    disturbance_n: Sequence[Scalar], gravity: Scalar,
) -> tuple[Scalar, Scalar, Scalar]:  # fmt: skip
    """Where a vehicle's down axis points that flies there at ``v`` (m/s, along the path by the sign of ``way``), which
    changes by ``slope`` (1/s) over arc length."""
    along = v * (slope + drag * way)
    # gravity and disturbance less acceleration and drag: what the thrust has to carry
    x, y, z = (d - k * (v * v) - t * along for t, k, d in zip(tangent, curvature, disturbance_n, strict=True))
    z = z + gravity
    size = maximum(sqrt(x * x + y * y + z * z), SIZE_MIN)
    return x / size, y / size, z / size


def _projected_rate(a: Leaning, b: Leaning) -> Scalar:
    """rad/s, of the yaw between attitudes FORECAST_STEP apart."""
    pitch_a, across_a = _pitch_and_sine_of_roll(a)
    pitch_b, across_b = _pitch_and_sine_of_roll(b)
    turned = (a.axis[2] + b.axis[2]) * wrap(b.heading - a.heading)
    return (turned - (across_a + across_b) * wrap(pitch_b - pitch_a)) * (0.5 / FORECAST_STEP)


def _pitch_and_sine_of_roll(leaning: Leaning) -> tuple[Scalar, Scalar]:
    (x, y, z), psi = leaning
    c, s = cos(psi), sin(psi)
    return atan2(c * x + s * y, z), s * x - c * y


def _twist_rate(a: Leaning, b: Leaning) -> Scalar:
    """rad/s, of the yaw between attitudes FORECAST_STEP apart."""
    (ax, ay, az), (bx, by, bz) = a.axis, b.axis
    swung = (ax * by - ay * bx) / maximum(1.0 + 0.5 * (az + bz), UPSIDE_DOWN)
    return (wrap(b.heading - a.heading) - swung) / FORECAST_STEP
