"""The blocks that every level has: the law asked, the speed governed, and what is told of the vehicle afterwards.

    estimate -> predict -> govern speed -> law -> limits -> encode

What differs between the levels stands in ``rates`` and ``motors``: the model between a command and the motion, what the
law gives, its limits.
"""

from __future__ import annotations

import math

from companion.estimation.kalman_step import DRAG, THRUST_SCALE
from companion.estimation.learned import FLIGHT_TIME_MIN, Learned
from companion.estimation.motion_estimate import MotionEstimate
from companion.estimation.motor_lag import TOLD
from companion.estimation.predictor import ForceModel
from companion.estimation.rate_loop_identification import GAP_MAX as IDENTIFICATION_GAP_MAX
from companion.estimation.thrust_curve import PROPORTIONAL
from companion.law.flight import Command, Flying, Law
from companion.law.hold import HoldLaw
from companion.law.speed_scale import UNITY, SpeedScale
from companion.steering.limits import THRUST_NEAR_SATURATION
from companion.steering.speed_governor import Capability, Course, govern_speed
from companion.steering.steering import Aim, Along, Estimates

GAP_MAX = 0.5
"""s without a state after which what was flown meanwhile is not known. Engineering choice."""
MOVING_SPEED_MIN = 0.5
"""m/s: a vehicle told to fly faster is expected to move. Engineering choice."""
COMMANDS_KEPT = IDENTIFICATION_GAP_MAX
"""s that commands are kept after they have acted: the longest gap that the identification bridges."""


def begins_anew(gap: float, dt: float) -> bool:
    """Whether the estimate begins again: setpoints are not flown (``dt`` 0), or no state came for ``gap`` s."""
    return dt == 0.0 or gap > GAP_MAX


def is_nothing_learned(motion: MotionEstimate, share: float, *, on_a_bound: bool, slewed: bool) -> bool:
    """Whether what a command does is no lesson. ``share``: of the largest thrust. ``on_a_bound``: of the vehicle.
    ``slewed``: by zeta_dot's bound alone, which teaches a wrong thrust scale until that is known."""
    return on_a_bound or share > THRUST_NEAR_SATURATION or (slewed and not motion.estimator.converged)


def capability_of(forces: ForceModel, specific_thrust: float, tan_tilt_max: float) -> Capability:
    """``specific_thrust``: m/s^2, the largest as the vehicle makes it."""
    return Capability(specific_thrust, tan_tilt_max, forces.drag, forces.disturbance_n, forces.gravity)


def govern_aim(
    governor: SpeedScale, course: Course | None, aim: Aim, capability: Capability, dt: float
) -> tuple[SpeedScale, Aim]:
    """Govern speed: along the path only. ``course`` None: the speed never yields."""
    if not isinstance(aim, Along) or course is None:
        return UNITY, aim
    governor = govern_speed(governor, course, aim.s, aim.speed_scale, capability, dt)
    return governor, Along(aim.s, aim.speed_scale * governor)


def ask(law: Law, hold: HoldLaw, flying: Flying, aim: Aim) -> Command:
    """The law of the aim. LawError."""
    return law(flying, aim.speed_scale) if isinstance(aim, Along) else hold(flying, *aim)


def is_to_move(command: Command, aim: Aim) -> bool:
    """Whether the vehicle was told to fly somewhere."""
    return isinstance(aim, Along) and abs(command.alpha * command.end_scale * aim.speed_scale.value) > MOVING_SPEED_MIN


def estimates_of(
    motion: MotionEstimate, delay: float, lag: float, yaw_lag: float = math.nan, path_pole: float = math.nan
) -> Estimates:
    """For the record. ``delay``: s, the dead time. ``lag``: s, of the rate loop; NaN without one. ``yaw_lag``,
    ``path_pole``: see Estimates."""
    belief, motor_lag, curve = motion.estimator.belief, motion.estimator.motor_lag, motion.estimator.thrust_curve
    of_curve = (math.nan, math.nan) if curve == PROPORTIONAL else (curve.slope, math.sqrt(curve.variance))
    return Estimates(
        hover_scale(motion), belief.drag, belief.disturbance_n, belief.bias_n, delay, lag, yaw_lag, path_pole,
        math.nan if motor_lag == TOLD else motor_lag.lag, *of_curve,
    )  # fmt: skip


def hover_scale(motion: MotionEstimate) -> float:
    """Thrust made over thrust commanded in a hover: the thrust scale where the command is not that of a hover as told,
    and the thrust curve makes a difference."""
    estimator, gravity = motion.estimator, motion.gravity
    return gravity / estimator.thrust_curve.command_for(gravity / estimator.belief.thrust_scale, gravity)


def learned_of(motion: MotionEstimate, hover_thrust: float, rate_lag: float) -> Learned | None:
    """What a flight found out of its vehicle; None if it was too short or not settled. ``hover_thrust``: normalised, as
    told. ``rate_lag``: s."""
    estimator = motion.estimator
    if estimator.flight_time < FLIGHT_TIME_MIN or not estimator.converged:
        return None
    belief = estimator.belief
    hover = hover_thrust / hover_scale(motion)
    scale_std = math.sqrt(belief.variance(THRUST_SCALE)) / belief.thrust_scale
    return Learned(hover, belief.drag, rate_lag, 0.0, hover * scale_std, math.sqrt(belief.variance(DRAG)))
