"""Identification of the rate loops of roll and pitch: lag and gain, from how the body rates follow the commands.

Of each, three models run side by side with lags L/d, L and L d, driven by the commands alone. A parabola through their
mean squared errors against the gyro, over the logarithm of the lag, has its minimum at the lag of the vehicle. Noise
adds the same to all three, and an error of the gain is orthogonal to one of the lag, so neither moves the minimum.

The integrator of PX4's rate loop lets it overshoot what changes slowly, by a few percent: the ratio of the gyro to the
middle model (least squares) is the loop's gain, and so much less is commanded than is meant.

An axis that hardly turns goes along with the other.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from companion.estimation.rate_loop_model import STEP, AxisTransition, TimedCommand, active_command, axis_transition
from companion.frames import Vec3

LOG_SPACING = 0.25
"""Ratio, in the logarithm: between the lags of neighbouring models. Engineering choice: narrow enough for the
parabola."""
MEAN_TIME = 3.0
"""s, time constant of the means of the squared errors. Engineering choice: a bend or two."""
FOLLOW_TIME = 2.0
"""s, time constant with which lag and gain follow. Engineering choice: slower than the vehicle, quicker than a lap."""
SETTLING_TIME = 0.4
"""s after a reset in which the models swing in and nothing is learned: six usual lags. Engineering choice."""
EXCITATION_MIN = (5e-4) ** 2
"""(rad/s)^2: curvature of the parabola, or difference of its ends, below which the commands excite too little.
Engineering choice."""
LAG_RATIO_MIN = 0.9
"""Ratio to the prior lag: no shorter one is sought. Engineering choice: a slow course shows the lag of slow commands
only, which the integrator of PX4's rate loop shortens, and the loop is closed over the fast ones too."""
LAG_RATIO_MAX = 1.6
"""Ratio to the prior lag: no longer one is sought. Engineering choice."""
GAIN_MAX = 1.1
"""Ratio of rates flown to rates commanded: the largest that is believed; never less than 1. PX4's simulated
quadrotor: 1.01 to 1.03."""
GAIN_EXCITATION_MIN = 0.5 * 0.2**2
"""(rad/s)^2: mean square of the rate below which no gain is learned. Engineering choice."""
ALONG_TIME = 3.0
"""s, time constant with which an axis that hardly turns follows the other. Engineering choice."""
PERIOD = 0.024
"""s between two updates. Engineering choice: twice the step of the models."""
GAP_MAX = 0.06
"""s without a state after which the models are reset. Engineering choice: two states of 50 Hz and one that is lost."""

LAG_GRID = 100.0
"""Number: of lags an e-fold of which transitions are computed and kept. Engineering choice: a percent apart."""

Model = tuple[float, float]
"""Body rate and its derivative of one model: rad/s, rad/s^2."""
Models = tuple[Model, Model, Model]
"""With a shorter lag, the estimated one and a longer one."""
CommandedRates = tuple[float, list[Vec3]]
"""What drives the models: their step (s), and the rates in the middle of each (rad/s)."""


class AxisEstimate(NamedTuple):
    """What is known of one axis.

    ``lag``: s. ``models``: with shorter, this and longer lag. ``mean_squared_errors``: (rad/s)^2, theirs. ``gain``:
    rate over command. ``gyro_times_model``, ``model_squared``: (rad/s)^2, means with the middle model.
    """

    lag: float
    models: Models
    mean_squared_errors: Vec3 = (0.0, 0.0, 0.0)
    gain: float = 1.0
    gyro_times_model: float = 0.0
    model_squared: float = 0.0


class RateLoopEstimate(NamedTuple):
    """What is known of the rate loops. ``prior``: s, the lag they began with. ``ran``: s since the last reset. ``at``:
    s, the vehicle's clock, of the last update."""

    roll: AxisEstimate
    pitch: AxisEstimate
    prior: float
    ran: float = 0.0
    at: float = -math.inf

    @property
    def lags(self) -> tuple[float, float]:
        """s, of roll and of pitch."""
        return self.roll.lag, self.pitch.lag

    @property
    def lag(self) -> float:
        """s, of both together."""
        return 0.5 * (self.roll.lag + self.pitch.lag)

    @property
    def gains(self) -> tuple[float, float]:
        """Of roll and of pitch."""
        return self.roll.gain, self.pitch.gain


def initial_rate_loop_estimate(lag: float, w_b: Vec3, prior: float | None = None) -> RateLoopEstimate:
    """Nothing seen yet but body rates (rad/s)."""
    roll, pitch = (AxisEstimate(lag, begin_models(w)) for w in w_b[:2])
    return RateLoopEstimate(roll, pitch, lag if prior is None else prior)


def reset(known: RateLoopEstimate, w_b: Vec3) -> RateLoopEstimate:
    """The models put back on the vehicle's body rates (rad/s); what was found stays."""
    return known._replace(
        roll=known.roll._replace(models=begin_models(w_b[0])), pitch=known.pitch._replace(models=begin_models(w_b[1])),
        ran=0.0, at=-math.inf,
    )  # fmt: skip


def begin_models(rate: float) -> Models:
    """The models on a body rate (rad/s) that does not change."""
    return ((rate, 0.0),) * 3


