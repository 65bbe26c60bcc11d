"""The noise levels, found in flight.

Sample by sample: the variances of the measurements are drawn to where the innovations are as large as predicted.
Slowly: the stationary variances of the coloured states by expectation maximisation: that of a process is the mean of
its estimate squared plus the variance of the estimate, which holds where the level is right, and leads there where it
is not. By time alone: what the vehicle's attitude is wrong by when it comes out of a take-off settles.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from companion.calculus import machine_code
from companion.calculus.scalar import Scalar, elementary, maximum, minimum
from companion.calculus.straight import Function, Tape
from companion.estimation.kalman import Belief, Innovation, variance_of
from companion.estimation.kalman_step import (
    AXES,
    DOWN,
    EAST,
    GUST,
    NORTH,
    PER_AXIS,
    POSITION_R_MIN,
    SIZE,
    UPPER,
    VELOCITY_ERROR,
    WANDER,
)
from companion.estimation.noise_levels import NoiseLevels
from companion.frames import Vec3

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


Range = tuple[float, float]
"""Least and most."""


def adapt_noise(
    noise: NoiseLevels, belief: Belief, innovation: Innovation, dt: float, *, measurements: bool, levels: bool
) -> NoiseLevels:
    """The levels ``dt`` s later, after an ``innovation`` that led to ``belief``. ``measurements``: their variances are
    drawn to where innovations are as large as predicted. ``levels``: the stationary variances of U, B and W are drawn
    to estimate squared plus variance of the estimate. The noise of D and E and the tilt error settle in any case."""
    adapt = adaptation_of(measurements, levels, machine_code.in_use)
    return NoiseLevels(
        *adapt(dt, *noise, innovation.residual, innovation.variance, belief.x, belief.S, belief.G, belief.T)
    )


@lru_cache(maxsize=8)
def adaptation_of(measurements: bool, levels: bool, in_machine_code: bool) -> Function:
    """``adapt_noise``, recorded: (dt, NoiseLevels, innovations, variances, state, S, G, T) -> those of a
    NoiseLevels. ``in_machine_code``: whether that is in use."""
    tape = Tape()
    (dt,) = tape.inputs("dt")
    variances = tape.inputs("rp", "rv")
    stationary = [tape.tuple_input(*(f"{kind}{axis}" for axis in "xyz")) for kind in ("u", "b", "w")]
    disturbance_q = tape.tuple_input("qdx", "qdy", "qdz")
    attitude = tape.inputs("e", "t")
    residuals = tape.tuple_input(*(f"i{k}" for k in range(2 * AXES)))
    predicted = tape.tuple_input(*(f"v{k}" for k in range(2 * AXES)))
    x = tape.tuple_input(*(f"x{i}" for i in range(SIZE)))
    S = tape.tuple_input(*(f"s{i}" for i in range(AXES * len(UPPER))), packed=True)
    G = tape.tuple_input(*(f"g{i}" for i in range(2 * AXES * PER_AXIS)), packed=True)
    T = tape.tuple_input("tkk", "tkc", "tcc")
    if measurements:
        variances = _adapted_variances(variances, residuals, predicted, dt)
    if levels:
        for at, (kind, horizontal, vertical) in enumerate(_LEVELS):
            stationary[at] = tuple(
                _adapted_level(level, x[first + kind], variance_of(first + kind, S, G, T), dt, range_)
                for level, first, range_ in zip(
                    stationary[at], (NORTH, EAST, DOWN), (horizontal, horizontal, vertical), strict=True
                )
            )
    k = dt / SETTLING_TIME
    disturbance_q = tuple(now + k * (last - now) for now, last in zip(disturbance_q, DISTURBANCE_Q, strict=True))
    settled = (HEADING_ERROR_VARIANCE, TILT_ERROR_VARIANCE)
    attitude = tuple(now + k * (last - now) for now, last in zip(attitude, settled, strict=True))
    return machine_code.function_of(tape, "adaptation", [*variances, *stationary, disturbance_q, *attitude])


def _adapted_variances(
    variances: Sequence[Scalar], residuals: Sequence[Scalar], predicted: Sequence[Scalar], dt: Scalar
) -> tuple[Scalar, ...]:
    """Of position and velocity."""
    k = dt / (MEASUREMENT_NOISE_TIME * 3.0)
    excess = [_excess(*pair) for pair in zip(residuals, predicted, strict=True)]
    of_each = (excess[:AXES], excess[AXES:])
    return tuple(
        _within(variance + k * (a + b + c), (least, most))
        for variance, (a, b, c), least, most in zip(variances, of_each, NOISE_MIN, NOISE_MAX, strict=True)
    )


def _excess(residual: Scalar, variance: Scalar) -> Scalar:
    """The square of a residual, three standard deviations of it at most, over its variance."""
    return minimum(9.0 * variance, residual * residual) - variance


def _adapted_level(level: Scalar, x: Scalar, variance: Scalar, dt: Scalar, range_: Range) -> Scalar:
    # pow, as ** on floats is, whose last bit may be another than that of x * x
    k, square = minimum(1.0, dt / LEVEL_TIME), elementary("power", x, 2.0)
    return _within(level + k * (square + variance - level), range_)


def _within(value: Scalar, range_: Range) -> Scalar:
    return minimum(maximum(value, range_[0]), range_[1])


_LEVELS = (
    (WANDER, WANDER_RANGE, WANDER_RANGE),
    (VELOCITY_ERROR, VELOCITY_ERROR_RANGE, VELOCITY_ERROR_RANGE),
    (GUST, GUST_RANGE, GUST_RANGE_VERTICAL),
)
"""Kind of state, and the range of its level, level and vertical."""

for _measurements, _adapts in ((True, True), (True, False), (False, False)):
    adaptation_of(_measurements, _adapts, machine_code.in_use)  # recorded now and not in a flight's first tick
