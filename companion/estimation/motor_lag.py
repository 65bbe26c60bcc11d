"""The lag of the motors, found by when the thrust that was commanded shows in the velocity.

The filter's innovation r of a velocity goes with the lag L of the thrust model by h = dr/dL, which a step of the filter
tells (``kalman_step``). So the lag follows from r by recursive prediction errors, with the variance V of the lag and S
of the innovation,

    K = -V h / (S + h^2 V),    L += K r,    V = (1 + K h) V + Q dt

Of the positions h is as small as what is not modelled of them: they are not used.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.kalman import Innovation
from companion.estimation.kalman_step import AXES
from companion.estimation.rate_loop_model import (
    MOTOR_LAG_MIN,
    TimedCommand,
    active_command,
    steps_of,
    thrust_transition,
)
from companion.frames import clamped

MOTOR_LAG_STD = 0.02
"""s, standard deviation of the lag that a vehicle file tells. Engineering choice: motors have 15 to 60 ms."""
MOTOR_LAG_RANGE = (0.008, 0.15)
"""s. Engineering choice."""
MOTOR_LAG_Q = 1e-7
"""s, process noise: 2.4 ms in a minute, a battery that sags. Engineering choice."""
INNOVATION_SIGMAS = 3.0
"""Number of standard deviations of an innovation beyond which it says nothing of the lag. Engineering choice."""


class MotorLag(NamedTuple):
    """``lag``: s. ``variance``: s^2; zero where it is taken as told."""

    lag: float
    variance: float


TOLD = MotorLag(0.0, 0.0)
"""s, s^2: where another model than the filter's has the lag, and none is looked for. By definition."""


def told_motor_lag(lag: float) -> MotorLag:
    """By the vehicle file (s)."""
    return MotorLag(clamped(lag, *MOTOR_LAG_RANGE), MOTOR_LAG_STD**2)


def update_motor_lag(known: MotorLag, innovation: Innovation, dt: float) -> MotorLag:
    """``known`` after an ``innovation``, ``dt`` s later."""
    if known.variance == 0.0:
        return known
    lag, variance = correct_by_innovation(known.lag, known.variance + MOTOR_LAG_Q * dt, innovation, innovation.by_lag)
    return MotorLag(clamped(lag, *MOTOR_LAG_RANGE), variance)


def correct_by_innovation(
    value: float, variance: float, innovation: Innovation, slopes: tuple[float, ...], correlation: float = 1.0
) -> tuple[float, float]:
    """A parameter of the thrust and its variance after an ``innovation``. ``slopes``: what that would be more over what
    the parameter is more. ``correlation``: number of innovations that tell as much as an independent one."""
    residuals, variances, _, _ = innovation
    for axis in range(AXES, 2 * AXES):  # of the velocities
        residual, expected, slope = residuals[axis], variances[axis], slopes[axis]
        if residual * residual < INNOVATION_SIGMAS * INNOVATION_SIGMAS * expected:
            gain = -variance * slope / (correlation * expected + slope * slope * variance)
            value, variance = value + gain * residual, (1.0 + gain * slope) * variance
    return value, variance


def propagate_by_lag(
    by_lag: float,
    specific_thrust: float,
    motor_lag: float,
    commands: tuple[TimedCommand, ...],
    begin: float,
    end: float,
) -> tuple[float, float]:
    """m/s^3, what the specific thrust would be more at ``end`` (s), over s that ``motor_lag`` is more, and a mean since
    ``begin``, where it was ``by_lag`` and the specific thrust ``specific_thrust`` (m/s^2). ``commands``: as
    ``propagate`` has them."""
    steps, h = steps_of(begin, end)
    if h <= 0.0:
        return by_lag, by_lag
    motor_lag = max(motor_lag, MOTOR_LAG_MIN)
    left, mean = thrust_transition(motor_lag, h)
    total = 0.0
    for k in range(steps):
        commanded = active_command(commands, begin + (k + 0.5) * h).specific_thrust
        beyond = specific_thrust - commanded
        total += mean * by_lag + beyond * (mean - left) / motor_lag
        by_lag = left * (by_lag + beyond * h / motor_lag**2)
        specific_thrust = commanded + left * beyond
    return by_lag, total / steps
