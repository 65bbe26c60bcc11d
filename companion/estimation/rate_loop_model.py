"""The model of the rate loop and the motors: what stands between a command and what the vehicle does.

    w'' = wn^2 (w_cmd - w) - 2 zeta wn w'        f' = (f_cmd - f) / motor_lag

A proportional rate loop of gain 1/lag around motors of lag tm is exactly this, with wn = 1/sqrt(lag tm) and
zeta = sqrt(lag/tm)/2; its delay for slow commands is ``lag``. With the figures of PX4's simulated quadrotor (71 ms,
50 ms) it is the measured response (wn 17 rad/s, zeta 0.6) to 3 %.

Yaw is slower, so that what is small beside the tilting loops shows: the air damps the body's turning, and the loop's
integral fills in every bend (``yaw_damping``, ``yaw_integral``),

    r'' = (r_cmd + trim - r - T damping r) / (T theta) - r' / theta        trim' = I/P (r_cmd - r)
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Protocol, TypeVar

from companion.frames import Vec3, clamped

STEP = 0.012
"""s, the longest step of a prediction. Engineering choice: half of it is a tenth of the shortest usual lag."""
YAW_LAG = 0.375
"""s, of the yaw rate loop: rate error over the angular acceleration it makes. PX4's default MC_YAWRATE_P 0.2 on its
simulated quadrotor, which a torque of 1 turns by 13.3 rad/s^2."""
YAW_FILTER_LAG = 0.085
"""s, of the yaw torque before the motors. PX4's default filters on it (MC_YAW_TQ_CUTOFF 2 Hz, 80 ms) and on the gyro
(IMU_GYRO_CUTOFF 40 Hz, 5.6 ms)."""
YAW_TORQUE_LAG = YAW_FILTER_LAG + 0.05
"""s, of the yaw torque: the same with the motors of PX4's simulated quadrotor."""
YAW_INTEGRAL_RATE = 0.5
"""1/s: the yaw trim's derivative over the yaw rate error, by the loop's own integral. PX4's defaults MC_YAWRATE_I 0.1
over MC_YAWRATE_P 0.2."""
YAW_OBSERVER_POLE = 8.0
"""1/s: where all three poles of the yaw observer lie, as -8. Engineering choice."""
YAW_TRIM_MAX = 2.0
"""rad/s, the largest trim. Engineering choice: half of the largest yaw rate that is asked for (PX4's MC_YAWRATE_MAX is
3.5)."""
GYRO_TIME = 0.03
"""s, time constant with which roll and pitch rates are drawn to the gyro. Simulated: with 0.006 s a gyro that shakes
by 0.09 rad/s puts twice the noise into the commands (4 deg/s, not 2, on sih_noisy at poles of -5); the path error is
the same."""
GYRO_ACCELERATION_GAIN = 150.0
"""1/s^2, from the gyro's innovation to the derivative of the rates: a damping of 0.7 with GYRO_TIME. Engineering
choice."""
GYRO_ACCELERATION_GAIN_MAX = 12.0
"""1/s, the largest such gain in one step, which keeps the observer stable at low rates. Engineering choice."""
GYRO_STEP_MAX = 0.03
"""s, the longest step of the yaw observer (explicit Euler), which keeps it stable at low rates. Engineering choice."""
LAG_MIN = 0.005
"""s: a rate loop that is quicker counts as this quick. Engineering choice."""
MOTOR_LAG_MIN = 0.004
"""s: motors that are quicker count as this quick. Engineering choice."""


class _HasTime(Protocol):
    @property
    def at(self) -> float:
        """s, the vehicle's clock: when it begins to act."""


Timed = TypeVar("Timed", bound=_HasTime)
"""A command of any level."""


class TimedCommand(NamedTuple):
    """A command that acts from ``at`` on.

    ``at``: s, the vehicle's clock. ``rates_b``: rad/s. ``specific_thrust``: m/s^2, commanded thrust over mass.
    """

    at: float
    rates_b: Vec3
    specific_thrust: float


class RateLoopState(NamedTuple):
    """The state of the model.

    ``w_b``: rad/s, body rates. ``w_dot_b``: rad/s^2. ``specific_thrust``: m/s^2, what the motors make of the commanded
    one. ``yaw_trim``: rad/s, the disturbance of the yaw loop at its input: it turns as if so much more had been
    commanded (an integrator that fills, rotors that do not match).
    """

    w_b: Vec3
    w_dot_b: Vec3
    specific_thrust: float
    yaw_trim: float = 0.0


