"""Yaw compensation: the yaw rate to command, as the inverse of the model of the yaw loop with its authority limit.

The yaw loop turns the rate error into torque, which comes later by theta, with a disturbance at its input (its trim,
observed by the rate loop model); the body's damping takes a part of every rate, so that only G of what is commanded
stays (see ``rate_loop_model``):

    T (theta r'' + r') = G (r_cmd + trim) - r

PX4's is several times slower than its tilting loops, so the yaw rate that it is to have is planned ahead
(``steering.yaw_reference``), and a heading beside the planned one is turned out as the law says (h4). So that the rate
follows, r -> r_d, with error dynamics of poles at -k and -1/theta, what is to be commanded is the inverse of the model:

    r_cmd = (r + T a) / G - trim      a = r_d' + k (r_d - (r + theta r'))      |r_cmd + trim - r| <= authority

r and r' are those at the time when the command acts, by prediction; r + theta r' is where the rate ends if nothing more
is done; r_d and r_d' are theta later. T a is the rate error that the vehicle's own loop turns into torque: motors have
only so much of it left beside thrust and tilting, which carry the vehicle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.rate_loop_model import YAW_INTEGRAL_RATE, YAW_LAG, RateLoop
from companion.frames import Heading, Matrix3, Vec3, clamped, wrap
from companion.law.feedback import YAW_RETURN_RATE
from companion.law.flight import Command
from companion.steering.limits import THRUST_MAX
from companion.steering.yaw_forecast import FORECAST_LENGTH, FORECAST_STEP, Forecast, rate_at
from companion.steering.yaw_reference import YawDrive, YawReference, advance_reference
from companion.vehicle import Tuning

YAW_LAG_OVER_TILT_LAG = 7.0
"""Ratio: a vehicle whose tilting rate loops are quicker than PX4's usual ones has a quicker yaw loop: at most so
many of their lags, before it is identified. Engineering choice."""
YAW_ERROR_RATE = 2.5
"""Ratio k T of the error dynamics to the loop: quicker, because the loop alone would leave a heading that gusts have
turned for long. Engineering choice. Never quicker than its torque, k <= 1/theta; and where PX4 smooths what it is sent
it comes late and would swing the nose at 4 to 8 rad/s: there it is less, and 1 (the inverse alone) at least."""
CHOSEN_GAIN_SHARE = 0.6
"""Ratio of a gain of h4 that was chosen and not written to k, at most: a damping of 0.65. Engineering choice."""
YAW_LAG_MIN = 0.02
"""s: what is quicker counts as this quick. Engineering choice."""
YAW_THRUST_PER_RATE = 0.2
"""s/rad: the part of the motors' range that a yaw rate error takes. PX4's default MC_YAWRATE_P."""
SHORT_LIVED = 0.4
"""Share of a roll or pitch rate error that counts: a large one lasts less long than the yaw torque is filtered.
Engineering choice."""
TILT_THRUST_PER_RATE = SHORT_LIVED * 0.15
"""s/rad: the same of a roll or pitch rate error. PX4's default MC_ROLLRATE_P."""
UPRIGHT_MIN = 0.2
"""Cosine of the tilt, the least that is divided by. Engineering choice: 78 deg, beyond what is flown."""
RANGE_ASKED_MOST = 1.3
"""Share of a motor's range that is asked for beyond which nothing is learned of the thrust: a rate loop's torque lasts
as short as it comes, and its first tenths are smoothed away. Flown on PX4: a figure-eight whose nose turns by 170 deg/s
came to 1.3 to 1.5, a motor to its limit, the thrust to 0.88 of what was sent, which was taken for a payload. With 1.2 a
real one was found 4 s late once (bench.payload, seed 10)."""
YAW_INTEGRAL_MAX = 3.0
"""1/s: no quicker integral is believed. Engineering choice: its time constant is that of the loop."""
YAW_AUTHORITY_MIN = 0.05
"""rad/s of yaw rate error that are always left to yaw. Engineering choice."""
SMOOTHING_TIME = 0.05
"""s, time constant with which it is smoothed how far the yaw rate that the law asks for is off the forecast: the tilt
as it is told shakes it. Engineering choice."""
FADING_RATE = 6.0
"""1/s at which that fades ahead of now. Engineering choice: as a tilt that noise has asked for, with poles of -5 to
-7."""
FADING = tuple(math.exp(-FADING_RATE * FORECAST_STEP * k) for k in range(FORECAST_LENGTH))
"""Ratio, at the moments of a forecast."""
AUTHORITY_TIMES = (0.1, 4.0)
"""s, time constants with which the authority that the plan counts on follows the one that is left, down and up.
Engineering choice: it is short in bends, and there it counts. With a second both ways airframes that have little of it
planned what they could not stop (bench.airframes, seeds 4 and 10: 4 and 15 deg of heading for 1.4 and 3)."""


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


