"""The noise levels, found in flight.

Sample by sample: the variances of the measurements are drawn to where the innovations are as large as predicted.
Slowly: the stationary variances of the coloured states by expectation maximisation: that of a process is the mean of
its estimate squared plus the variance of the estimate, which holds where the level is right, and leads there where it
is not.
"""

from __future__ import annotations

from companion.estimation.kalman import Belief, Innovation
from companion.estimation.kalman_step import GUST, PER_AXIS, POSITION_R_MIN, VELOCITY_ERROR, WANDER
from companion.estimation.noise_levels import NoiseLevels
from companion.frames import Vec3

MEASUREMENT_NOISE_TIME = 2.0
"""s over which the squares of the innovations are averaged. Engineering choice."""
NOISE_MIN = (POSITION_R_MIN, 4e-3**2)
"""m^2, m^2/s^2: variances of position and velocity, at least. Recorded: PX4's own smooth estimate, quiet."""
NOISE_FIRST = NoiseLevels(NOISE_MIN[0], NOISE_MIN[1], (0.05**2,) * 3, (0.1**2,) * 3, (0.3**2, 0.3**2, 0.2**2))
"""m^2, m^2/s^2, (m/s)^2, (m/s)^2, (m/s^2)^2: the levels before anything is known, between quiet and shaking.
Engineering choice."""
NOISE_MAX = (0.05**2, 0.2**2)
"""m^2, m^2/s^2: at most. Engineering choice: the worst that is still flown."""
LEVEL_TIME = 6.0
"""s over which the levels of wander, velocity error and gusts are averaged. Engineering choice: a few of their time
constants."""
WANDER_RANGE = (0.02**2, 0.3**2)
"""(m/s)^2, stationary variance of U. Quiet PX4: 0.025 m/s; with sensors that shake 0.075 to 0.12."""
VELOCITY_ERROR_RANGE = (0.05**2, 0.5**2)
"""(m/s)^2, of B. Quiet PX4: 0.02 to 0.04 m/s; with sensors that shake 0.18 to 0.25."""
GUST_RANGE = (0.15**2, 2.0**2)
"""(m/s^2)^2, of W, level. Simulated: with 0.3 m/s^2 at least, NEES lies below its bounds (sih_noisy: 87 % of the
time inside; 93 % with this)."""
GUST_RANGE_VERTICAL = (0.12**2, 0.25**2)
"""(m/s^2)^2, of W, vertical. Likewise; at most what air does, or a change of the thrust scale would be taken for it.
Engineering choice."""


def adapt_measurement_noise(noise: NoiseLevels, innovation: Innovation, dt: float) -> NoiseLevels:
    """The variances of the measurements, drawn to where the innovations are as large as predicted."""
    k = dt / (MEASUREMENT_NOISE_TIME * 3.0)
    result = []
    for kind, first in enumerate((0, 3)):
        excess = 0.0
        for i in range(first, first + 3):
            residual, variance = innovation.residual[i], innovation.variance[i]
            excess += min(residual * residual, 9.0 * variance) - variance
        result.append(min(max((noise.position, noise.velocity)[kind] + k * excess, NOISE_MIN[kind]), NOISE_MAX[kind]))
    return noise._replace(position=result[0], velocity=result[1])


def adapt_levels(noise: NoiseLevels, belief: Belief, dt: float) -> NoiseLevels:
    """The stationary variances of U, B and W, drawn to estimate squared plus variance of the estimate."""
    k = min(1.0, dt / LEVEL_TIME)
    level = (GUST_RANGE, GUST_RANGE, GUST_RANGE_VERTICAL)
    return noise._replace(
        wander=_adapted_level(noise.wander, belief, WANDER, k, (WANDER_RANGE,) * 3),
        velocity_error=_adapted_level(noise.velocity_error, belief, VELOCITY_ERROR, k, (VELOCITY_ERROR_RANGE,) * 3),
        gust=_adapted_level(noise.gust, belief, GUST, k, level),
    )


Ranges = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


def _adapted_level(level: Vec3, belief: Belief, kind: int, k: float, ranges: Ranges) -> Vec3:
    values = []
    for axis, (least, most) in enumerate(ranges):
        index = PER_AXIS * axis + kind
        value = level[axis] + k * (belief.x[index] ** 2 + belief.variance(index) - level[axis])
        values.append(min(max(value, least), most))
    return values[0], values[1], values[2]
