"""The estimate block of a vehicle that takes motor commands: its motion, and how its body turns under them.

advance_motor_estimate   model of motors and body, gyro observer, prediction of position and velocity
learn_motor_estimate     the Kalman filter, every UPDATE_PERIOD: see ``motion_estimate``; the damping of the turning
"""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.angular_damping import NO_TURNING, Regressions, damping_of, update_regressions
from companion.estimation.body_model import (
    TURN_OBSERVER_POLE,
    Body,
    BodyState,
    TimedWrench,
    correct_body_with_gyro,
    predict_body,
    propagate_body,
)
from companion.estimation.estimator import Prior
from companion.estimation.motion_estimate import (
    MotionEstimate,
    advance_motion,
    begin_motion,
    known_prior,
    learn_motion,
)
from companion.estimation.predictor import ForceModel, PredictedState
from companion.vehicle import VehicleState

Commands = tuple[TimedWrench, ...]

UPDATE_PERIOD = 0.006
"""s that the filter is updated over at least: every state of 125 Hz, as at rates, every other one of 250 Hz. Nothing it
looks for is quicker than 0.5 s. Engineering choice."""


class MotorEstimate(NamedTuple):
    """What is known of the vehicle at the stamp of its last state. ``motion``: position, velocity, forces.
    ``body_state``: of the model of motors and body. ``regressions``: what its damping follows from."""

    motion: MotionEstimate
    body_state: BodyState
    regressions: Regressions = NO_TURNING


def begin_motor_estimate(
    state: VehicleState, prior: Prior, body: Body, gravity: float, regressions: Regressions = NO_TURNING
) -> MotorEstimate:
    """Hovering, as far as anybody knows."""
    motion = begin_motion(state, prior, gravity)
    hovering = body.mass * gravity / motion.estimator.belief.thrust_scale
    body_state = BodyState(state.w_b, (hovering, 0.0, 0.0, 0.0), damping=damping_of(regressions))
    return MotorEstimate(motion, body_state, regressions)


def restart_motor_estimate(estimate: MotorEstimate, body: Body, state: VehicleState) -> MotorEstimate:
    """A beginning at ``state`` that keeps what was learned of the vehicle."""
    motion = estimate.motion
    return begin_motor_estimate(state, known_prior(motion), body, motion.gravity, estimate.regressions)


def advance_motor_estimate(
    estimate: MotorEstimate, body: Body, commands: Commands, state: VehicleState, limited: bool, moving: bool
) -> MotorEstimate:
    """``estimate`` at a new state. ``limited``: the last command met a limit; ``moving``: it was told to fly
    somewhere."""
    before, now = estimate.motion.state.t_boot, state.t_boot
    body_state, thrust = propagate_body(estimate.body_state, body, commands, before, now)
    body_state = correct_body_with_gyro(body_state, state.w_b, now - before)
    motion, at_once = advance_motion(estimate.motion, thrust / body.mass, state, limited, moving)
    if motion.estimator.restrained:  # what holds it turns it too: that is no rotor which gives less
        body_state = BodyState(state.w_b, body_state.acting, damping=body_state.damping)
    return MotorEstimate(learn_motion(motion) if at_once else motion, body_state, estimate.regressions)


def learn_motor_estimate(estimate: MotorEstimate) -> MotorEstimate:
    """``estimate`` with the filter and the damping updated, where that is due."""
    pending, body_state = estimate.motion.pending, estimate.body_state
    if pending is None or pending.dt < UPDATE_PERIOD:
        return estimate
    regressions = update_regressions(
        estimate.regressions, body_state.w_b, body_state.trim, body_state.damping, TURN_OBSERVER_POLE, pending.dt
    )
    body_state = body_state._replace(damping=damping_of(regressions))
    return MotorEstimate(learn_motion(estimate.motion), body_state, regressions)


def trust_state(estimate: MotorEstimate, body: Body, commands: Commands, state: VehicleState) -> MotorEstimate:
    """``estimate`` at a new state that is taken as it is: of a vehicle that is what its file says."""
    body_state, _ = propagate_body(estimate.body_state, body, commands, estimate.motion.state.t_boot, state.t_boot)
    motion = estimate.motion._replace(state=state, p_n=state.p_n, v_n=state.v_n)
    return MotorEstimate(motion, body_state._replace(w_b=state.w_b), estimate.regressions)


def predict_motors(
    estimate: MotorEstimate, forces: ForceModel, body: Body, commands: Commands, horizon: float
) -> PredictedState:
    """The vehicle ``horizon`` s after the last state."""
    motion = estimate.motion
    return predict_body(
        motion.p_n,
        motion.v_n,
        motion.state.q_nb,
        estimate.body_state,
        forces,
        body,
        commands,
        motion.state.t_boot,
        horizon,
    )
