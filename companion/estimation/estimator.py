"""The estimator: the Kalman filter, and what keeps it consistent.

freeze      thrust scale and drag are not learned for FREEZE_TIME after anything that is not the model: a clipped
            command, a thrust at its bound, a vehicle that is restrained or stopped
clamp       ||d - LPF(d)|| is clamped: see ``clamps``
levels      how noisy the measurements are follows from their innovations; how much the vehicle's estimate wanders, and
            how strong the gusts are, from what the filter finds of them (expectation maximisation of a stationary
            process: its variance is the mean of estimate squared plus variance of the estimate)
thrust      the motors' lag and the thrust curve are found from the same innovations: see ``motor_lag``,
            ``thrust_curve``
change      where the thrust scale changed all at once (payload, battery) the last second is gone through again
reset       after a jump of the vehicle's own estimate position, velocity and bias are reset, and their
            cross-covariances zeroed
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.calculus.machine_code import unpacked
from companion.estimation.adaptation import NOISE_FIRST, adapt_noise
from companion.estimation.clamps import clamp
from companion.estimation.kalman import (
    Belief,
    Innovation,
    initial_belief,
    predict_and_update,
    reset_disturbance,
    reset_position_velocity,
)
from companion.estimation.kalman_step import DRAG_Q, THRUST_SCALE, THRUST_SCALE_Q
from companion.estimation.motor_lag import TOLD, MotorLag, update_motor_lag
from companion.estimation.noise_levels import NoiseLevels
from companion.estimation.predictor import ForceModel
from companion.estimation.restraint import is_restrained, unexplained_velocity
from companion.estimation.scale_change import (
    MEMORY,
    STEADY,
    ScaleChange,
    fade_scale_change,
    loose_process_noise,
    update_scale_change,
)
from companion.estimation.thrust_curve import PROPORTIONAL, ThrustCurve, update_thrust_curve
from companion.estimation.translation import acceleration
from companion.frames import Matrix3, Vec3

FREEZE_TIME = 0.4
"""s without learning of thrust scale and drag after anything the model does not know. Flights on PX4's simulated
quadrotor: a saturated capture spoiled them for 12 s without."""
THRUST_SCALE_STD = 0.2
"""Ratio: standard deviation of the thrust scale before a flight. Engineering choice: battery and payload of a usual
day."""
DRAG_STD = 0.7
"""1/s, of the drag. Flights on PX4's simulated quadrotor: found within 1 s from there."""
JUMP_POSITION = 0.25
"""m of innovation from which on it may be a jump. Engineering choice: a tenth of what GPS glitches do."""
JUMP_VELOCITY = 0.5
"""m/s of innovation from which on it may be a jump. Engineering choice."""
JUMP_SIGMAS = 10.0
"""Number of standard deviations of the innovation from which on it is a jump. Engineering choice."""
HOVER_SPEED_MAX = 1.0
"""m/s, below which a tilt at the beginning is taken for the wind's. Engineering choice."""
CONVERGED_RATIO = 0.03
"""Ratio of the thrust scale's standard deviation to the scale, at which it is known well enough to follow a path.
Engineering choice."""
CONVERGENCE_TIME_MIN = 0.3
"""s of flight before anything is called converged. Engineering choice."""


ZERO: Vec3 = (0.0, 0.0, 0.0)
"""m and m/s: no difference. By definition."""


class Prior(NamedTuple):
    """What is known before the flight: value and standard deviation of the thrust scale and of the drag (1/s)."""

    thrust_scale: tuple[float, float] = (1.0, THRUST_SCALE_STD)
    drag: tuple[float, float] = (0.0, DRAG_STD)


class EstimatorState(NamedTuple):
    """What is known at a stamp.

    ``belief``: mean and covariance of the filter's state. ``noise``: how noisy it is. ``disturbance_lpf_n``: m/s^2,
    LPF(d). ``freeze_left``: s left without learning. ``flight_time``: s since the first update.
    ``disturbance_saturated``: whether the clamp acts. ``unexplained_velocity_n``: m/s that a vehicle that stands still
    should have come to by the forces on it. ``change``: what speaks for a change of the thrust scale. ``past``: the
    steps of the last MEMORY that led here, none since it went through them again or something was reset.
    ``motor_lag``, ``thrust_curve``: of the thrust.
    """

    belief: Belief
    noise: NoiseLevels
    disturbance_lpf_n: Vec3
    freeze_left: float = 0.0
    flight_time: float = 0.0
    disturbance_saturated: bool = False
    unexplained_velocity_n: Vec3 = (0.0, 0.0, 0.0)
    change: ScaleChange = STEADY
    past: tuple[PastStep, ...] = ()
    motor_lag: MotorLag = TOLD
    thrust_curve: ThrustCurve = PROPORTIONAL

    @property
    def restrained(self) -> bool:
        """Whether something holds the vehicle."""
        return is_restrained(self.unexplained_velocity_n)

    @property
    def converged(self) -> bool:
        """Whether the thrust scale is known well enough to follow a path."""
        belief = self.belief
        close = belief.variance(THRUST_SCALE) < (CONVERGED_RATIO * belief.thrust_scale) ** 2
        return self.flight_time >= CONVERGENCE_TIME_MIN and close