def update_rate_loop_estimate(
    known: RateLoopEstimate, motor_lag: float, commands: tuple[TimedCommand, ...], now: float, w_b: Vec3
) -> RateLoopEstimate:
    """``known`` after the commands in force until ``now`` (s, the vehicle's clock) and a gyro measurement (rad/s).

    ``commands``: those of the last PERIOD at least, as they were meant. ``motor_lag``: s.
    """
    dt = now - known.at
    if dt < PERIOD:
        return known
    if dt > GAP_MAX:
        return reset(known, w_b)._replace(at=now)
    ran = known.ran + dt
    # a while in which the models swing in
    k = dt / MEAN_TIME if ran >= SETTLING_TIME else 0.0
    driven_by = rates_commanded(commands, known.at, dt)
    roll, pitch = (
        _compare(axis, propagate_models(axis.models, axis.lag, motor_lag, driven_by, i), w_b[i], k)
        for i, axis in enumerate((known.roll, known.pitch))
    )
    if k > 0.0:
        roll, pitch = _learn(roll, pitch, known.prior, dt), _learn(pitch, roll, known.prior, dt)
    return RateLoopEstimate(roll, pitch, known.prior, ran, now)


def rates_commanded(commands: tuple[TimedCommand, ...], begin: float, dt: float) -> CommandedRates:
    """What was commanded in the ``dt`` s from ``begin`` (s, the vehicle's clock) on."""
    steps = max(1, math.ceil(dt / (2.0 * STEP) - 1e-9))
    h = round(dt / steps, 6)
    return h, [active_command(commands, begin + (k + 0.5) * h).rates_b for k in range(steps)]


def propagate_models(models: Models, lag: float, motor_lag: float, commanded: CommandedRates, index: int) -> Models:
    """The models once they were driven by what was ``commanded``. ``lag``: s, of the middle one, taken from LAG_GRID;
    ``index``: 0 roll, 1 pitch."""
    h, rates_b = commanded
    shorter, middle, longer = _transitions(round(LAG_GRID * math.log(lag)), motor_lag, h)
    goals = [rates[index] for rates in rates_b]
    a, b, c = models
    return (_propagate(a, shorter, goals), _propagate(b, middle, goals), _propagate(c, longer, goals))


@lru_cache(maxsize=512)
def _transitions(middle: int, motor_lag: float, h: float) -> tuple[AxisTransition, AxisTransition, AxisTransition]:
    """Over ``h`` s: with a shorter lag, the one of number ``middle`` on the grid, and a longer one."""
    step, spacing = 1.0 / LAG_GRID, round(LAG_GRID * LOG_SPACING)
    a, b, c = (axis_transition(math.exp(step * (middle + k * spacing)), motor_lag, h) for k in (-1, 0, 1))
    return a, b, c


def _propagate(model: Model, step: AxisTransition, goals: list[float]) -> Model:
    (w, wd), (yy, yd, dy, dd, _, _) = model, step
    for goal in goals:
        y = w - goal
        w, wd = goal + yy * y + yd * wd, dy * y + dd * wd
    return (w, wd)


def _compare(axis: AxisEstimate, models: Models, w: float, k: float) -> AxisEstimate:
    """The means after another measurement of the rate (rad/s), of which ``k`` is taken over. ``models``: then."""
    (e1, e2, e3), ((a, _), (b, _), (c, _)) = axis.mean_squared_errors, models
    return AxisEstimate(
        axis.lag,
        models,
        (e1 + k * ((a - w) ** 2 - e1), e2 + k * ((b - w) ** 2 - e2), e3 + k * ((c - w) ** 2 - e3)),
        axis.gain,
        axis.gyro_times_model + k * (b * w - axis.gyro_times_model),
        axis.model_squared + k * (b * b - axis.model_squared),
    )


def _learn(axis: AxisEstimate, other: AxisEstimate, prior: float, dt: float) -> AxisEstimate:
    """Lag and gain drawn to what the means say; to the ``other`` axis's where this one hardly turns."""
    lag, gain, along = axis.lag, axis.gain, dt / ALONG_TIME
    towards = step_to_minimum(axis.mean_squared_errors)
    if towards != 0.0:
        lag *= math.exp(towards * dt / FOLLOW_TIME)
    elif step_to_minimum(other.mean_squared_errors) != 0.0:
        lag += along * (other.lag - lag)
    if axis.model_squared > GAIN_EXCITATION_MIN:
        gain *= 1.0 + (axis.gyro_times_model / axis.model_squared - 1.0) * dt / FOLLOW_TIME
    elif other.model_squared > GAIN_EXCITATION_MIN:
        gain += along * (other.gain - gain)
    return AxisEstimate(
        max(prior * LAG_RATIO_MIN, min(prior * LAG_RATIO_MAX, lag)),
        axis.models,
        axis.mean_squared_errors,
        max(1.0, min(GAIN_MAX, gain)),
        axis.gyro_times_model,
        axis.model_squared,
    )


def step_to_minimum(mean_squared_errors: Vec3) -> float:
    """From the logarithm of the middle lag to the minimum of the parabola; 0 where the commands excite too little."""
    shorter, middle, longer = mean_squared_errors
    curvature = shorter + longer - 2.0 * middle
    if curvature <= EXCITATION_MIN and abs(shorter - longer) <= EXCITATION_MIN:
        return 0.0
    if middle <= shorter and middle <= longer and curvature > 0.0:
        return 0.5 * LOG_SPACING * (shorter - longer) / curvature
    return math.copysign(LOG_SPACING, shorter - longer)
