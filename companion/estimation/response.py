"""How a vehicle answers a command: its rate loop and its motors, as they stand between what is sent and what happens.

    w'' = wn^2 (w_sent - w) - 2 damping wn w'        f' = (f_sent - f) / motor_lag

A proportional rate loop of gain 1/lag around motors of lag tm is exactly this, with wn = 1/sqrt(lag tm) and
damping = sqrt(lag/tm)/2; its delay for slow commands is ``lag``. With the figures of PX4's simulated quadrotor (71 ms,
50 ms) it is the measured response (wn 17 rad/s, damping 0.6) to 3 %.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from companion.frames import Vec3

STEP = 0.012
"""s, the longest step of a prediction."""
YAW_LAG, YAW_TORQUE_LAG = 0.43, 0.07
"""s: PX4's yaw loop is soft and its torque filtered (MC_YAWRATE_P, MC_YAW_TQ_CUTOFF)."""
YAW_OBSERVER = (9.7, 20.0, 15.4)
"""1/s, 1/s^2, 1/s: draw yaw rate, its derivative and the trim to the gyro; poles at -8 for the lags above."""
YAW_TRIM_MAX = 1.0
LAG_MIN, MOTOR_LAG_MIN = 0.005, 0.004
"""s: what is quicker counts as this quick."""


class Sent(NamedTuple):
    """A command: from ``at`` (s, the vehicle's clock) on, body rates (rad/s) and ``lift`` (m/s^2, thrust over mass as
    asked for)."""

    at: float
    rates_b: Vec3
    lift: float


class Inner(NamedTuple):
    """Body rates rad/s, their derivatives rad/s^2, the lift m/s^2 that the motors make of what was asked for, and
    ``yaw_trim`` rad/s: the vehicle turns as if so much more yaw rate had been asked for (drag of its turning, an
    integral that fills, rotors that do not match)."""

    w_b: Vec3
    w_dot_b: Vec3
    lift: float
    yaw_trim: float = 0.0


class Response(NamedTuple):
    """A vehicle's response. ``lag``: s, of the roll and pitch rate loops. ``motor_lag``: s."""

    lag: float
    motor_lag: float


class Step(NamedTuple):
    """What a step of fixed length does to one axis: deviation y = w - w_sent and w' to those at the end and to the
    angle that was turned beyond w_sent h."""

    yy: float
    yd: float
    dy: float
    dd: float
    ay: float
    ad: float


@lru_cache(maxsize=512)
def axis_step(lag: float, motor_lag: float, h: float) -> Step:
    """The exact solution over ``h`` s under a constant command."""
    lag, motor_lag = max(lag, LAG_MIN), max(motor_lag, MOTOR_LAG_MIN)
    wn2 = 1.0 / (lag * motor_lag)
    decay = 0.5 / motor_lag  # damping wn
    spread = decay * decay - wn2
    if abs(spread) < 1e-6 * wn2:
        spread = 1e-6 * wn2
    omega = math.sqrt(abs(spread))
    e = math.exp(-decay * h)
    if spread > 0.0:
        c, s = math.cosh(omega * h), math.sinh(omega * h) / omega
    else:
        c, s = math.cos(omega * h), math.sin(omega * h) / omega
    yy, yd = e * (c + decay * s), e * s
    dy, dd = -e * wn2 * s, e * (c - decay * s)
    # integrating the equation itself: w'(h) - w'(0) + 2 decay (y(h) - y(0)) = -wn^2 (the angle)
    ay = -(dy + 2.0 * decay * (yy - 1.0)) / wn2
    ad = -(dd - 1.0 + 2.0 * decay * yd) / wn2
    return Step(yy, yd, dy, dd, ay, ad)


@lru_cache(maxsize=512)
def lift_step(motor_lag: float, h: float) -> tuple[float, float]:
    """What remains after ``h`` s of a difference between lift and command, and its mean over that time."""
    if motor_lag < MOTOR_LAG_MIN:
        return 0.0, 0.0
    if h == 0.0:
        return 1.0, 1.0
    e = math.exp(-h / motor_lag)
    return e, (1.0 - e) * motor_lag / h


def followed(inner: Inner, response: Response, sent: tuple[Sent, ...], begin: float, end: float) -> tuple[Inner, float]:
    """The inner state at ``end`` after the commands that were in force since ``begin``, and the mean lift.

    ``sent``: oldest first; the first one holds from the beginning, the last one on.
    """
    steps = max(1, math.ceil((end - begin) / STEP - 1e-9))
    h = round((end - begin) / steps, 6)
    if h <= 0.0:
        return inner, inner.lift
    tilting = axis_step(response.lag, response.motor_lag, h)
    turning = axis_step(YAW_LAG, YAW_TORQUE_LAG, h)
    left, mean = lift_step(response.motor_lag, h)
    total = 0.0
    for k in range(steps):
        _, rates, lift = in_force(sent, begin + (k + 0.5) * h)
        (p, q, r), (pd, qd, rd), f, trim = inner
        goal = rates[2] + trim
        yp, yq, yr = p - rates[0], q - rates[1], r - goal
        total += lift + mean * (f - lift)
        inner = Inner(
            (
                rates[0] + tilting.yy * yp + tilting.yd * pd,
                rates[1] + tilting.yy * yq + tilting.yd * qd,
                goal + turning.yy * yr + turning.yd * rd,
            ),
            (
                tilting.dy * yp + tilting.dd * pd,
                tilting.dy * yq + tilting.dd * qd,
                turning.dy * yr + turning.dd * rd,
            ),
            lift + left * (f - lift),
            trim,
        )
    return inner, total / steps


def in_force(sent: tuple[Sent, ...], t: float) -> Sent:
    """The command that acts at ``t``."""
    for command in reversed(sent):
        if command.at <= t:
            return command
    return sent[0]


def corrected(inner: Inner, measured_b: Vec3, dt: float) -> Inner:
    """``inner`` drawn towards the measured body rates, ``dt`` s after the last ones."""
    near = 1.0 - math.exp(-dt / 0.006)
    far = min(750.0 * dt, 12.0)
    (p, q, r), (pd, qd, rd), lift, trim = inner
    ip, iq, ir = measured_b[0] - p, measured_b[1] - q, measured_b[2] - r
    h = min(dt, 0.03)
    l1, l2, l3 = YAW_OBSERVER
    return Inner(
        (p + near * ip, q + near * iq, r + l1 * h * ir),
        (pd + far * ip, qd + far * iq, rd + l2 * h * ir),
        lift,
        max(-YAW_TRIM_MAX, min(YAW_TRIM_MAX, trim + l3 * h * ir)),
    )