class RateLoop(NamedTuple):
    """The model's figures. ``lags``: s, of the roll and the pitch rate loop. ``motor_lag``: s. ``yaw_lag``: s, of the
    yaw rate loop; ``yaw_torque_lag``: s, of its torque; ``yaw_damping``: 1/s, of the body's turning; ``yaw_integral``:
    1/s, what its integral adds to the trim over the rate error."""

    lags: tuple[float, float]
    motor_lag: float
    yaw_lag: float = YAW_LAG
    yaw_torque_lag: float = YAW_TORQUE_LAG
    yaw_damping: float = 0.0
    yaw_integral: float = YAW_INTEGRAL_RATE

    @property
    def yaw_gain(self) -> float:
        """Ratio: the yaw rate that stays over what is commanded and the trim; the damping takes the rest. It makes the
        loop quicker as it makes it weaker: what it follows it follows with the lag ``yaw_gain`` times ``yaw_lag``."""
        return 1.0 / (1.0 + self.yaw_lag * self.yaw_damping)

    @property
    def lag(self) -> float:
        """s, of roll and pitch together."""
        return 0.5 * (self.lags[0] + self.lags[1])


def alike(lag: float, motor_lag: float, yaw_lag: float = YAW_LAG) -> RateLoop:
    """Roll and pitch of one lag (s), PX4's filters and the same motors (s) in yaw."""
    return RateLoop((lag, lag), motor_lag, yaw_lag, YAW_FILTER_LAG + motor_lag)


class AxisTransition(NamedTuple):
    """The transition of one axis over a fixed step h: from the deviation y = w - w_cmd and w' to those at the end
    (``yy``, ``yd``, ``dy``, ``dd``) and to the angle turned beyond w_cmd h (``ay``, ``ad``)."""

    yy: float
    yd: float
    dy: float
    dd: float
    ay: float
    ad: float


Transitions = tuple[AxisTransition, AxisTransition, AxisTransition, tuple[float, float]]
"""Of roll, pitch and yaw, and of the thrust (see ``thrust_transition``)."""


@lru_cache(maxsize=512)
def axis_transition(lag: float, motor_lag: float, h: float) -> AxisTransition:
    """The exact solution over ``h`` s under a constant command. ``lag``, ``motor_lag``: s."""
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
    return AxisTransition(yy, yd, dy, dd, ay, ad)


@lru_cache(maxsize=512)
def thrust_transition(motor_lag: float, h: float) -> tuple[float, float]:
    """Of a difference between thrust and command: what remains of it after ``h`` s, and its mean over that time."""
    if motor_lag < MOTOR_LAG_MIN:
        return 0.0, 0.0
    if h == 0.0:
        return 1.0, 1.0
    e = math.exp(-h / motor_lag)
    return e, (1.0 - e) * motor_lag / h


@lru_cache(maxsize=512)
def transitions_of(rate_loop: RateLoop, h: float) -> Transitions:
    """Over ``h`` s."""
    (roll_lag, pitch_lag), motor_lag, yaw_lag, yaw_torque_lag, _, _ = rate_loop
    return (
        axis_transition(roll_lag, motor_lag, h),
        axis_transition(pitch_lag, motor_lag, h),
        axis_transition(rate_loop.yaw_gain * yaw_lag, yaw_torque_lag, h),
        thrust_transition(motor_lag, h),
    )


def steps_of(begin: float, end: float) -> tuple[int, float]:
    """The number of steps of STEP at most from ``begin`` to ``end`` (s), and their length (s)."""
    steps = max(1, math.ceil((end - begin) / STEP - 1e-9))
    return steps, round((end - begin) / steps, 6)