def yaw_integral(tuning: Tuning) -> float:
    """1/s, the integral of the yaw rate loop over its proportional gain, PX4's usual where a vehicle does not say."""
    p, i = tuning.yaw_rate_p, tuning.yaw_rate_i
    return YAW_INTEGRAL_RATE if not p or i is None else clamped(i / p, 0.0, YAW_INTEGRAL_MAX)


class WantedYaw(NamedTuple):
    """What the law wants at the horizon, ``lead`` s after the command acts. ``rate``: rad/s, its yaw rate but for the
    turning back of a heading error. ``error``: rad, of the heading. ``gain``: 1/s, of h4. ``turns``: ratio of the
    body's turning to the heading's. ``forecast``: rad/s of ``rate`` on the path from when the command acts; None where
    no path is flown. ``chosen``: the gain was not written, and may be less."""

    rate: float
    error: float
    gain: float
    turns: float
    forecast: Forecast | None
    lead: float
    chosen: bool


class Turning(NamedTuple):
    """How the vehicle will turn when the command acts, rad/s: ``r``, its derivative ``r_dot`` (rad/s^2), the ``trim``;
    and what it can do: ``authority``, of yaw rate error; ``most``, the yaw rate that may be commanded."""

    r: float
    r_dot: float
    trim: float
    authority: float
    most: float


class YawMemory(NamedTuple):
    """``reference``: planned; None: nothing yet. ``deviation``: rad/s, of the law's yaw rate from the forecast,
    smoothed. ``authority``: rad/s, that the plan counts on; None: none known."""

    reference: YawReference | None = None
    deviation: float = 0.0
    authority: float | None = None


class YawLoop(NamedTuple):
    """The model that is inverted. ``lag``: T, s. ``torque_lag``: theta, s. ``error_rate``: k, 1/s. ``gain``: G, a
    ratio."""

    lag: float
    torque_lag: float
    error_rate: float
    gain: float = 1.0


def yaw_authority(
    zeta: float, most: float, tilt_rate_error: float, per_rate: ThrustPerRate = USUAL_THRUST_PER_RATE
) -> float:
    """rad/s of yaw rate error that the motors can turn into torque: what thrust and tilting leave of their whole range.

    ``zeta``, ``most``: N, thrust and its largest. ``tilt_rate_error``: rad/s, |p| + |q|.
    """
    used = zeta / most * THRUST_MAX + per_rate.tilt * tilt_rate_error
    return max(YAW_AUTHORITY_MIN, (1.0 - used) / per_rate.yaw)


def range_asked(share: float, rates: Vec3, w_b: Vec3, per_rate: ThrustPerRate) -> float:
    """Share of a motor's range that a thrust (normalised, ``share``) and body ``rates`` (rad/s) ask for together at
    ``w_b``, at most. Beyond 1 a vehicle that mixes its own motors makes less thrust than it is sent."""
    (p, q, r), (wp, wq, wr) = rates, w_b
    return share + per_rate.tilt / SHORT_LIVED * (abs(p - wp) + abs(q - wq)) + per_rate.yaw * abs(r - wr)


def usual_yaw_lag(rate_loop_lag: float) -> float:
    """s, of the yaw loop before it is identified. ``rate_loop_lag``: s, of the tilting loops by the vehicle file."""
    return max(min(YAW_LAG, YAW_LAG_OVER_TILT_LAG * rate_loop_lag), YAW_LAG_MIN)


