"""Yaw compensation: the yaw rate to command, as the inverse of the model of the yaw loop with its authority limit.

The yaw loop, one lag T with a disturbance at its input (its trim, observed by the rate loop model):

    T r' + r = r_cmd + trim

PX4's is several times slower than its tilting loops. So that the rate follows the law's, r -> r_d, with the error
dynamics r' = r_d' + k (r_d - r), what is to be commanded is its inverse:

    r_cmd = r + T a - trim        a = r_d' + k (r_d - r),  |a| <= authority / T

``r`` is the predicted rate and ``r_d`` the law's at the horizon, one lag of the tilting loops ahead; T is what the yaw
loop is slower than that. T a is the rate error that the vehicle's own loop turns into torque: motors have only so much
of it left beside thrust and tilting, which carry the vehicle.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from companion.estimation.rate_loop_model import YAW_LAG, YAW_TORQUE_LAG
from companion.estimation.translation import acceleration
from companion.frames import Heading, Vec3, clamped, turned, wrap
from companion.law.errors import LawError
from companion.law.flight import Command, Flying
from companion.steering.limits import THRUST_MAX
from companion.steering.steering import Aim
from companion.vehicle import Tuning

YAW_LAG_USED = 0.84
"""Ratio: the lag of PX4's yaw loop for what turns at 1 to 3 rad/s over that of its model (slow commands): 0.36 s of
0.43."""
YAW_LAG_OVER_TILT_LAG = 7.0
"""Ratio: a vehicle whose tilting rate loops are quicker than PX4's usual ones has a quicker yaw loop: at most so
many of their lags, before it is identified. Engineering choice."""
YAW_ERROR_RATE = 2.0
"""Ratio k T of the error dynamics to the loop, for PX4's usual loops: twice as fast, because the loop alone would
leave a heading that gusts have turned for long. Engineering choice: up to 2 it makes no loop unstable that is stable
by itself. Where PX4 smooths what it is sent it comes late and would swing the nose at 4 to 8 rad/s; there it is
less, and 1 (the inverse alone) at least."""
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
DERIVATIVE_STEP = 0.05
"""s over which the derivative of the yaw rate is taken. Engineering choice."""
DERIVATIVE_TIME = 0.03
"""s, time constant with which it is smoothed: T multiplies it by 0.3 s, and the noise of the estimate with it.
Simulated on sih_noisy: with 0.2 s the yaw rate commanded shakes half as much, and a tangent figure-eight is turned
0.2 deg worse."""


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
    """What was asked of the law, and what it answered: where the derivative of the yaw rate is to be taken. ``dt``: s
    since the state before."""

    flying: Flying
    command: Command
    aim: Aim
    dt: float


class YawMemory(NamedTuple):
    """``derivative``: rad/s^2, of the yaw rate that the law asks for, smoothed; ``pending``: where it is to be taken
    next; ``requested``: whether it was to be taken at the last state, so that it rests at the next."""

    derivative: float = 0.0
    pending: YawRequest | None = None
    requested: bool = False


class YawLoop(NamedTuple):
    """The model that is inverted. ``lag``: T, s. ``error_rate``: k, 1/s."""

    lag: float
    error_rate: float


def yaw_authority(
    zeta: float, zeta_dot: float, most: float, tilt_rate_error: float, per_rate: ThrustPerRate = USUAL_THRUST_PER_RATE
) -> float:
    """rad/s of yaw rate error that the motors can turn into torque: what thrust and tilting leave of their range when
    the torque comes.

    ``zeta``, ``most``: N, thrust and its largest; ``zeta_dot``: N/s. ``tilt_rate_error``: rad/s, |p| + |q|.
    """
    thrust_used = (zeta + zeta_dot * YAW_TORQUE_LAG) / most * THRUST_MAX
    thrust_used += per_rate.tilt * tilt_rate_error
    return max(YAW_AUTHORITY_MIN, (THRUST_MAX - thrust_used) / per_rate.yaw)


def usual_yaw_lag(rate_loop_lag: float) -> float:
    """s, of the yaw loop before it is identified. ``rate_loop_lag``: s, of the tilting loops by the vehicle file."""
    return max(min(YAW_LAG, YAW_LAG_OVER_TILT_LAG * rate_loop_lag), YAW_LAG_MIN)


def yaw_loop(yaw_lag: float, lag: float, smoothing: float) -> YawLoop:
    """The loop beyond the horizon. ``yaw_lag``: s, of the yaw loop as found. ``lag``: s, of the tilting rate loops as
    found, with ``smoothing``: s."""
    beyond = max(YAW_LAG_USED * yaw_lag - lag, YAW_LAG_MIN)
    extra = (YAW_ERROR_RATE - 1.0) * min(1.0, yaw_lag / YAW_LAG) * (1.0 - smoothing / lag) ** 2
    return YawLoop(beyond, (1.0 + extra) / beyond)


def compensate_yaw(
    loop: YawLoop, wanted: float, derivative: float, predicted: float, trim: float, authority: float
) -> float:
    """rad/s, the yaw rate to command: the inverse above.

    ``wanted``: r_d, rad/s, and ``derivative``: r_d', rad/s^2, by the law. ``predicted``: r, rad/s. ``trim``: rad/s.
    ``authority``: rad/s of yaw rate error.
    """
    acceleration = derivative + loop.error_rate * (wanted - predicted)
    error = clamped(loop.lag * acceleration, -authority, authority)
    return predicted - trim + error


def update_derivative(yaw: YawMemory, derivative: float, dt: float) -> YawMemory:
    """``yaw`` with the derivative (rad/s^2) that was pending taken in, smoothed, ``dt`` s after the last state; it is
    taken every other one."""
    k = min(1.0, 2.0 * dt / DERIVATIVE_TIME)
    return YawMemory(yaw.derivative + k * (derivative - yaw.derivative), None, yaw.requested)


def yaw_rate_derivative(
    request: YawRequest, law: Callable[[Flying, Aim], Command], gravity: float, mass: float, yaw_gain: float,
    heading: Heading,
) -> float:  # fmt: skip
    """rad/s^2, of the yaw rate that the law asks for: it is asked again DERIVATIVE_STEP later in the motion it wants,
    with the heading error as it is. Zero where the law is not defined then, which it will say when it comes there."""
    flying, command, aim, _ = request
    h = DERIVATIVE_STEP
    r, f = flying.r_nb, flying.zeta / mass
    (x, y, z), (vx, vy, vz) = flying.p_n, flying.v_n
    specific_thrust_n: Vec3 = (f * r[2], f * r[5], f * r[8])
    ax, ay, az = acceleration(specific_thrust_n, flying.v_n, gravity, flying.drag, flying.disturbance)
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
