"""Identification of the rate loop: its lag and its gain, from how the body rates follow the commands.

Three models run side by side with lags L/d, L and L d, driven by the commands alone. A parabola through their mean
squared errors against the gyro, over the logarithm of the lag, has its minimum at the lag of the vehicle. Noise adds
the same to all three, and an error of the gain is orthogonal to one of the lag, so neither moves the minimum.

The integrator of PX4's rate loop lets it overshoot what changes slowly, by a few percent: the ratio of the gyro to the
middle model (least squares) is the loop's gain, and so much less is commanded than is meant.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.rate_loop_model import STEP, TimedCommand, active_command, axis_transition
from companion.frames import Vec3

LOG_SPACING = 0.25
"""Between the models, in the logarithm of the lag. Engineering choice: narrow enough for the parabola."""
MEAN_TIME = 3.0
"""s, time constant of the means of the squared errors. Engineering choice: a bend or two."""
FOLLOW_TIME = 2.0
"""s, time constant with which lag and gain follow. Engineering choice: slower than the vehicle, quicker than a lap."""
SETTLING_TIME = 0.4
"""s after a reset in which the models swing in and nothing is learned: six usual lags."""
EXCITATION_MIN = (5e-4) ** 2
"""(rad/s)^2: curvature of the parabola, or difference of its ends, below which the commands excite too little."""
LAG_RATIO_MIN = 0.9
"""Times the prior lag: no shorter one is sought. A slow course shows the lag of slow commands only, which the
integrator of PX4's rate loop shortens, and the loop is closed over the fast ones too."""
LAG_RATIO_MAX = 1.6
"""Times the prior lag: no longer one is sought."""
GAIN_MAX = 1.1
"""The largest gain that is believed; never less than 1. PX4's simulated quadrotor: 1.01 to 1.03."""
GAIN_EXCITATION_MIN = 0.2**2
"""(rad/s)^2: mean square of the rates below which no gain is learned."""
PERIOD = 0.024
"""s between two updates. Engineering choice: twice the step of the models."""
GAP_MAX = 0.06
"""s without a state after which the models are reset."""

Axes = tuple[float, float, float, float]
"""p, p', q, q' of one model: rad/s, rad/s^2."""


class RateLoopEstimate(NamedTuple):
    """What is known of the rate loop.

    ``lag``: s. ``prior``: s, the lag it began with. ``models``: with shorter, this and longer lag.
    ``mean_squared_errors``: (rad/s)^2, theirs. ``ran``: s since the last reset. ``at``: s, the vehicle's clock, of the
    last update. ``gain``: rates over commands. ``gyro_times_model``, ``model_squared``: (rad/s)^2, means with the
    middle model.
    """

    lag: float
    prior: float
    models: tuple[Axes, Axes, Axes]
    mean_squared_errors: Vec3 = (0.0, 0.0, 0.0)
    ran: float = 0.0
    at: float = -math.inf
    gain: float = 1.0
    gyro_times_model: float = 0.0
    model_squared: float = 0.0


def initial_rate_loop_estimate(lag: float, w_b: Vec3, prior: float | None = None) -> RateLoopEstimate:
    """Nothing seen yet but body rates (rad/s)."""
    still = (w_b[0], 0.0, w_b[1], 0.0)
    return RateLoopEstimate(lag, lag if prior is None else prior, (still, still, still))


def reset(known: RateLoopEstimate, w_b: Vec3) -> RateLoopEstimate:
    """The models put back on the vehicle's body rates (rad/s); what was found stays."""
    still = (w_b[0], 0.0, w_b[1], 0.0)
    return known._replace(models=(still, still, still), ran=0.0, at=-math.inf)


def update_rate_loop_estimate(
    known: RateLoopEstimate, motor_lag: float, commands: tuple[TimedCommand, ...], now: float, w_b: Vec3
) -> RateLoopEstimate:
    """``known`` after the commands in force until ``now`` (s, the vehicle's clock) and a gyro measurement (rad/s).

    ``commands``: those of the last PERIOD at least, as they were meant. ``motor_lag``: s.
    """
    dt = now - known.at
    if dt < PERIOD:
        return known
    if dt > GAP_MAX:
        return reset(known, w_b)._replace(at=now)
    # on a grid of one percent, so that the transitions are computed once
    grid = round(100.0 * math.log(known.lag))
    spacing = round(100.0 * LOG_SPACING)
    shorter, middle, longer = (
        _propagate(model, math.exp(0.01 * (grid + k * spacing)), motor_lag, commands, known.at, dt)
        for k, model in zip((-1, 0, 1), known.models, strict=True)
    )
    known = known._replace(models=(shorter, middle, longer), ran=known.ran + dt, at=now)
    if known.ran < SETTLING_TIME:
        return known
    p, q, _ = w_b
    k = dt / MEAN_TIME
    e1, e2, e3 = (
        mean + k * ((m[0] - p) ** 2 + (m[2] - q) ** 2 - mean)
        for mean, m in zip(known.mean_squared_errors, known.models, strict=True)
    )
    product = known.gyro_times_model + k * (middle[0] * p + middle[2] * q - known.gyro_times_model)
    square = known.model_squared + k * (middle[0] * middle[0] + middle[2] * middle[2] - known.model_squared)
    known = known._replace(mean_squared_errors=(e1, e2, e3), gyro_times_model=product, model_squared=square)
    return known._replace(lag=_updated_lag(known, dt), gain=_updated_gain(known, dt))


def step_to_minimum(mean_squared_errors: Vec3) -> float:
    """From the logarithm of the middle lag to the minimum of the parabola; 0 where the commands excite too little."""
    shorter, middle, longer = mean_squared_errors
    curvature = shorter + longer - 2.0 * middle
    if curvature <= EXCITATION_MIN and abs(shorter - longer) <= EXCITATION_MIN:
        return 0.0
    if middle <= shorter and middle <= longer and curvature > 0.0:
        return 0.5 * LOG_SPACING * (shorter - longer) / curvature
    return math.copysign(LOG_SPACING, shorter - longer)


def _updated_lag(known: RateLoopEstimate, dt: float) -> float:
    """s, drawn towards the minimum of the parabola."""
    towards = step_to_minimum(known.mean_squared_errors)
    if towards == 0.0:
        return known.lag
    lag = known.lag * math.exp(towards * dt / FOLLOW_TIME)
    return max(known.prior * LAG_RATIO_MIN, min(known.prior * LAG_RATIO_MAX, lag))


def _updated_gain(known: RateLoopEstimate, dt: float) -> float:
    """Drawn towards the ratio of gyro and middle model."""
    if known.model_squared <= GAIN_EXCITATION_MIN:
        return known.gain
    gain = known.gain * (1.0 + (known.gyro_times_model / known.model_squared - 1.0) * dt / FOLLOW_TIME)
    return max(1.0, min(GAIN_MAX, gain))


def _propagate(
    model: Axes, lag: float, motor_lag: float, commands: tuple[TimedCommand, ...], begin: float, dt: float
) -> Axes:
    steps = max(1, math.ceil(dt / (2.0 * STEP) - 1e-9))
    h = round(dt / steps, 6)
    step = axis_transition(lag, motor_lag, h)
    p, pd, q, qd = model
    for k in range(steps):
        _, rates, _ = active_command(commands, begin + (k + 0.5) * h)
        yp, yq = p - rates[0], q - rates[1]
        p, pd = rates[0] + step.yy * yp + step.yd * pd, step.dy * yp + step.dd * pd
        q, qd = rates[1] + step.yy * yq + step.yd * qd, step.dy * yq + step.dd * qd
    return (p, pd, q, qd)
