"""The noise levels, found in flight.

Sample by sample: the variances of the measurements are drawn to where the innovations are as large as predicted.
Slowly: the stationary variances of the coloured states by expectation maximisation: that of a process is the mean of
its estimate squared plus the variance of the estimate, which holds where the level is right, and leads there where it
is not. By time alone: what the vehicle's attitude is wrong by when it comes out of a take-off settles.
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
DISTURBANCE_Q: Vec3 = (0.001, 0.001, 0.0005)
"""m^2/s^5, process noise of D. Level: 0.25 m/s^2 in a minute, a wind that changes by 1 m/s on a drag of 0.25 (what
comes and goes is W); vertical: 0.05 m/s^2 stationary, the prior that tells the thrust scale from it: what a tilt error
of 0.7 deg makes of a thrust that leans by 25 deg. Engineering choice."""
DISTURBANCE_Q_FIRST: Vec3 = (0.04, 0.04, 0.0005)
"""m^2/s^5, the same at first. Level: g times a tilt error that changes by 1.2 deg in a second; recorded: 2 to 3 deg in
the 20 s after a take-off with sensors that shake, a standing 1.2 deg later. With DISTURBANCE_Q from the beginning NEES
lay within its bounds 36 % of that time."""
HEADING_ERROR_VARIANCE = 0.03**2
"""rad^2, stationary variance of E: 1.7 deg, recorded with sensors that shake."""
HEADING_ERROR_VARIANCE_FIRST = 0.1**2
"""rad^2, the same at first: 5.7 deg. Recorded: 5 to 14 deg until 10 s after the path was reached."""
TILT_ERROR_VARIANCE = 0.0122**2
"""rad^2, of the tilt error: 0.7 deg, recorded in the same session. A thrust that leans is lifted or lowered by it:
0.1 m/s^2 at 40 deg."""
TILT_ERROR_VARIANCE_FIRST = 0.026**2
"""rad^2, the same at first: 1.5 deg. Sweep over leans of 33 to 50 deg on sih_noisy, whose tilt begins with 2 deg:
without either NEES lies inside 54 % of the first 20 s, with both 80 %, with 2.5 and 1 deg 79 %."""
SETTLING_TIME = 15.0
"""s, time constant in which these come from what they are at first to what they stay. Recorded: tilt and heading error
of PX4's filter are a third of the first ones after 15 to 20 s."""
NOISE_FIRST = NoiseLevels(
    NOISE_MIN[0], NOISE_MIN[1], (0.05**2,) * 3, (0.2**2,) * 3, (0.1**2,) * 3, DISTURBANCE_Q_FIRST,
    HEADING_ERROR_VARIANCE_FIRST, TILT_ERROR_VARIANCE_FIRST,
)  # fmt: skip
"""m^2, m^2/s^2, (m/s)^2, (m/s)^2, (m/s^2)^2, m^2/s^5, rad^2, rad^2: the levels before anything is known, between quiet
and shaking. Engineering choice; the gusts': g times a tilt error of 0.6 deg. They are found more quickly upwards than
downwards."""
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
    position, velocity, wander, velocity_error, gust, disturbance_q, heading_error, tilt_error = noise
    (x, y, z, u, v, w), (xx, yy, zz, uu, vv, ww) = innovation
    position += k * (_excess(x, xx) + _excess(y, yy) + _excess(z, zz))
    velocity += k * (_excess(u, uu) + _excess(v, vv) + _excess(w, ww))
    return NoiseLevels(
        clamped(position, NOISE_MIN[0], NOISE_MAX[0]),
        clamped(velocity, NOISE_MIN[1], NOISE_MAX[1]),
        wander,
        velocity_error,
        gust,
        disturbance_q,
        heading_error,
        tilt_error,
    )


def _excess(residual: float, variance: float) -> float:
    """The square of a residual, three standard deviations of it at most, over its variance."""
    square = residual * residual
    return (square if square < 9.0 * variance else 9.0 * variance) - variance


def adapt_levels(noise: NoiseLevels, belief: Belief, dt: float) -> NoiseLevels:
    """The stationary variances of U, B and W, drawn to estimate squared plus variance of the estimate."""
    k = min(1.0, dt / LEVEL_TIME)
    position, velocity, wander, velocity_error, gust, disturbance_q, heading_error, tilt_error = noise
    return NoiseLevels(
        position,
        velocity,
        _adapted_level(wander, belief, WANDER, k, WANDER_RANGE, WANDER_RANGE),
        _adapted_level(velocity_error, belief, VELOCITY_ERROR, k, VELOCITY_ERROR_RANGE, VELOCITY_ERROR_RANGE),
        _adapted_level(gust, belief, GUST, k, GUST_RANGE, GUST_RANGE_VERTICAL),
        disturbance_q,
        heading_error,
        tilt_error,
    )


def settle_attitude_error(noise: NoiseLevels, dt: float) -> NoiseLevels:
    """The noise of D and E and the tilt error ``dt`` s later, on their way to what they stay."""
    k = dt / SETTLING_TIME
    (x, y, z), (north, east, down) = noise.disturbance_q, DISTURBANCE_Q
    return NoiseLevels(
        noise.position,
        noise.velocity,
        noise.wander,
        noise.velocity_error,
        noise.gust,
        (x + k * (north - x), y + k * (east - y), z + k * (down - z)),
        noise.heading_error + k * (HEADING_ERROR_VARIANCE - noise.heading_error),
        noise.tilt_error + k * (TILT_ERROR_VARIANCE - noise.tilt_error),
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