class Measurement(NamedTuple):
    """What the vehicle's estimate says, ``dt`` s after the last time.

    ``specific_thrust_n``: m/s^2, the mean commanded thrust over mass since then, lagged by the motors, along the thrust
    axis; ``thrust_by_lag_n``: m/s^3, what that would be more, over s that the motors' lag is more;
    ``thrust_by_curve_n``: m/s^2, over what the thrust curve is more. ``p_n``: m. ``v_n``: m/s. ``limited``: the last
    command met a limit. ``jumped``: the vehicle says that its estimate was reset. ``moving``: it was told to fly
    somewhere.
    """

    dt: float
    specific_thrust_n: Vec3
    p_n: Vec3
    v_n: Vec3
    limited: bool = False
    jumped: bool = False
    moving: bool = False
    thrust_by_lag_n: Vec3 = ZERO
    thrust_by_curve_n: Vec3 = ZERO


class PastStep(NamedTuple):
    """What was known ``before`` a ``measurement``, without what led there."""

    before: EstimatorState
    measurement: Measurement


def initial_estimator_state(
    p_n: Vec3, v_n: Vec3, r_nb: Matrix3, gravity: float, prior: Prior, noise: NoiseLevels = NOISE_FIRST,
    motor_lag: MotorLag = TOLD, thrust_curve: ThrustCurve = PROPORTIONAL,
) -> EstimatorState:  # fmt: skip
    """Before the first step. A vehicle that hovers leans into the wind, so that the lean says what the wind does."""
    disturbance_n: Vec3 = (0.0, 0.0, 0.0)
    if math.hypot(*v_n) < HOVER_SPEED_MAX and r_nb[8] > 0.5:
        disturbance_n = (gravity * r_nb[2] / r_nb[8], gravity * r_nb[5] / r_nb[8], 0.0)
    belief = initial_belief(p_n, v_n, disturbance_n, prior.thrust_scale, prior.drag, noise)
    return EstimatorState(belief, noise, disturbance_n, motor_lag=motor_lag, thrust_curve=thrust_curve)


def predict_measurement(belief: Belief, measurement: Measurement, forces: ForceModel) -> tuple[Vec3, Vec3]:
    """Position (m) and velocity (m/s) as they are predicted for a measurement. ``forces``: by ``belief``."""
    (px, py, pz), (vx, vy, vz), (fx, fy, fz) = belief.p_n, belief.v_n, measurement.specific_thrust_n
    k, h = forces.thrust_scale, measurement.dt
    half = 0.5 * h
    specific_thrust_n = (k * fx, k * fy, k * fz)
    ax, ay, az = acceleration(specific_thrust_n, (vx, vy, vz), forces.gravity, forces.drag, forces.disturbance_n)
    return (
        (px + h * (vx + half * ax), py + h * (vy + half * ay), pz + h * (vz + half * az)),
        (vx + h * ax, vy + h * ay, vz + h * az),
    )


def innovation_is_small(known: EstimatorState, measurement: Measurement, p_n: Vec3, v_n: Vec3) -> bool:
    """Whether a command may be computed from the prediction (``p_n``, ``v_n``) and the filter be updated afterwards:
    not after a jump, nor while something restrains the vehicle."""
    if measurement.jumped or known.restrained:
        return False
    return _are_near(measurement.p_n, p_n, JUMP_POSITION) and _are_near(measurement.v_n, v_n, JUMP_VELOCITY)


def _are_near(a: Vec3, b: Vec3, most: float) -> bool:
    """Whether each component of two vectors differs by less than ``most``."""
    return -most < a[0] - b[0] < most and -most < a[1] - b[1] < most and -most < a[2] - b[2] < most


def update_estimate(known: EstimatorState, measurement: Measurement, gravity: float) -> EstimatorState:
    """``known`` after another measurement."""
    later = _updated(known, measurement, gravity, (THRUST_SCALE_Q, DRAG_Q))
    return _gone_through_again(later.past, gravity) if later.change.found else later


def _gone_through_again(past: tuple[PastStep, ...], gravity: float) -> EstimatorState:
    """What is known after steps in which the thrust scale may have changed. The next change is looked for anew."""
    known = past[0].before
    for _, measurement in past:
        known = _updated(known, measurement, gravity, loose_process_noise(known.belief.drag))
    return known._replace(change=STEADY, past=())


