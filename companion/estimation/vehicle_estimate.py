"""The estimate block of a vehicle that flies its own rate loop: its motion, and what its rate loop makes of commands.

    advance_estimate   model of the rate loop, gyro observer, prediction of position and velocity
    learn_pending      Kalman filter and identification of the rate loop with that same state

When which is called: see ``motion_estimate``.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.estimator import Prior
from companion.estimation.motion_estimate import (
    MotionEstimate,
    advance_motion,
    begin_motion,
    known_prior,
    learn_motion,
)
from companion.estimation.motor_lag import MotorLag, propagate_by_lag, told_motor_lag
from companion.estimation.predictor import PredictedState, predict
from companion.estimation.rate_loop_identification import (
    RateLoopEstimate,
    initial_rate_loop_estimate,
    reset,
    update_rate_loop_estimate,
)
from companion.estimation.rate_loop_model import (
    RateLoop,
    RateLoopState,
    TimedCommand,
    correct_with_gyro,
    propagate,
    propagate_yaw,
)
from companion.estimation.thrust_curve import UNKNOWN, ThrustCurve
from companion.estimation.yaw_loop_identification import (
    YawLoopEstimate,
    initial_yaw_loop_estimate,
    reset_yaw_loop,
    update_yaw_loop_estimate,
)
from companion.vehicle import VehicleState

Commands = tuple[TimedCommand, ...]

UPRIGHT_MIN = 0.5
"""Cosine of the tilt: the least that a hover thrust is divided by. Engineering choice: 60 degrees."""


class VehicleEstimate(NamedTuple):
    """What is known of the vehicle at the stamp of its last state.

    ``motion``: position, velocity, forces. ``rate_loop_state``: of the model. ``identification``: of the rate loop;
    ``yaw_loop``: of the yaw loop; ``rate_loop``: the figures that are used, rounded to a millisecond, yaw to ten, so
    that the transitions that were worked out for them are found again. ``thrust_by_lag``: m/s^3, what the specific
    thrust of ``rate_loop_state`` would be more, over s that the motors' lag is more.
    """

    motion: MotionEstimate
    rate_loop_state: RateLoopState
    identification: RateLoopEstimate
    yaw_loop: YawLoopEstimate
    rate_loop: RateLoop
    thrust_by_lag: float = 0.0


def begin_estimate(
    state: VehicleState, prior: Prior, gravity: float, rate_loop: RateLoop, lag: float,
    motor_lag: MotorLag | None = None, thrust_curve: ThrustCurve = UNKNOWN,
) -> VehicleEstimate:  # fmt: skip
    """Hovering, as far as anybody knows. ``rate_loop``: as told; ``lag``: s, as last found; ``motor_lag``,
    ``thrust_curve``: as found before."""
    motor_lag = motor_lag or told_motor_lag(rate_loop.motor_lag)
    motion = begin_motion(state, prior, gravity, motor_lag, thrust_curve)
    hovering = gravity / (max(state.r_nb[8], UPRIGHT_MIN) * motion.estimator.belief.thrust_scale)
    identification = initial_rate_loop_estimate(lag, state.w_b, rate_loop.lag)
    rate_loop_state = RateLoopState(state.w_b, (0.0, 0.0, 0.0), hovering)
    yaw_loop = initial_yaw_loop_estimate(
        state.w_b[2], rate_loop.yaw_lag, rate_loop.yaw_torque_lag, rate_loop.yaw_integral
    )
    used = _rate_loop_of(identification, round(motor_lag.lag, 3), yaw_loop)
    return VehicleEstimate(motion, rate_loop_state, identification, yaw_loop, used)


def restart_estimate(estimate: VehicleEstimate, state: VehicleState) -> VehicleEstimate:
    """A beginning at ``state`` that keeps what was learned of the vehicle."""
    rate_loop = estimate.rate_loop
    motion, found = estimate.motion, estimate.motion.estimator
    again = begin_estimate(
        state, known_prior(motion), motion.gravity, rate_loop, rate_loop.lag, found.motor_lag, found.thrust_curve
    )
    return again._replace(
        identification=reset(estimate.identification, state.w_b),
        yaw_loop=reset_yaw_loop(estimate.yaw_loop, state.w_b[2]),
        rate_loop=rate_loop,
    )


def advance_estimate(
    estimate: VehicleEstimate, commands: Commands, state: VehicleState, limited: bool, moving: bool
) -> VehicleEstimate:
    """``estimate`` at a new state. ``limited``: the last command met a limit; ``moving``: it was told to fly
    somewhere."""
    before, now = estimate.motion.state.t_boot, state.t_boot
    rate_loop_state, thrust = propagate(estimate.rate_loop_state, estimate.rate_loop, commands, before, now)
    rate_loop_state = correct_with_gyro(rate_loop_state, state.w_b, now - before, estimate.rate_loop)
    thrust_before, motor_lag = estimate.rate_loop_state.specific_thrust, estimate.rate_loop.motor_lag
    thrust_by_lag, mean_by_lag = propagate_by_lag(
        estimate.thrust_by_lag, thrust_before, motor_lag, commands, before, now
    )
    motion, at_once = advance_motion(estimate.motion, thrust, state, limited, moving, mean_by_lag)
    estimate = VehicleEstimate(
        motion, rate_loop_state, estimate.identification, estimate.yaw_loop, estimate.rate_loop, thrust_by_lag
    )
    return learn_pending(estimate, commands) if at_once else estimate


def learn_pending(estimate: VehicleEstimate, commands: Commands) -> VehicleEstimate:
    """``estimate`` with the filter and the identification updated. ``commands``: those of the last
    ``rate_loop_identification.PERIOD`` at least."""
    measurement, state = estimate.motion.pending, estimate.motion.state
    if measurement is None:
        return estimate
    motion = learn_motion(estimate.motion)
    rate_loop, motor_lag = estimate.rate_loop, round(motion.estimator.motor_lag.lag, 3)
    # what was clipped or restrained did not happen as it was commanded
    if measurement.limited or motion.estimator.restrained:
        found = reset(estimate.identification, state.w_b)
        yaw_loop = reset_yaw_loop(estimate.yaw_loop, state.w_b[2])
    else:
        found = update_rate_loop_estimate(estimate.identification, motor_lag, commands, state.t_boot, state.w_b)
        yaw_loop = update_yaw_loop_estimate(estimate.yaw_loop, commands, state.t_boot, state.w_b[2])
    same = found.lags == estimate.identification.lags and yaw_loop.unknowns is estimate.yaw_loop.unknowns
    if not same or motor_lag != rate_loop.motor_lag:
        rate_loop = _rate_loop_of(found, motor_lag, yaw_loop)
    return VehicleEstimate(motion, estimate.rate_loop_state, found, yaw_loop, rate_loop, estimate.thrust_by_lag)


def predict_vehicle(estimate: VehicleEstimate, commands: Commands, horizon: float) -> PredictedState:
    """The vehicle ``horizon`` s after the last state."""
    motion = estimate.motion
    return predict(
        motion.p_n,
        motion.v_n,
        motion.state.q_nb,
        estimate.rate_loop_state,
        motion.forces,
        estimate.rate_loop,
        commands,
        motion.state.t_boot,
        horizon,
    )


def predict_yaw(estimate: VehicleEstimate, commands: Commands, horizon: float) -> tuple[float, float]:
    """Its yaw rate (rad/s) and the derivative of that (rad/s^2) ``horizon`` s after the last state."""
    at = estimate.motion.state.t_boot
    return propagate_yaw(estimate.rate_loop_state, estimate.rate_loop, commands, at, at + horizon)


def _rate_loop_of(found: RateLoopEstimate, motor_lag: float, yaw_loop: YawLoopEstimate) -> RateLoop:
    roll, pitch = found.lags
    return RateLoop(
        (round(roll, 3), round(pitch, 3)), motor_lag, round(yaw_loop.lag, 2), round(yaw_loop.torque_lag, 2),
        round(yaw_loop.damping, 1), yaw_loop.integral_rate,
    )  # fmt: skip
