"""The motion block, alike at every level: position, velocity and forces, carried from state to state.

    advance_motion   the prediction of position and velocity for a new state, under the thrust that acted
    learn_motion     the Kalman filter with that same state

``learn_motion`` does not feed the setpoint of its own state and may be called after it was sent; the prediction stands
in for it, which differs by the filter's innovation only. Where that is not small it is to be called at once. States
that come before it was called are one measurement.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.estimator import (
    ZERO,
    EstimatorState,
    Measurement,
    Prior,
    initial_estimator_state,
    innovation_is_small,
    predict_measurement,
    update_estimate,
)
from companion.estimation.kalman_step import DRAG, THRUST_SCALE
from companion.estimation.motor_lag import TOLD, MotorLag
from companion.estimation.predictor import ForceModel
from companion.estimation.thrust_curve import PROPORTIONAL, ThrustCurve
from companion.frames import Vec3
from companion.vehicle import VehicleState


class MotionEstimate(NamedTuple):
    """What is known of the vehicle's motion at the stamp of ``state``.

    ``state``: the last one. ``estimator``: updated with it, or with the one before where ``pending`` is not None, and
    ``forces``: as it has them. ``p_n`` m, ``v_n`` m/s: estimated position and its derivative. ``pending``: the
    measurement that the filter has not been updated with yet.
    """

    state: VehicleState
    estimator: EstimatorState
    forces: ForceModel
    p_n: Vec3
    v_n: Vec3
    pending: Measurement | None = None

    @property
    def gravity(self) -> float:
        """m/s^2."""
        return self.forces.gravity


def begin_motion(
    state: VehicleState, prior: Prior, gravity: float, motor_lag: MotorLag = TOLD,
    thrust_curve: ThrustCurve = PROPORTIONAL,
) -> MotionEstimate:  # fmt: skip
    """Hovering, as far as anybody knows."""
    estimator = initial_estimator_state(
        state.p_n, state.v_n, state.r_nb, gravity, prior, motor_lag=motor_lag, thrust_curve=thrust_curve
    )
    return motion_of(state, estimator, gravity, ZERO)


def known_prior(estimate: MotionEstimate) -> Prior:
    """What was learned of the vehicle, for a beginning anew."""
    belief = estimate.estimator.belief
    return Prior(
        (belief.thrust_scale, math.sqrt(belief.variance(THRUST_SCALE))), (belief.drag, math.sqrt(belief.variance(DRAG)))
    )


def advance_motion(
    estimate: MotionEstimate, specific_thrust: float, state: VehicleState, limited: bool, moving: bool,
    thrust_by_lag: float = 0.0,
) -> tuple[MotionEstimate, bool]:  # fmt: skip
    """``estimate`` at a new state, and whether the filter is to be updated at once.

    ``specific_thrust``: m/s^2, the mean commanded thrust over mass since the last state, lagged by the motors.
    ``limited``: the last command met a limit; ``moving``: it was told to fly somewhere. ``thrust_by_lag``: m/s^3, what
    ``specific_thrust`` would be more, over s that the motors' lag is more.
    """
    before = estimate.state
    # the thrust axis, a mean of both ends
    (ox, oy, oz), (x, y, z) = before.z_axis_n, state.z_axis_n
    ax, ay, az = 0.5 * (ox + x), 0.5 * (oy + y), 0.5 * (oz + z)
    by_curve = estimate.estimator.thrust_curve.by_slope(specific_thrust, estimate.gravity)
    specific_thrust_n = (specific_thrust * ax, specific_thrust * ay, specific_thrust * az)
    measurement = Measurement(
        state.t_boot - before.t_boot,
        specific_thrust_n,
        state.p_n,
        state.v_n,
        limited,
        state.resets != before.resets,
        moving,
        (thrust_by_lag * ax, thrust_by_lag * ay, thrust_by_lag * az),
        (by_curve * ax, by_curve * ay, by_curve * az),
    )
    estimator, forces = estimate.estimator, estimate.forces
    if estimate.pending is not None:
        measurement = _together(estimate.pending, measurement)
    p_n, v_n = predict_measurement(estimator.belief, measurement, forces)
    estimate = MotionEstimate(state, estimator, forces, p_n, v_n, measurement)
    return estimate, not innovation_is_small(estimator, measurement, p_n, v_n)


def _together(first: Measurement, last: Measurement) -> Measurement:
    """Two measurements, one after the other, as one over the time of both: the mean thrust, the last state."""
    dt = first.dt + last.dt
    share = first.dt / dt
    return Measurement(
        dt,
        _between(last.specific_thrust_n, first.specific_thrust_n, share),
        last.p_n,
        last.v_n,
        first.limited or last.limited,
        first.jumped or last.jumped,
        last.moving,
        _between(last.thrust_by_lag_n, first.thrust_by_lag_n, share),
        _between(last.thrust_by_curve_n, first.thrust_by_curve_n, share),
    )


def _between(a: Vec3, b: Vec3, share: float) -> Vec3:
    """``a``, and a ``share`` of what ``b`` is more."""
    (x, y, z), (fx, fy, fz) = a, b
    return (x + share * (fx - x), y + share * (fy - y), z + share * (fz - z))


def learn_motion(estimate: MotionEstimate) -> MotionEstimate:
    """``estimate`` with the filter updated."""
    if estimate.pending is None:
        return estimate
    estimator = update_estimate(estimate.estimator, estimate.pending, estimate.gravity)
    return motion_of(estimate.state, estimator, estimate.gravity, estimate.pending.specific_thrust_n)


def motion_of(
    state: VehicleState, estimator: EstimatorState, gravity: float, specific_thrust_n: Vec3
) -> MotionEstimate:
    """What an estimator that was updated with ``state`` says of the motion under a thrust (m/s^2)."""
    belief = estimator.belief
    disturbance_n = belief.apparent_disturbance_n(specific_thrust_n)
    forces = ForceModel(belief.thrust_scale, belief.drag, disturbance_n, gravity)
    return MotionEstimate(state, estimator, forces, belief.p_n, belief.v_n)
