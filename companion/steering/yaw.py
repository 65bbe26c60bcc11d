"""Yaw compensation: the yaw rate to command, as the inverse of the model of the yaw loop with its authority limit.

The yaw loop turns the rate error into torque, which comes later by theta, with a disturbance at its input (its trim,
observed by the rate loop model):

    T (theta r'' + r') = r_cmd + trim - r

PX4's is several times slower than its tilting loops. So that the rate follows the law's, r -> r_d, with error dynamics
of poles at -k and -1/theta, what is to be commanded is its inverse:

    r_cmd = r + T a - trim        a = r_d' + k (r_d - (r + theta r')),  |T a| <= authority

r and r' are those at the time when the command acts, by prediction; r + theta r' is where the rate ends if nothing more
is done; r_d and r_d' are the law's theta later. T a is the rate error that the vehicle's own loop turns into torque:
motors have only so much of it left beside thrust and tilting, which carry the vehicle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from companion.estimation.rate_loop_model import YAW_LAG, YAW_TORQUE_LAG, RateLoop
from companion.estimation.translation import acceleration
from companion.frames import Heading, Vec3, clamped, turned, wrap
from companion.law.errors import LawError
from companion.law.feedback import YAW_RETURN_RATE
from companion.law.flight import Command, Flying
from companion.steering.limits import THRUST_MAX
from companion.steering.steering import Aim
from companion.vehicle import Tuning

YAW_LAG_OVER_TILT_LAG = 7.0
"""Ratio: a vehicle whose tilting rate loops are quicker than PX4's usual ones has a quicker yaw loop: at most so
many of their lags, before it is identified. Engineering choice."""
YAW_ERROR_RATE = 2.5
"""Ratio k T of the error dynamics to the loop: quicker, because the loop alone would leave a heading that gusts have
turned for long. Engineering choice. Never quicker than its torque, k <= 1/theta; and where PX4 smooths what it is sent
it comes late and would swing the nose at 4 to 8 rad/s: there it is less, and 1 (the inverse alone) at least."""
BEND_RATE = 5.0
"""rad/s, of what a bend asks of the yaw rate. Engineering choice: a bend of a figure-eight, 0.6 s long."""
YAW_LAG_MIN = 0.02
"""s: what is quicker counts as this quick. Engineering choice."""
YAW_THRUST_PER_RATE = 0.2
"""s/rad: the part of the motors' range that a yaw rate error takes. PX4's default MC_YAWRATE_P."""
SHORT_LIVED = 0.4
"""Share of a roll or pitch rate error that counts: a large one lasts less long than the yaw torque is filtered.
Engineering choice."""
TILT_THRUST_PER_RATE = SHORT_LIVED * 0.15
"""s/rad: the same of a roll or pitch rate error. PX4's default MC_ROLLRATE_P."""
YAW_AUTHORITY_MIN = 0.05
"""rad/s of yaw rate error that are always left to yaw. Engineering choice."""
MOTION_STEP_RANGE = (0.025, 0.1)
"""s of the motion that is wanted, each of the three steps in which it is followed. Engineering choice: over less its
derivative is rounding, over more the steps are coarse."""
SMOOTHING_TIME = 0.03
"""s, time constant with which it is smoothed: T multiplies it by 0.4 s, and the noise of the estimate with it.
Engineering choice."""


class ThrustPerRate(NamedTuple):
    """s/rad: the part of the motors' range that a rate error takes, roll or pitch (``tilt``) and yaw."""

    tilt: float = TILT_THRUST_PER_RATE
    yaw: float = YAW_THRUST_PER_RATE


USUAL_THRUST_PER_RATE = ThrustPerRate()


def thrust_per_rate(tuning: Tuning) -> ThrustPerRate:
    """By a vehicle's own gains, PX4's usual where it does not say."""
    usual = USUAL_THRUST_PER_RATE
    p, k, yaw_p, yaw_k = tuning.roll_rate_p, tuning.roll_rate_k, tuning.yaw_rate_p, tuning.yaw_rate_k
    tilt = usual.tilt if not p else SHORT_LIVED * p * (k if k is not None else 1.0)
    yaw = usual.yaw if not yaw_p else yaw_p * (yaw_k if yaw_k is not None else 1.0)
    return ThrustPerRate(max(tilt, 0.2 * usual.tilt), max(yaw, 0.2 * usual.yaw))


class YawRequest(NamedTuple):
    """What was asked of the law, and what it answered: from where its yaw rate is to be looked for, ``ahead`` s later.
    ``dt``: s since the state before."""

    flying: Flying
    command: Command
    aim: Aim
    dt: float
    ahead: float

    @property
    def step(self) -> float:
        """s, each of the three steps of the motion that is wanted in which the law is asked again."""
        return clamped(0.5 * (self.ahead + SMOOTHING_TIME), *MOTION_STEP_RANGE)


class YawAhead(NamedTuple):
    """The yaw rate that the law will ask for: how much more than now, rad/s, and its derivative then, rad/s^2."""

    more: float = 0.0
    derivative: float = 0.0


class YawMemory(NamedTuple):
    """``ahead``: smoothed; ``pending``: from where it is to be looked for next, None once it was; ``requested``:
    whether the last step asked for it."""

    ahead: YawAhead = YawAhead()
    pending: YawRequest | None = None
    requested: bool = False


class YawLoop(NamedTuple):
    """The model that is inverted. ``lag``: T, s. ``torque_lag``: theta, s. ``error_rate``: k, 1/s."""

    lag: float
    torque_lag: float
    error_rate: float