def propagate(
    rate_loop_state: RateLoopState, rate_loop: RateLoop, commands: tuple[TimedCommand, ...], begin: float, end: float
) -> tuple[RateLoopState, float]:
    """The state at ``end`` (s) under the commands in force since ``begin``, and the mean specific thrust in between.

    ``commands``: oldest first; the first one holds from the beginning, the last one on.
    """
    steps, h = steps_of(begin, end)
    if h <= 0.0:
        return rate_loop_state, rate_loop_state.specific_thrust
    roll, pitch, yaw, (left, mean) = transitions_of(rate_loop, h)
    yaw_gain, yaw_integral = rate_loop.yaw_gain, rate_loop.yaw_integral
    (yy, yd, dy, dd, _, _), (jj, jd, ej, edj, _, _), (zz, zd, ez, ed, _, _) = roll, pitch, yaw
    total = 0.0
    for k in range(steps):
        _, (sp, sq, sr), specific_thrust = active_command(commands, begin + (k + 0.5) * h)
        (p, q, r), (pd, qd, rd), f, trim = rate_loop_state
        goal = yaw_gain * (sr + trim)
        yp, yq, yr = p - sp, q - sq, r - goal
        total += specific_thrust + mean * (f - specific_thrust)
        rate_loop_state = RateLoopState(
            (sp + yy * yp + yd * pd, sq + jj * yq + jd * qd, goal + zz * yr + zd * rd),
            (dy * yp + dd * pd, ej * yq + edj * qd, ez * yr + ed * rd),
            specific_thrust + left * (f - specific_thrust),
            trim + h * yaw_integral * (sr - r),
        )
    return rate_loop_state, total / steps


def propagate_yaw(
    rate_loop_state: RateLoopState, rate_loop: RateLoop, commands: tuple[TimedCommand, ...], begin: float, end: float
) -> tuple[float, float]:
    """Yaw rate (rad/s) and its derivative (rad/s^2) alone, as ``propagate`` has them."""
    r, rd, trim = rate_loop_state.w_b[2], rate_loop_state.w_dot_b[2], rate_loop_state.yaw_trim
    steps, h = steps_of(begin, end)
    if h <= 0.0:
        return r, rd
    gain = rate_loop.yaw_gain
    zz, zd, ez, ed, _, _ = axis_transition(gain * rate_loop.yaw_lag, rate_loop.yaw_torque_lag, h)
    for k in range(steps):
        commanded = active_command(commands, begin + (k + 0.5) * h).rates_b[2]
        goal = gain * (commanded + trim)
        y, trim = r - goal, trim + h * rate_loop.yaw_integral * (commanded - r)
        r, rd = goal + zz * y + zd * rd, ez * y + ed * rd
    return r, rd


def recent_commands(commands: tuple[Timed, ...], since: float) -> tuple[Timed, ...]:
    """Those that act at or after ``since`` (s)."""
    past = 0
    while past + 1 < len(commands) and commands[past + 1].at <= since:
        past += 1
    return commands[past:]


def active_command(commands: tuple[Timed, ...], t: float) -> Timed:
    """The command that acts at ``t`` (s)."""
    for command in reversed(commands):
        if command.at <= t:
            return command
    return commands[0]


@lru_cache(maxsize=64)
def yaw_observer(yaw_lag: float, torque_lag: float, gain: float, integral: float) -> Vec3:
    """1/s, 1/s^2, 1/s: gains from the gyro's innovation to yaw rate, its derivative and the trim: those that put the
    poles of r'' = (r_cmd + trim - r / gain) / (yaw_lag theta) - r' / theta, trim' = integral (r_cmd - r), to
    YAW_OBSERVER_POLE. ``yaw_lag``, ``torque_lag`` (theta): s. ``gain``: ratio, and ``integral``: 1/s, see RateLoop."""
    p, decay, per_trim = YAW_OBSERVER_POLE, 1.0 / torque_lag, 1.0 / (yaw_lag * torque_lag)
    l1 = 3.0 * p - decay
    return l1, 3.0 * p * p - decay * l1 - per_trim / gain, p**3 / per_trim - integral


def correct_with_gyro(
    rate_loop_state: RateLoopState, measured_b: Vec3, dt: float, rate_loop: RateLoop
) -> RateLoopState:
    """The observer's correction by the gyro (rad/s), ``dt`` s after the last one."""
    near = 1.0 - math.exp(-dt / GYRO_TIME)
    far = min(GYRO_ACCELERATION_GAIN * dt, GYRO_ACCELERATION_GAIN_MAX)
    (p, q, r), (pd, qd, rd), specific_thrust, trim = rate_loop_state
    ip, iq, ir = measured_b[0] - p, measured_b[1] - q, measured_b[2] - r
    h = min(dt, GYRO_STEP_MAX)
    l1, l2, l3 = yaw_observer(rate_loop.yaw_lag, rate_loop.yaw_torque_lag, rate_loop.yaw_gain, rate_loop.yaw_integral)
    return RateLoopState(
        (p + near * ip, q + near * iq, r + l1 * h * ir),
        (pd + far * ip, qd + far * iq, rd + l2 * h * ir),
        specific_thrust,
        clamped(trim + l3 * h * ir, -YAW_TRIM_MAX, YAW_TRIM_MAX),
    )
