"""Identification of the yaw loop: its lag, which tells a strong yaw from a weak one, and the lag of its torque.

    T r' = u - T theta r'' + offset        u = (r_cmd - r) + I/P integral of it

is the vehicle's yaw loop: its P and I terms turn the rate error into torque, which a filter and the motors delay by
theta. Divided by T it is linear in 1/T, theta and the offset. Both sides go through the same low-pass filter of third
order, which gives the derivatives; a Kalman filter on the three unknowns, random walks, is then least squares that
forgets. A yaw loop turns with an offset all the time (drag, rotors that do not match), which is one of them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.rate_loop_identification import GAP_MAX, MEAN_TIME, PERIOD
from companion.estimation.rate_loop_model import YAW_LAG, YAW_TORQUE_LAG, TimedCommand, active_command
from companion.frames import Vec3, clamped

FILTER_POLE = 8.0
"""1/s, of the filter's three poles. Engineering choice: a bend has passed by 4 rad/s, the gyro's noise begins above."""
INTEGRAL_OVER_PROPORTIONAL = 0.5
"""1/s. PX4's defaults MC_YAWRATE_I 0.1 over MC_YAWRATE_P 0.2. Without it lag and torque lag of the simulated loops are
found 25 and 40 % too long."""
INTEGRAL_TIME = 3.0
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
PRIOR_STD: Vec3 = (1.0, 0.04, 0.5)
"""1/s of 1/T, s of theta, rad/s^2 of the offset: standard deviations at first. Engineering choice: rate gains from 0.6
to 1.4 of the usual ones, motors from 15 to 60 ms."""
WALK: Vec3 = (0.02, 2e-5, 0.09)
"""Number a second: the variances of their random walks. Engineering choice: they are found within 8 s of a
figure-eight, a bend or two, and the offset follows within one."""
WALK_TIME_MAX = 1.0
"""s of walking at most between two updates, however long the nose stayed. Engineering choice: what was found stays."""
ERROR_VARIANCE = 0.5
"""(rad/s^2)^2, of the equation at each update. Engineering choice: 0.1 to 0.2 rad/s^2 is what is left over on the
simulated loops, in errors that last for some ten updates."""

Triple = tuple[float, float, float]
"""The stages of a third-order low-pass, rad/s."""
Covariance = tuple[float, float, float, float, float, float]
"""The upper triangle, row by row."""


class YawLoopEstimate(NamedTuple):
    """What is known of the yaw loop."""

    prior: float  # s, the lag it began with
    unknowns: Vec3  # 1/T (1/s), theta (s), offset (rad/s^2)
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
    def torque_lag(self) -> float:
        """s, theta."""
        return self.unknowns[1]


def initial_yaw_loop_estimate(r: float, lag: float = YAW_LAG, torque_lag: float = YAW_TORQUE_LAG) -> YawLoopEstimate:
    """Nothing seen yet but a yaw rate (rad/s)."""
    unknowns = (1.0 / lag, clamped(torque_lag, *TORQUE_LAG_RANGE), 0.0)
    a, b, c = PRIOR_STD
    return YawLoopEstimate(lag, unknowns, (a * a, 0.0, 0.0, b * b, 0.0, c * c), rate=(r, r, r), last=r)


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
    prior, unknowns, covariance, rate, drive, integral, last, rate_mean, swing, ran, waited, at = known
    dt = now - at
    if dt <= 0.0:
        return known
    if dt > GAP_MAX:
        return reset_yaw_loop(known, r)._replace(at=now)
    mean = 0.5 * (r + last)
    error = active_command(commands, now - 0.5 * dt).rates_b[2] - mean
    integral += dt * (INTEGRAL_OVER_PROPORTIONAL * error - integral / INTEGRAL_TIME)
    k = 1.0 - math.exp(-FILTER_POLE * dt)
    rate, drive = _filter(rate, mean, k), _filter(drive, error + integral, k)
    ran, waited = ran + dt, waited + dt
    off = rate[2] - rate_mean
    share = dt / MEAN_TIME
    rate_mean += share * off
    swing = (1.0 - share) * (swing + share * off * off)
    known = YawLoopEstimate(
        prior, unknowns, covariance, rate, drive, integral, r, rate_mean, swing, ran, waited, at=now
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
    """The Kalman filter's step: r' = u / T - theta r'' + offset, of filtered values."""
    (a, b, c), dt = known.rate, min(known.waited, WALK_TIME_MAX)
    slope, bend, u = FILTER_POLE * (b - c), FILTER_POLE * FILTER_POLE * (a - 2.0 * b + c), known.drive[2]
    (gain, theta, offset), (p00, p01, p02, p11, p12, p22) = known.unknowns, known.covariance
    w0, w1, w2 = WALK
    p00, p11, p22 = p00 + w0 * dt, p11 + w1 * dt, p22 + w2 * dt
    # of P phi, phi = (u, -r'', 1)
    m0 = p00 * u - p01 * bend + p02
    m1 = p01 * u - p11 * bend + p12
    m2 = p02 * u - p12 * bend + p22
    s = u * m0 - bend * m1 + m2 + ERROR_VARIANCE
    e = (slope - gain * u + theta * bend - offset) / s
    shortest, longest = LAG_RATIO_RANGE
    return known._replace(
        unknowns=(
            clamped(gain + m0 * e, 1.0 / (longest * known.prior), 1.0 / (shortest * known.prior)),
            clamped(theta + m1 * e, *TORQUE_LAG_RANGE),
            offset + m2 * e,
        ),
        covariance=(
            p00 - m0 * m0 / s, p01 - m0 * m1 / s, p02 - m0 * m2 / s, p11 - m1 * m1 / s, p12 - m1 * m2 / s,
            p22 - m2 * m2 / s,
        ),
        waited=0.0,
    )  # fmt: skip
