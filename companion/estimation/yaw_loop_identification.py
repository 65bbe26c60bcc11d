"""Identification of the yaw loop: its lag (a strong yaw or a weak one), the lag of its torque, the body's damping.

    T r' = u - T theta r'' - T damping r + offset        u = (r_cmd - r) + I/P integral of it

is the vehicle's yaw loop: its P and I terms turn the rate error into torque, which a filter and the motors delay by
theta, and the air damps the turning. Divided by T it is linear in 1/T, theta, damping and offset. Both sides go through
the same low-pass filter of third order, which gives the derivatives; a Kalman filter on the four unknowns, random
walks, is then least squares that forgets. A yaw loop turns with an offset all the time (rotors that do not match),
which is one of them. Without the damping lag and torque lag of PX4's simulated quadrotor were found as 0.41 and 0.06 s;
they are 0.375 and 0.135 s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from companion.estimation.rate_loop_identification import GAP_MAX, MEAN_TIME, PERIOD
from companion.estimation.rate_loop_model import (
    YAW_INTEGRAL_RATE,
    YAW_LAG,
    YAW_TORQUE_LAG,
    TimedCommand,
    active_command,
)
from companion.frames import clamped

FILTER_POLE = 8.0
"""1/s, of the filter's three poles. Engineering choice: a bend has passed by 4 rad/s, the gyro's noise begins above."""
INTEGRAL_TIME = 6.0
"""s in which what that integral knew is forgotten: the rest is offset. Engineering choice."""
SETTLING_TIME = 0.6
"""s after a reset in which the filter swings in and nothing is learned: five of its lags. Engineering choice."""
SWING_MIN = 0.06**2
"""(rad/s)^2, variance of the filtered yaw rate below which nothing is learned: a nose that stays. Engineering
choice."""
LAG_RATIO_RANGE = (0.35, 2.0)
"""Ratio to the prior lag: no other is believed. Engineering choice: yaw from twice as weak to thrice as strong as
usual."""
TORQUE_LAG_RANGE = (0.03, 0.4)
"""s: no other torque lag is believed. Engineering choice: no filter and quick motors, to PX4's filter and 0.3 s."""
DAMPING_MAX = 3.0
"""1/s, of the body's turning: no more is believed. Engineering choice: PX4's simulated quadrotor has 0.83."""
PRIOR_STD = (1.0, 0.06, 0.5, 0.5)
"""1/s of 1/T, s of theta, 1/s of the damping, rad/s^2 of the offset: standard deviations at first. Engineering choice:
rate gains from 0.6 to 1.4 of the usual ones, motors from 15 to 60 ms, a damping from none to twice that of PX4's
simulated quadrotor."""
WALK = (0.02, 2e-5, 0.002, 0.09)
"""Number a second: the variances of their random walks. Engineering choice: they are found within 8 s of a
figure-eight, a bend or two, and the offset follows within one."""
WALK_TIME_MAX = 1.0
"""s of walking at most between two updates, however long the nose stayed. Engineering choice: what was found stays."""
ERROR_VARIANCE = 0.5
"""(rad/s^2)^2, of the equation at each update. Engineering choice: 0.1 to 0.2 rad/s^2 is what is left over on the
simulated loops, in errors that last for some ten updates."""

Triple = tuple[float, float, float]
"""The stages of a third-order low-pass, rad/s."""
Unknowns = tuple[float, float, float, float]
"""1/T (1/s), theta (s), damping (1/s), offset (rad/s^2)."""
Covariance = tuple[tuple[float, ...], ...]
"""Of the unknowns, row by row."""


class YawLoopEstimate(NamedTuple):
    """What is known of the yaw loop."""

    prior: float  # s, the lag it began with
    integral_rate: float  # 1/s, I/P
    unknowns: Unknowns
    covariance: Covariance
    rate: Triple = (0.0, 0.0, 0.0)  # the filter's stages of r
    drive: Triple = (0.0, 0.0, 0.0)  # and of u
    integral: float = 0.0  # rad/s, the I term of u
    last: float = 0.0  # rad/s, the last yaw rate
    rate_mean: float = 0.0  # rad/s, of the filtered rate
    swing: float = 0.0  # (rad/s)^2, its variance
    ran: float = 0.0  # s since the last reset
    waited: float = 0.0  # s since the last update
    at: float = -math.inf  # s, the vehicle's clock, of the last yaw rate

    @property
    def lag(self) -> float:
        """s, T."""
        return 1.0 / self.unknowns[0]

    @property
    def damping(self) -> float:
        """1/s, of the body's turning."""
        return self.unknowns[2]

    @property
    def torque_lag(self) -> float:
        """s, theta."""
        return self.unknowns[1]


