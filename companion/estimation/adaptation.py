"""The noise levels, found in flight.

Sample by sample: the variances of the measurements are drawn to where the innovations are as large as predicted.
Slowly: the stationary variances of the coloured states by expectation maximisation: that of a process is the mean of
its estimate squared plus the variance of the estimate, which holds where the level is right, and leads there where it
is not.
"""

from __future__ import annotations

from companion.estimation.kalman import Belief, Innovation
from companion.estimation.kalman_step import DOWN, EAST, GUST, NORTH, POSITION_R_MIN, VELOCITY_ERROR, WANDER
from companion.estimation.noise_levels import NoiseLevels
from companion.frames import Vec3, clamped

MEASUREMENT_NOISE_TIME = 2.0
"""s over which the squares of the innovations are averaged. Engineering choice."""
NOISE_MIN = (POSITION_R_MIN, 4e-3**2)
"""m^2, m^2/s^2: variances of position and velocity, at least. Recorded: PX4's own smooth estimate, quiet."""
NOISE_FIRST = NoiseLevels(NOISE_MIN[0], NOISE_MIN[1], (0.05**2,) * 3, (0.1**2,) * 3, (0.1**2,) * 3)
"""m^2, m^2/s^2, (m/s)^2, (m/s)^2, (m/s^2)^2: the levels before anything is known, between quiet and shaking.
Engineering choice; the gusts': g times a tilt error of 0.6 deg. They are found more quickly upwards than downwards."""
NOISE_MAX = (0.05**2, 0.2**2)
"""m^2, m^2/s^2: at most. Engineering choice: the worst that is still flown."""
LEVEL_TIME = 6.0
"""s over which the levels of wander, velocity error and gusts are averaged. Engineering choice: a few of their time
constants."""
WANDER_RANGE = (0.02**2, 0.3**2)
"""(m/s)^2, stationary variance of U. Quiet PX4: 0.025 m/s; with sensors that shake 0.075 to 0.12."""
VELOCITY_ERROR_RANGE = (0.05**2, 0.5**2)
"""(m/s)^2, of B. Quiet PX4: 0.02 to 0.04 m/s; with sensors that shake 0.18 to 0.25."""
GUST_RANGE = (0.05**2, 2.0**2)
"""(m/s^2)^2, of W, level. Quiet PX4: g times a tilt error of 0.1 to 0.3 deg; shaking, of 0.7 deg. With 0.15 m/s^2 at
least NEES lay below its bounds a seventh of the time (bench.consistency)."""
GUST_RANGE_VERTICAL = (0.05**2, 0.25**2)
"""(m/s^2)^2, of W, vertical. Likewise; at most what air does, or a change of the thrust scale would be taken for it.
Engineering choice."""


def adapt_measurement_noise(noise: NoiseLevels, innovation: Innovation, dt: float) -> NoiseLevels:
    """The variances of the measurements, drawn to where the innovations are as large as predicted."""
    k = dt / (MEASUREMENT_NOISE_TIME * 3.0)
    position, velocity, wander, velocity_error, gust = noise
    (x, y, z, u, v, w), (xx, yy, zz, uu, vv, ww) = innovation
    position += k * (_excess(x, xx) + _excess(y, yy) + _excess(z, zz))
    velocity += k * (_excess(u, uu) + _excess(v, vv) + _excess(w, ww))
    return NoiseLevels(
        clamped(position, NOISE_MIN[0], NOISE_MAX[0]),
        clamped(velocity, NOISE_MIN[1], NOISE_MAX[1]),
        wander,
        velocity_error,
        gust,
    )


def _excess(residual: float, variance: float) -> float:
    """The square of a residual, three standard deviations of it at most, over its variance."""
    square = residual * residual
    return (square if square < 9.0 * variance else 9.0 * variance) - variance


def adapt_levels(noise: NoiseLevels, belief: Belief, dt: float) -> NoiseLevels:
    """The stationary variances of U, B and W, drawn to estimate squared plus variance of the estimate."""
    k = min(1.0, dt / LEVEL_TIME)
    position, velocity, wander, velocity_error, gust = noise
    return NoiseLevels(
        position,
        velocity,
        _adapted_level(wander, belief, WANDER, k, WANDER_RANGE, WANDER_RANGE),
        _adapted_level(velocity_error, belief, VELOCITY_ERROR, k, VELOCITY_ERROR_RANGE, VELOCITY_ERROR_RANGE),
        _adapted_level(gust, belief, GUST, k, GUST_RANGE, GUST_RANGE_VERTICAL),
    )


Range = tuple[float, float]
"""Least and most."""


def _adapted_level(level: Vec3, belief: Belief, kind: int, k: float, horizontal: Range, vertical: Range) -> Vec3:
    (a, b, c), x, variance = level, belief.x, belief.variance
    north, east, down = NORTH + kind, EAST + kind, DOWN + kind
    return (
        clamped(a + k * (x[north] ** 2 + variance(north) - a), *horizontal),
        clamped(b + k * (x[east] ** 2 + variance(east) - b), *horizontal),
        clamped(c + k * (x[down] ** 2 + variance(down) - c), *vertical),
    )
