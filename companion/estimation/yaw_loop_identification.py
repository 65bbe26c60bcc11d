"""Identification of the yaw loop: its lag, which tells a strong yaw from a weak one.

As of the tilting loops (``rate_loop_identification``) three models with a shorter, this and a longer lag are driven by
the commands alone, and a parabola through their errors has its minimum at the lag of the vehicle. A yaw loop turns with
an offset all the time (drag, an integrator that fills, rotors that do not match), so their variances are compared and
not their mean squares.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.rate_loop_identification import (
    GAP_MAX,
    MEAN_TIME,
    PERIOD,
    Models,
    begin_models,
    propagate_models,
    rates_commanded,
    step_to_minimum,
)
from companion.estimation.rate_loop_model import YAW_LAG, YAW_TORQUE_LAG, TimedCommand
from companion.frames import Vec3, clamped

FOLLOW_TIME = 1.5
"""s, time constant with which the lag follows. Engineering choice: found within a bend or two."""
SETTLING_TIME = 1.0
"""s after a reset in which the models swing in and nothing is learned: two usual lags. Engineering choice."""
SWING_MIN = 0.06**2
"""(rad/s)^2, variance of the middle model's yaw rate below which nothing is learned: a nose that stays. Engineering
choice."""
LAG_RATIO_RANGE = (0.35, 2.0)
"""Ratio to the prior lag: no other is sought. Engineering choice: yaw from twice as weak to thrice as strong as
usual."""
LAG_GRID = 20.0
"""Number: of lags an e-fold of which transitions are computed and kept. Engineering choice: five percent apart."""


class YawLoopEstimate(NamedTuple):
    """What is known of the yaw loop."""

    lag: float  # s
    prior: float  # s, the lag it began with
    models: Models  # with shorter, this and longer lag
    means: Vec3 = (0.0, 0.0, 0.0)  # rad/s, of their errors
    variances: Vec3 = (0.0, 0.0, 0.0)  # (rad/s)^2, of their errors
    swing_mean: float = 0.0  # rad/s, of the middle model's yaw rate
    swing: float = 0.0  # (rad/s)^2, its variance
    ran: float = 0.0  # s since the last reset
    at: float = -math.inf  # s, the vehicle's clock, of the last update


def initial_yaw_loop_estimate(r: float, lag: float = YAW_LAG) -> YawLoopEstimate:
    """Nothing seen yet but a yaw rate (rad/s)."""
    return YawLoopEstimate(lag, lag, begin_models(r))


def reset_yaw_loop(known: YawLoopEstimate, r: float) -> YawLoopEstimate:
    """The models put back on the vehicle's yaw rate (rad/s); what was found stays."""
    return known._replace(models=begin_models(r), ran=0.0, at=-math.inf)


def update_yaw_loop_estimate(
    known: YawLoopEstimate, commands: tuple[TimedCommand, ...], now: float, r: float
) -> YawLoopEstimate:
    """``known`` after the commands in force until ``now`` (s, the vehicle's clock) and a yaw rate (rad/s)."""
    dt = now - known.at
    if dt < PERIOD:
        return known
    if dt > GAP_MAX:
        return reset_yaw_loop(known, r)._replace(at=now)
    commanded = rates_commanded(commands, known.at, dt)
    models = propagate_models(known.models, known.lag, YAW_TORQUE_LAG, commanded, 2, LAG_GRID)
    (a, _), (b, _), (c, _) = models
    errors, ran = (a - r, b - r, c - r), known.ran + dt
    if ran < SETTLING_TIME:
        return YawLoopEstimate(known.lag, known.prior, models, errors, (0.0, 0.0, 0.0), b, 0.0, ran, now)
    k = dt / MEAN_TIME
    d1, d2, d3 = (error - mean for error, mean in zip(errors, known.means, strict=True))
    (m1, m2, m3), (v1, v2, v3), rest = known.means, known.variances, 1.0 - k
    means = (m1 + k * d1, m2 + k * d2, m3 + k * d3)
    variances = (rest * (v1 + k * d1 * d1), rest * (v2 + k * d2 * d2), rest * (v3 + k * d3 * d3))
    off = b - known.swing_mean
    swing_mean, swing = known.swing_mean + k * off, rest * (known.swing + k * off * off)
    lag = known.lag
    if swing >= SWING_MIN:
        low, high = LAG_RATIO_RANGE
        lag *= math.exp(step_to_minimum(variances) * dt / FOLLOW_TIME)
        lag = clamped(lag, low * known.prior, high * known.prior)
    return YawLoopEstimate(lag, known.prior, models, means, variances, swing_mean, swing, ran, now)