def initial_yaw_loop_estimate(
    r: float, lag: float = YAW_LAG, torque_lag: float = YAW_TORQUE_LAG, integral_rate: float = YAW_INTEGRAL_RATE
) -> YawLoopEstimate:
    """Nothing seen yet but a yaw rate (rad/s). ``lag``, ``torque_lag``: s. ``integral_rate``: 1/s, I/P."""
    unknowns = (1.0 / lag, clamped(torque_lag, *TORQUE_LAG_RANGE), 0.0, 0.0)
    covariance = tuple(tuple(s * s if i == j else 0.0 for j in range(4)) for i, s in enumerate(PRIOR_STD))
    return YawLoopEstimate(lag, integral_rate, unknowns, covariance, rate=(r, r, r), last=r)


def reset_yaw_loop(known: YawLoopEstimate, r: float) -> YawLoopEstimate:
    """The filter put on a yaw rate (rad/s) that stays; what was found stays too."""
    return known._replace(
        rate=(r, r, r), drive=(0.0, 0.0, 0.0), integral=0.0, last=r, swing=0.0, rate_mean=r, ran=0.0, waited=0.0,
        at=-math.inf,
    )  # fmt: skip


def update_yaw_loop_estimate(
    known: YawLoopEstimate, commands: tuple[TimedCommand, ...], now: float, r: float
) -> YawLoopEstimate:
    """``known`` after the commands in force until ``now`` (s, the vehicle's clock) and a yaw rate (rad/s)."""
    prior, integral_rate, unknowns, covariance, rate, drive, integral, last, rate_mean, swing, ran, waited, at = known
    dt = now - at
    if dt <= 0.0:
        return known
    if dt > GAP_MAX:
        return reset_yaw_loop(known, r)._replace(at=now)
    mean = 0.5 * (r + last)
    error = active_command(commands, now - 0.5 * dt).rates_b[2] - mean
    integral += dt * (integral_rate * error - integral / INTEGRAL_TIME)
    k = 1.0 - math.exp(-FILTER_POLE * dt)
    rate, drive = _filter(rate, mean, k), _filter(drive, error + integral, k)
    ran, waited = ran + dt, waited + dt
    off = rate[2] - rate_mean
    share = dt / MEAN_TIME
    rate_mean += share * off
    swing = (1.0 - share) * (swing + share * off * off)
    known = YawLoopEstimate(
        prior, integral_rate, unknowns, covariance, rate, drive, integral, r, rate_mean, swing, ran, waited, at=now
    )
    if waited < PERIOD or ran < SETTLING_TIME or swing < SWING_MIN:
        return known
    return _learn(known)


def _filter(stages: Triple, value: float, k: float) -> Triple:
    a, b, c = stages
    a += k * (value - a)
    b += k * (a - b)
    return a, b, c + k * (b - c)


def _learn(known: YawLoopEstimate) -> YawLoopEstimate:
    """The Kalman filter's step: r' = u / T - theta r'' - damping r + offset, of filtered values."""
    (a, b, c), dt = known.rate, min(known.waited, WALK_TIME_MAX)
    slope, bend = FILTER_POLE * (b - c), FILTER_POLE * FILTER_POLE * (a - 2.0 * b + c)
    seen = (known.drive[2], -bend, -c, 1.0)
    P = [
        [value + (walk * dt if i == j else 0.0) for j, value in enumerate(row)]
        for i, (row, walk) in enumerate(zip(known.covariance, WALK, strict=True))
    ]
    cross = [_product(row, seen) for row in P]
    variance = _product(cross, seen) + ERROR_VARIANCE
    error = (slope - _product(known.unknowns, seen)) / variance
    gain, theta, damping, offset = (x + k * error for x, k in zip(known.unknowns, cross, strict=True))
    shortest, longest = LAG_RATIO_RANGE
    gain = clamped(gain, 1.0 / (longest * known.prior), 1.0 / (shortest * known.prior))
    return known._replace(
        unknowns=(gain, clamped(theta, *TORQUE_LAG_RANGE), clamped(damping, 0.0, DAMPING_MAX), offset),
        covariance=tuple(
            tuple(value - k * other / variance for value, other in zip(row, cross, strict=True))
            for row, k in zip(P, cross, strict=True)
        ),
        waited=0.0,
    )


def _product(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))