def yaw_authority(
    zeta: float, zeta_dot: float, most: float, tilt_rate_error: float, per_rate: ThrustPerRate = USUAL_THRUST_PER_RATE,
    torque_lag: float = YAW_TORQUE_LAG,
) -> float:  # fmt: skip
    """rad/s of yaw rate error that the motors can turn into torque: what thrust and tilting leave of their range when
    the torque comes, ``torque_lag`` s later.

    ``zeta``, ``most``: N, thrust and its largest; ``zeta_dot``: N/s. ``tilt_rate_error``: rad/s, |p| + |q|.
    """
    thrust_used = (zeta + zeta_dot * torque_lag) / most * THRUST_MAX
    thrust_used += per_rate.tilt * tilt_rate_error
    return max(YAW_AUTHORITY_MIN, (THRUST_MAX - thrust_used) / per_rate.yaw)


def usual_yaw_lag(rate_loop_lag: float) -> float:
    """s, of the yaw loop before it is identified. ``rate_loop_lag``: s, of the tilting loops by the vehicle file."""
    return max(min(YAW_LAG, YAW_LAG_OVER_TILT_LAG * rate_loop_lag), YAW_LAG_MIN)


def yaw_loop(rate_loop: RateLoop, lag: float, smoothing: float) -> YawLoop:
    """The loop as found. ``lag``: s, of the tilting rate loops as found, with ``smoothing``: s."""
    yaw_lag = max(rate_loop.yaw_lag, YAW_LAG_MIN)
    ratio = 1.0 + (YAW_ERROR_RATE - 1.0) * (1.0 - smoothing / lag) ** 2
    return YawLoop(yaw_lag, rate_loop.yaw_torque_lag, min(ratio / yaw_lag, 1.0 / rate_loop.yaw_torque_lag))


def torque_delay(torque_lag: float) -> float:
    """s by which the torque (its lag: s) comes late in a bend."""
    return math.atan(BEND_RATE * torque_lag) / BEND_RATE


def compensate_yaw(
    loop: YawLoop, wanted: float, derivative: float, r: float, r_dot: float, trim: float, authority: float
) -> float:
    """rad/s, the yaw rate to command: the inverse above.

    ``wanted``: r_d, rad/s, and ``derivative``: r_d', rad/s^2, by the law. ``r``: rad/s, ``r_dot``: rad/s^2, when the
    command acts. ``trim``: rad/s. ``authority``: rad/s of yaw rate error.
    """
    acceleration = derivative + loop.error_rate * (wanted - (r + loop.torque_lag * r_dot))
    error = clamped(loop.lag * acceleration, -authority, authority)
    return r + clamped(error - trim, -authority, authority)


def request_yaw_ahead(yaw: YawMemory, request: YawRequest) -> YawMemory:
    """``yaw`` after a step: every other one is often enough."""
    return YawMemory(yaw.ahead, None if yaw.requested else request, not yaw.requested)


def update_yaw_ahead(yaw: YawMemory, ahead: YawAhead, dt: float) -> YawMemory:
    """``yaw`` with what was pending, smoothed; states come every ``dt`` s, and it is looked for at every other one."""
    k = min(1.0, 2.0 * dt / SMOOTHING_TIME)
    (more, derivative), (more_now, derivative_now) = yaw.ahead, ahead
    smoothed = YawAhead(more + k * (more_now - more), derivative + k * (derivative_now - derivative))
    return YawMemory(smoothed, None, yaw.requested)


def look_ahead(
    request: YawRequest, law: Callable[[Flying, Aim], Command], gravity: float, mass: float, yaw_gain: float,
    heading: Heading,
) -> YawAhead:  # fmt: skip
    """What the law will ask for: it is asked again in three steps of the motion it wants, with the heading error as it
    is. The derivative is that of SMOOTHING_TIME further on, by which it comes late. Nothing where the law is not
    defined there, which it will say when it comes there."""
    flying, command, aim, _, ahead = request
    h = request.step
    rates = [command.turn[2]]
    try:
        for _ in range(3):
            flying = _later(flying, command, h, gravity, mass, yaw_gain, heading)
            command = law(flying, aim)
            rates.append(command.turn[2])
    except LawError:
        return YawAhead()
    now, first, second, third = rates
    share = clamped(ahead / h, 0.0, 2.0)
    then = first + (share - 1.0) * (second - first) if share > 1.0 else now + share * (first - now)
    return YawAhead(then - now, (third - first) / (2.0 * h))


def _later(
    flying: Flying, command: Command, h: float, gravity: float, mass: float, yaw_gain: float, heading: Heading
) -> Flying:
    """``flying`` after ``h`` s of a command, without the part that turns the heading error out."""
    r, (x, y, z), (vx, vy, vz) = flying.r_nb, flying.p_n, flying.v_n
    p, q, s = command.turn
    per_turn = 1.0 if heading is Heading.TWIST else (r[0] * r[0] + r[3] * r[3]) / max(r[8], 0.2)
    s += clamped(yaw_gain * wrap(command.yaw - command.beta), -YAW_RETURN_RATE, YAW_RETURN_RATE) * per_turn
    r_then = turned(r, (p, q, s), h)
    zeta = max(flying.zeta + h * command.zeta_derivative, 0.5 * flying.zeta)
    # the mean thrust, of both ends
    f, g = 0.5 * flying.zeta / mass, 0.5 * zeta / mass
    specific_thrust_n: Vec3 = (f * r[2] + g * r_then[2], f * r[5] + g * r_then[5], f * r[8] + g * r_then[8])
    ax, ay, az = acceleration(specific_thrust_n, flying.v_n, gravity, flying.drag, flying.disturbance)
    half = 0.5 * h
    return Flying(
        (x + h * (vx + half * ax), y + h * (vy + half * ay), z + h * (vz + half * az)),
        (vx + h * ax, vy + h * ay, vz + h * az),
        r_then,
        zeta,
        *flying[4:],
    )
