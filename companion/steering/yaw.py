"""Yaw compensation: from the yaw rate that the law asks for to the one that is commanded.

PX4's yaw loop is several times slower than its tilting ones, falls short of what it is asked for, and is turned by
torque that thrust and tilting may need.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from companion.estimation.rate_loop_model import YAW_TORQUE_LAG
from companion.estimation.translation import acceleration
from companion.frames import Heading, Vec3, turned, wrap
from companion.law.errors import LawError
from companion.law.flight import Command, Flying
from companion.steering.limits import THRUST_MAX
from companion.steering.steering import Aim

YAW_LEAD = 0.36
"""s, how much earlier than it is wanted a yaw rate is commanded: the lag of PX4's yaw loop at 1 to 3 rad/s."""
YAW_LEAD_OVER_LAG = 6.0
"""A vehicle whose other rate loops are quicker than PX4's usual ones is not led by more than so many of their lags."""
YAW_RATE_ERROR_GAIN = 1.0
"""Extra proportional gain on the predicted yaw rate error, for PX4's usual loops: it doubles the gain of a soft yaw
loop, which would leave a heading that gusts have turned for long. Up to 1 it makes no loop unstable that is stable by
itself. Where PX4 smooths what it is sent, it comes late and would swing the nose at 4 to 8 rad/s; there it is less."""
YAW_INTEGRAL_GAIN = 0.07
"""Of the square of the yaw gain, 1/s^2; a quarter would put both poles of the heading at half the gain. Sweep."""
YAW_INTEGRAL_MAX = 0.3
"""rad/s, anti-windup. Engineering choice: a fifth of the largest yaw rate."""
YAW_INTEGRAL_WITHIN = 0.3
"""rad of heading error within which it is integrated. Engineering choice."""
YAW_THRUST_PER_RATE = 0.2
"""s/rad: the part of the motors' range that a yaw rate error takes. PX4's default MC_YAWRATE_P."""
TILT_THRUST_PER_RATE = 0.06
"""s/rad: the same of a roll or pitch rate error; MC_ROLLRATE_P is 0.15, but a large error lasts less long than the yaw
torque is filtered."""
YAW_AUTHORITY_MIN = 0.05
"""rad/s of yaw rate error that are always left to yaw. Engineering choice."""
DERIVATIVE_STEP = 0.05
"""s over which the derivative of the yaw rate is taken."""
DERIVATIVE_TIME = 0.2
"""s, time constant with which it is smoothed: the lead multiplies it by 0.3 s, and the noise of the estimate with it.
sih_noisy: the yaw rate commanded shakes by 1.1 instead of 2.2 deg/s, the heading error is the same."""


class YawRequest(NamedTuple):
    """What was asked of the law, and what it answered: where the derivative of the yaw rate is to be taken."""

    flying: Flying
    command: Command
    aim: Aim


class YawMemory(NamedTuple):
    """``integral``: rad/s, of the heading error. ``derivative``: rad/s^2, of the yaw rate that the law asks for, as
    last taken; ``pending``: where it is to be taken next."""

    integral: float = 0.0
    derivative: float = 0.0
    pending: YawRequest | None = None


def integrate_heading_error(integral: float, command: Command, yaw_gain: float, dt: float) -> float:
    """rad/s, ``dt`` s later: of the heading error, which a yaw loop that falls short of its peaks would leave."""
    error = wrap(command.yaw - command.beta)
    if abs(error) < YAW_INTEGRAL_WITHIN:
        integral += YAW_INTEGRAL_GAIN * yaw_gain * yaw_gain * error * dt
    return min(max(integral, -YAW_INTEGRAL_MAX), YAW_INTEGRAL_MAX)


def yaw_authority(zeta: float, zeta_dot: float, most: float, tilt_rate_error: float) -> float:
    """rad/s of yaw rate error that the motors can turn into torque: what thrust and tilting leave of their range when
    the torque comes.

    ``zeta``, ``most``: N, thrust and its largest; ``zeta_dot``: N/s. ``tilt_rate_error``: rad/s, |p| + |q|.
    """
    thrust_used = (zeta + zeta_dot * YAW_TORQUE_LAG) / most * THRUST_MAX
    thrust_used += TILT_THRUST_PER_RATE * tilt_rate_error
    return max(YAW_AUTHORITY_MIN, (THRUST_MAX - thrust_used) / YAW_THRUST_PER_RATE)


def compensate_yaw(
    yaw: YawMemory, wanted: float, predicted: float, trim: float, authority: float, lead: tuple[float, float]
) -> float:
    """rad/s, the yaw rate to command.

    ``wanted``: rad/s, by the law, at the horizon; ``predicted``: what it will be there. ``trim``: rad/s, disturbance
    of the loop at its input. ``lead``: s by which the command has to come earlier, and the gain on the rate error.
    """
    time, gain = lead
    r = wanted
    r += time * yaw.derivative + gain * (wanted - predicted)
    r -= trim + yaw.integral
    turning = predicted - trim
    return min(max(r, turning - authority), turning + authority)


def yaw_lead(rate_loop_lag: float, lag: float, smoothing: float) -> tuple[float, float]:
    """(s by which a yaw rate is commanded earlier than the law asks for it, gain on the rate error).

    ``rate_loop_lag``: s, of the vehicle file. ``lag``: s, of the rate loop as found, with ``smoothing``: s.
    """
    lead = min(YAW_LEAD, YAW_LEAD_OVER_LAG * rate_loop_lag)
    return lead - lag, YAW_RATE_ERROR_GAIN * lead / YAW_LEAD * (1.0 - smoothing / lag) ** 2


def update_derivative(yaw: YawMemory, derivative: float, dt: float) -> YawMemory:
    """``yaw`` with the derivative (rad/s^2) smoothed, ``dt`` s after the last state; it is taken every other one."""
    k = min(1.0, 2.0 * dt / DERIVATIVE_TIME)
    return yaw._replace(derivative=yaw.derivative + k * (derivative - yaw.derivative))


def yaw_rate_derivative(
    request: YawRequest, law: Callable[[Flying, Aim], Command], gravity: float, mass: float, yaw_gain: float,
    heading: Heading,
) -> float:  # fmt: skip
    """rad/s^2, of the yaw rate that the law asks for: it is asked again DERIVATIVE_STEP later in the motion it wants,
    with the heading error as it is. Zero where the law is not defined then, which it will say when it comes there."""
    flying, command, aim = request
    h = DERIVATIVE_STEP
    r, f = flying.r_nb, flying.zeta / mass
    (x, y, z), (vx, vy, vz) = flying.p_n, flying.v_n
    thrust_n: Vec3 = (f * r[2], f * r[5], f * r[8])
    ax, ay, az = acceleration(thrust_n, flying.v_n, gravity, flying.drag, flying.disturbance)
    half = 0.5 * h
    p, q, s = command.turn
    # without the part that turns the heading error out
    per_turn = 1.0 if heading is Heading.TWIST else (r[0] * r[0] + r[3] * r[3]) / max(r[8], 0.2)
    s += yaw_gain * wrap(command.yaw - command.beta) * per_turn
    later = flying._replace(
        p_n=(x + h * (vx + half * ax), y + h * (vy + half * ay), z + h * (vz + half * az)),
        v_n=(vx + h * ax, vy + h * ay, vz + h * az),
        r_nb=turned(r, (p, q, s), h),
        zeta=max(flying.zeta + h * command.zeta_derivative, 0.5 * flying.zeta),
    )
    try:
        return (law(later, aim).turn[2] - command.turn[2]) / h
    except LawError:
        return 0.0