def _updated(
    known: EstimatorState, measurement: Measurement, gravity: float, noise_of_q: tuple[float, float]
) -> EstimatorState:
    """``known`` after another measurement. ``noise_of_q``: 1/s, 1/s^3, process noise of thrust scale and drag."""
    dt, specific_thrust_n, p_n, v_n, limited, jumped, moving, thrust_by_lag_n, thrust_by_curve_n = measurement
    freeze_left = FREEZE_TIME if limited else max(0.0, known.freeze_left - dt)
    learning = freeze_left == 0.0
    belief, innovation = predict_and_update(
        known.belief, dt, specific_thrust_n, gravity, p_n, v_n, known.noise, learning, *noise_of_q,
        thrust_by_lag_n, thrust_by_curve_n,
    )  # fmt: skip
    flight_time = known.flight_time + dt
    unexplained_velocity_n = ZERO
    if moving:
        k, (fx, fy, fz) = known.belief.thrust_scale, specific_thrust_n
        a_n = acceleration((k * fx, k * fy, k * fz), ZERO, gravity, 0.0, known.disturbance_lpf_n)
        unexplained_velocity_n = unexplained_velocity(known.unexplained_velocity_n, dt, a_n, v_n)
    if is_restrained(unexplained_velocity_n):
        belief = reset_disturbance(known.belief, p_n, v_n, known.disturbance_lpf_n, known.noise)
        return _reset(known, belief, flight_time, unexplained_velocity_n)
    if jumped or _is_jump(innovation):
        belief = reset_position_velocity(known.belief, p_n, v_n, known.noise)
        return _reset(known, belief, flight_time, unexplained_velocity_n)
    if learning:
        change = update_scale_change(known.change, known.belief, belief, noise_of_q, dt)
    else:
        change = fade_scale_change(known.change, dt)
    motor_lag, thrust_curve = known.motor_lag, known.thrust_curve
    if learning and known.converged:
        motor_lag = update_motor_lag(motor_lag, innovation, dt)
        thrust_curve = update_thrust_curve(thrust_curve, innovation, dt)
        belief = _with_curve(belief, thrust_curve.slope - known.thrust_curve.slope)
    belief, disturbance_lpf_n, disturbance_saturated = clamp(belief, known.disturbance_lpf_n, dt, flight_time)
    noise = adapt_noise(
        known.noise, belief, innovation, dt,
        # not frozen: commands that noise drives into their limits would keep it from being found
        measurements=not disturbance_saturated,
        levels=learning and not disturbance_saturated,
    )  # fmt: skip
    return EstimatorState(
        belief,
        noise,
        disturbance_lpf_n,
        FREEZE_TIME if disturbance_saturated else freeze_left,
        flight_time,
        disturbance_saturated,
        unexplained_velocity_n,
        change,
        _lengthened(known, measurement, flight_time),
        motor_lag,
        thrust_curve,
    )


def _with_curve(belief: Belief, more: float) -> Belief:
    """``belief`` with the thrust scale as it is for a thrust curve of so much ``more``: of all that goes with it, that
    alone would take its time to come by itself."""
    if not more:
        return belief
    x, S, G, T, by_lag, by_curve = belief
    scale = x[THRUST_SCALE] + unpacked(by_curve)[THRUST_SCALE] * more
    return Belief((*x[:THRUST_SCALE], scale, *x[THRUST_SCALE + 1 :]), S, G, T, by_lag, by_curve)


def _reset(known: EstimatorState, belief: Belief, flight_time: float, unexplained_velocity_n: Vec3) -> EstimatorState:
    return known._replace(
        belief=belief, freeze_left=FREEZE_TIME, flight_time=flight_time,
        unexplained_velocity_n=unexplained_velocity_n, change=STEADY, past=(),
    )  # fmt: skip


def _lengthened(known: EstimatorState, measurement: Measurement, flight_time: float) -> tuple[PastStep, ...]:
    """The steps of the last MEMORY, one more and the oldest no more."""
    past = (*known.past, PastStep(known._replace(past=()), measurement))
    return past if past[0].before.flight_time >= flight_time - MEMORY else past[1:]


def _is_jump(innovation: Innovation) -> bool:
    """Whether the innovation is that of a jump of the vehicle's own estimate."""
    residual, variance, _, _ = innovation
    x, y, z, u, v, w = residual
    if _are_near((x, y, z), ZERO, JUMP_POSITION) and _are_near((u, v, w), ZERO, JUMP_VELOCITY):
        return False
    most = (JUMP_POSITION,) * 3 + (JUMP_VELOCITY,) * 3
    return any(
        abs(r) > limit and r * r > JUMP_SIGMAS**2 * v for r, v, limit in zip(residual, variance, most, strict=True)
    )