def yaw_loop(rate_loop: RateLoop, lag: float, smoothing: float) -> YawLoop:
    """The loop as found. ``lag``: s, of the tilting rate loops as found, with ``smoothing``: s."""
    yaw_lag = max(rate_loop.yaw_lag, YAW_LAG_MIN)
    ratio = 1.0 + (YAW_ERROR_RATE - 1.0) * (1.0 - smoothing / lag) ** 2
    gain, theta = rate_loop.yaw_gain, rate_loop.yaw_torque_lag
    return YawLoop(gain * yaw_lag, theta, min(ratio / yaw_lag, 1.0 / theta), gain)


def turns_per_heading(r: Matrix3, heading: Heading) -> float:
    """By how much a body of this attitude has to turn about its own axis for a turn of its heading."""
    return 1.0 if heading is Heading.TWIST else (r[0] * r[0] + r[3] * r[3]) / max(r[8], UPRIGHT_MIN)


def turning_back(gain: float, error: float) -> float:
    """rad/s at which the law turns a heading error (rad) out. ``gain``: 1/s, of h4."""
    return clamped(gain * error, -YAW_RETURN_RATE, YAW_RETURN_RATE)


def wanted_yaw(
    command: Command, r: Matrix3, heading: Heading, gain: float, forecast: Forecast | None, lead: float, *, chosen: bool
) -> WantedYaw:
    """Of what the law asks for at attitude ``r``. ``gain``, ``forecast``, ``lead``, ``chosen``: see WantedYaw."""
    error, turns = wrap(command.yaw - command.beta), turns_per_heading(r, heading)
    return WantedYaw(command.turn[2] + turning_back(gain, error) * turns, error, gain, turns, forecast, lead, chosen)


def compensate_yaw(
    known: YawMemory, loop: YawLoop, wanted: WantedYaw, turning: Turning, dt: float
) -> tuple[float, YawMemory]:
    """rad/s, the yaw rate to command, and what is kept of the plan for the next step, ``dt`` s later."""
    _, _, _, authority, most = turning
    counted_on = authority if known.authority is None else known.authority
    down, up = AUTHORITY_TIMES
    counted_on += min(1.0, dt / (up if authority > counted_on else down)) * (authority - counted_on)
    forecast, deviation = [wanted.rate] * FORECAST_LENGTH, 0.0
    if wanted.forecast is not None:
        off = wanted.rate - rate_at(wanted.forecast, wanted.lead)
        deviation = known.deviation + min(1.0, dt / SMOOTHING_TIME) * (off - known.deviation)
        forecast = [rate + share * deviation for rate, share in zip(wanted.forecast, FADING, strict=True)]
    planned = known.reference or YawReference(rate=forecast[0])
    held = (1.0 - loop.gain) * planned.rate  # of the drive, by the damping
    low = loop.gain * max(-authority, -most - planned.rate) - held
    high = loop.gain * min(authority, most - planned.rate) - held
    drive = YawDrive(loop.lag, loop.torque_lag, loop.gain * counted_on, min(low, 0.0), max(high, 0.0))
    planned = advance_reference(planned, forecast, drive, dt)
    # as at the horizon, where the law has the heading
    error = planned.error + wanted.lead * (planned.rate - rate_at(forecast, 0.5 * wanted.lead))
    gain = min(wanted.gain, CHOSEN_GAIN_SHARE * loop.error_rate) if wanted.chosen else wanted.gain
    back = turning_back(gain, wanted.error - error / wanted.turns) * wanted.turns
    r_d = planned.rate + loop.torque_lag * planned.acceleration - back
    commanded = follow_yaw(loop, r_d, planned.drive / loop.lag, turning)
    return commanded, YawMemory(planned, deviation, counted_on)


def follow_yaw(loop: YawLoop, wanted: float, derivative: float, turning: Turning) -> float:
    """rad/s, the yaw rate to command: the inverse above. ``wanted``: r_d, rad/s, and ``derivative``: r_d', rad/s^2."""
    r, r_dot, trim, authority, _ = turning
    acceleration = derivative + loop.error_rate * (wanted - (r + loop.torque_lag * r_dot))
    error = clamped((loop.lag * acceleration + (1.0 - loop.gain) * r) / loop.gain, -authority, authority)
    return r + clamped(error - trim, -authority, authority)
