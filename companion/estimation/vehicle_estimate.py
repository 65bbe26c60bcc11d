"""The estimate block: all that is known of the vehicle, carried from state to state.

    advance(estimate, state)   model of the rate loop, gyro observer, prediction of position and velocity
    learn(estimate)            Kalman filter and identification of the rate loop with that same state

``learn`` does not feed the setpoint of its own state and may be called after it was sent; the prediction stands in for
it, which differs by the filter's innovation only. Where that is not small ``advance`` learns at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.estimator import (
    EstimatorState,
    Measurement,
    Prior,
    initial_estimator_state,
    innovation_is_small,
    predict_measurement,
    update_estimate,
)
from companion.estimation.kalman_step import DRAG, THRUST_SCALE
from companion.estimation.predictor import ForceModel, PredictedState, predict
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
)
from companion.frames import Vec3
from companion.vehicle import VehicleState

Commands = tuple[TimedCommand, ...]

UPRIGHT_MIN = 0.5
"""The least cosine of the tilt that a hover thrust is divided by."""


class VehicleEstimate(NamedTuple):
    """What is known of the vehicle at the stamp of ``state``.

    ``state``: the last one. ``gravity``: m/s^2. ``estimator``: updated with it, or with the one before where
    ``pending`` is not None. ``p_n`` m, ``v_n`` m/s: estimated position and its derivative. ``rate_loop_state``: of the
    model. ``identification``: of the rate loop; ``rate_loop``: the figures that are used, on a grid of a millisecond.
    ``pending``: the measurement that the filter has not been updated with yet.
    """

    state: VehicleState
    gravity: float
    estimator: EstimatorState
    p_n: Vec3
    v_n: Vec3
    rate_loop_state: RateLoopState
    identification: RateLoopEstimate
    rate_loop: RateLoop
    pending: Measurement | None = None

    @property
    def forces(self) -> ForceModel:
        """As estimated."""
        belief = self.estimator.belief
        return ForceModel(belief.thrust_scale, belief.drag, belief.apparent_disturbance_n, self.gravity)


def begin_estimate(
    state: VehicleState, prior: Prior, gravity: float, rate_loop: RateLoop, lag: float
) -> VehicleEstimate:
    """Hovering, as far as anybody knows. ``rate_loop``: as told; ``lag``: s, as last found."""
    r = state.r_nb
    estimator = initial_estimator_state(state.p_n, state.v_n, r, gravity, prior)
    belief = estimator.belief
    hovering = gravity / (max(r[8], UPRIGHT_MIN) * belief.thrust_scale)
    identification = initial_rate_loop_estimate(lag, state.w_b, rate_loop.lag)
    return VehicleEstimate(
        state=state,
        gravity=gravity,
        estimator=estimator,
        p_n=belief.p_n,
        v_n=belief.v_n,
        rate_loop_state=RateLoopState(state.w_b, (0.0, 0.0, 0.0), hovering),
        identification=identification,
        rate_loop=_used(identification, rate_loop.motor_lag),
    )


def restart_estimate(estimate: VehicleEstimate, state: VehicleState) -> VehicleEstimate:
    """A beginning at ``state`` that keeps what was learned of the vehicle."""
    belief = estimate.estimator.belief
    scale = (belief.thrust_scale, math.sqrt(belief.variance(THRUST_SCALE)))
    drag = (belief.drag, math.sqrt(belief.variance(DRAG)))
    rate_loop = estimate.rate_loop
    again = begin_estimate(state, Prior(scale, drag), estimate.gravity, rate_loop, rate_loop.lag)
    return again._replace(identification=reset(estimate.identification, state.w_b), rate_loop=rate_loop)


def advance_estimate(
    estimate: VehicleEstimate, commands: Commands, state: VehicleState, limited: bool, moving: bool
) -> VehicleEstimate:
    """``estimate`` at a new state. ``limited``: the last command met a limit; ``moving``: it was told to fly
    somewhere."""
    before, now = estimate.state, state.t_boot
    gap = now - before.t_boot
    rate_loop_state, thrust = propagate(estimate.rate_loop_state, estimate.rate_loop, commands, before.t_boot, now)
    rate_loop_state = correct_with_gyro(rate_loop_state, state.w_b, gap)
    # the thrust axis, a mean of both ends
    old, new = before.r_nb, state.r_nb
    half = 0.5 * thrust
    thrust_n = (half * (old[2] + new[2]), half * (old[5] + new[5]), half * (old[8] + new[8]))
    measurement = Measurement(gap, thrust_n, state.p_n, state.v_n, limited, state.resets != before.resets, moving)
    p_n, v_n = predict_measurement(estimate.estimator.belief, measurement, estimate.gravity)
    estimate = estimate._replace(state=state, p_n=p_n, v_n=v_n, pending=measurement, rate_loop_state=rate_loop_state)
    if innovation_is_small(estimate.estimator, measurement, p_n, v_n):
        return estimate
    return learn_pending(estimate, commands)


def learn_pending(estimate: VehicleEstimate, commands: Commands) -> VehicleEstimate:
    """``estimate`` with the filter and the identification updated. ``commands``: those of the last PERIOD at least."""
    measurement, state = estimate.pending, estimate.state
    if measurement is None:
        return estimate
    estimator = update_estimate(estimate.estimator, measurement, estimate.gravity)
    motor_lag = estimate.rate_loop.motor_lag
    # what was clipped or restrained did not happen as it was commanded
    if measurement.limited or estimator.restrained:
        found = reset(estimate.identification, state.w_b)
    else:
        found = update_rate_loop_estimate(estimate.identification, motor_lag, commands, state.t_boot, state.w_b)
    rate_loop = estimate.rate_loop
    if found.lag != estimate.identification.lag:
        rate_loop = _used(found, motor_lag)
    belief = estimator.belief
    return estimate._replace(
        estimator=estimator, p_n=belief.p_n, v_n=belief.v_n, identification=found, rate_loop=rate_loop, pending=None
    )


def predict_vehicle(estimate: VehicleEstimate, commands: Commands, horizon: float) -> PredictedState:
    """The vehicle ``horizon`` s after the last state."""
    state = estimate.state
    return predict(
        estimate.p_n,
        estimate.v_n,
        state.q_nb,
        estimate.rate_loop_state,
        estimate.forces,
        estimate.rate_loop,
        commands,
        state.t_boot,
        horizon,
    )


def _used(found: RateLoopEstimate, motor_lag: float) -> RateLoop:
    return RateLoop(round(found.lag, 3), motor_lag)
