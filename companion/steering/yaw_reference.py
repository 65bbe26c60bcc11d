"""Yaw reference: how a yaw loop whose torque is late and bounded best follows the yaw rate that will be asked for.

A heading that is kept at a steep tilt asks for pulses of yaw rate that the loop cannot follow once they are there, but
they are known ahead. With e the heading error as the body turns it, r_d the yaw rate asked for, and the loop of
``steering.yaw``,

    e' = r - r_d        T (theta r'' + r') = v        minimise the integral of (e / e0)^2 + (v / v0)^2

e0: HEADING_WORTH; v0: the loop's authority. For an r_d that is known ahead the optimum is linear: r is r_d, filtered
once forward and once backward in time, which leaves no lag,

    r''' + d2 r'' + d1 r' + d0 r = d0 z        d(s) = s^3 + d2 s^2 + d1 s + d0,  d(s) d(-s) = d0^2 + s^4/theta^2 - s^6
    -z''' + d2 z'' - d1 z' + d0 z = d0 r_d     d0 = v0 / (e0 T theta)

integrated, so that e is held too, with m(x) what is missing x s after a step through d0/d(s):

    r'' + d2 r' + d1 r + d0 e = d0 integral of m(x) r_d(t + x) dx from x = 0 on
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from companion.frames import clamped
from companion.steering.yaw_forecast import FORECAST_LENGTH, FORECAST_STEP, Forecast

HEADING_WORTH = math.radians(4.0)
"""rad of heading error that are worth all the yaw torque there is. Simulated on sih_noisy: 3.5 to 5 deg make no
difference up to 5 m/s; at 7 m/s, where the torque is short, 3.5 deg shake the nose by a tenth more, and 5 leave a tenth
more in still air."""
TABLE_STEP = 0.005
"""s, in which m is integrated. Engineering choice."""
GRID = 20.0
"""Number: of lags and authorities an e-fold for which the solution is computed and kept. Engineering choice: 5 %
apart."""
STEP_MAX = 0.02
"""s, the longest step of the reference. Engineering choice: a fifth of its quickest time."""
ERROR_MAX = 0.35
"""rad of heading error that are planned at most. Engineering choice: 20 deg."""
NEWTON_STEPS = 30
"""Number, to the root. Engineering choice: it is sought from above, where it converges for certain."""


class YawReference(NamedTuple):
    """``error``: rad, e. ``rate``: rad/s, r. ``acceleration``: rad/s^2, r'. ``drive``: rad/s, v."""

    error: float = 0.0
    rate: float = 0.0
    acceleration: float = 0.0
    drive: float = 0.0


class YawDrive(NamedTuple):
    """The loop that follows. ``lag``: T, s. ``torque_lag``: theta, s. ``authority``: v0, rad/s. ``low``, ``high``:
    rad/s, between which v is now."""

    lag: float
    torque_lag: float
    authority: float
    low: float
    high: float


class Solution(NamedTuple):
    """``d2`` 1/s, ``d1`` 1/s^2, ``d0`` 1/s^3. ``weights``: s, the integral's on each moment of a forecast; beyond its
    end the last one stays."""

    d2: float
    d1: float
    d0: float
    weights: tuple[float, ...]


def advance_reference(known: YawReference, forecast: Forecast, drive: YawDrive, dt: float) -> YawReference:
    """The reference ``dt`` s later. ``forecast``: rad/s of r_d, from when the command acts."""
    d2, d1, d0, weights = solution(drive)
    ahead = d0 * sum(weight * rate for weight, rate in zip(weights, forecast, strict=True))
    lag, torque_lag, _, low, high = drive
    e, r, a, v = known
    steps = max(1, math.ceil(dt / STEP_MAX - 1e-9))
    h = dt / steps
    for _ in range(steps):
        v = clamped(lag * (a + torque_lag * (ahead - d2 * a - d1 * r - d0 * e)), low, high)
        jerk = (v / lag - a) / torque_lag
        e += h * (r - forecast[0] + 0.5 * h * a)
        r += h * (a + 0.5 * h * jerk)
        a += h * jerk
    return YawReference(clamped(e, -ERROR_MAX, ERROR_MAX), r, a, v)


def solution(drive: YawDrive) -> Solution:
    """For a loop; on a grid, and kept."""
    return _solution(_on_grid(drive.lag), _on_grid(drive.torque_lag), _on_grid(drive.authority))


def _on_grid(value: float) -> int:
    return round(GRID * math.log(value))


@lru_cache(maxsize=256)
def _solution(lag_: int, torque_lag_: int, authority_: int) -> Solution:
    lag, torque_lag, authority = (math.exp(value / GRID) for value in (lag_, torque_lag_, authority_))
    d2, d1, d0 = _spectral_factor(authority / (HEADING_WORTH * lag * torque_lag), torque_lag)
    weights = [0.0] * FORECAST_LENGTH
    h, done, rate, slope = TABLE_STEP, 0.0, 0.0, 0.0  # a step through d0 / d(s)
    for k in range(round((FORECAST_LENGTH - 1) * FORECAST_STEP / h)):
        slope += h * (d0 * (1.0 - done) - d1 * rate - d2 * slope)
        rate += h * slope
        left = h * (1.0 - done - 0.5 * h * rate)
        done += h * rate
        at = (k + 0.5) * h / FORECAST_STEP
        i = math.floor(at)
        weights[i] += left * (1.0 - (at - i))
        weights[i + 1] += left * (at - i)
    weights[-1] += d1 / d0 - sum(weights)  # the whole of m
    return Solution(d2, d1, d0, tuple(weights))


def _spectral_factor(d0: float, theta: float) -> tuple[float, float, float]:
    """d2, d1 and d0 of the stable d(s) = (s + p)(s^2 + b s + c), d(s) d(-s) = d0^2 + s^4/theta^2 - s^6."""
    far, square = theta**-2, d0 * d0
    y = far + square ** (1.0 / 3.0)  # p^2, the root of y^3 - far y^2 - d0^2
    for _ in range(NEWTON_STEPS):
        y -= (y * y * (y - far) - square) / (y * (3.0 * y - 2.0 * far))
    p, c = math.sqrt(y), math.sqrt((y - far) * y)
    b = math.sqrt(2.0 * c - (y - far))
    return p + b, p * b + c, p * c
