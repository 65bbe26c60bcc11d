"""Motor commands: the paper's own chain. Snap -> torques and thrust -> M^-1 -> commands.

    estimate -> predict (dead time + motors) -> govern speed -> law -> trim -> allocate

    block               module                          memory
    estimate            estimation.motor_estimate       MotorEstimate
    predict             estimation.body_model           the commands on their way, the dead time
    govern speed        steering.speed_governor         SpeedScale
    law                 law.flight, law.hold            Extension, the dynamic extension (Eq. 4)
    allocate            allocation                      whether the last command met a limit
    path poles          steering.path_poles             PathPoles; last, for the law of the next step

Position, velocity and forces are estimated as at the level of rates; where its rate loop stands there, the motors' lag
and the turning of the body (Eq. 2) stand here. A vehicle without limits is the paper's: it is what its file says, its
state is what it says, and nothing is estimated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.allocation import Allocated, Allocation
from companion.estimation.body_model import Body, TimedWrench
from companion.estimation.dead_time import update_dead_time
from companion.estimation.estimator import Prior
from companion.estimation.learned import Learned
from companion.estimation.motor_estimate import (
    MotorEstimate,
    advance_motor_estimate,
    begin_motor_estimate,
    learn_motor_estimate,
    predict_motors,
    restart_motor_estimate,
    trust_state,
)
from companion.estimation.predictor import ForceModel, PredictedState
from companion.estimation.rate_loop_model import recent_commands
from companion.frames import Vec3, clamped, rotation_matrix, tilt, upright_error
from companion.law.flight import Command, Flying, Law
from companion.law.hold import HoldLaw
from companion.law.speed_scale import SpeedScale
from companion.steering.limits import TILT_RATE_MAX
from companion.steering.motor_memory import Extension, MotorMemory
from companion.steering.path_poles import AS_WRITTEN, PoleChoice, update_path_poles
from companion.steering.shared import (
    COMMANDS_KEPT,
    ask,
    begins_anew,
    capability_of,
    estimates_of,
    govern_aim,
    is_nothing_learned,
    is_to_move,
    learned_of,
)
from companion.steering.speed_governor import Capability, Course
from companion.steering.steering import Aim, Along, Estimates, Steered
from companion.steering.tilt_barrier import within_barrier
from companion.steering.timing import Timing
from companion.thrust_range import THRUST_USED_MAX, Bound, ThrustRange
from companion.vehicle import Limits, MotorSetpoint, Vehicle, VehicleState

NO_DISTURBANCE: Vec3 = (0.0, 0.0, 0.0)
"""m/s^2, NED. By definition."""
LEVEL_FREQUENCY = 6.0
"""rad/s of the PD law that levels, critically damped. Engineering choice: PX4's MC_ROLL_P is 6.5 1/s."""
YAW_DAMPING = 4.0
"""1/s, with which it stops the turning. Engineering choice."""


@dataclass(frozen=True, slots=True)
class MotorSteering:
    """The law at the level of motors for one vehicle.

    A command is held until the next one, so it acts as if it came half a step late, and the rotors follow it with a
    lag. The law is therefore evaluated at the state that much after the dead time; at 1 kHz the paper's case 2 (no lag)
    then flies within 0.001 deg of its exact tilt.

    ``rate_lag`` and ``yaw_lag`` are not used, and kept for a flight on rates.
    """

    law: Law
    hold: HoldLaw
    vehicle: Vehicle
    allocation: Allocation
    range: ThrustRange  # of zeta
    body: Body
    prior: Prior  # of what is estimated
    rate_gain: float  # 1/s, the law's largest on the body rates of an upright vehicle
    lift_gain: float  # 1/s, on the rate of the thrust
    limits: Limits | None  # the vehicle's, with the tilt at which it is handed back
    course: Course | None = None  # what lies ahead; None: the speed never yields
    tan_tilt_max: float = math.inf  # of the steepest tilt
    rate_lag: float = 0.06  # s, of the vehicle's own rate loop as last found
    yaw_lag: float = 0.0  # s, of its yaw loop; 0: not known
    path_pole: float = math.nan  # 1/s, of h1 and h2 as recorded where they were chosen
    pole_choice: PoleChoice = AS_WRITTEN  # how far they may be lowered

    @property
    def hover_thrust(self) -> float:
        """Normalised, as the vehicle file's rotors give it."""
        return self.vehicle.weight / self.allocation.thrust_max

    def begin(self, state: VehicleState) -> MotorMemory:
        """zeta = m g, zeta_dot = 0 (the paper's section V)."""
        return self._begin_at(begin_motor_estimate(state, self.prior, self.body, self.vehicle.gravity))

    def steer(
        self, memory: MotorMemory, state: VehicleState, dt: float, aim: Aim, round_trip: float | None = None
    ) -> Steered:
        """See Steering: the block diagram above."""
        memory = self._estimate(self.learn(memory), state, dt, round_trip)
        assert memory.delay is not None
        timing = Timing(memory.delay, 0.5 * dt, self.vehicle.motor_lag, 0.0)
        forces = self._forces(memory.estimate)
        predicted = predict_motors(memory.estimate, forces, self.body, memory.commands, timing.horizon)
        capability = self._capability(forces)
        governor, aim = govern_aim(memory.governor, self.course, aim, capability, dt)
        extension = memory.extension.after(timing.hold)
        flying = _flying(predicted, extension, forces, aim, memory.poles.scale)
        command = ask(self.law, self.hold, flying, aim)
        allocated = self.allocation.allocate(
            (extension.zeta / forces.thrust_scale, *self._torque(memory, command, flying, timing))
        )
        headed = self._headed(command.turn, flying.w_b)
        poles = update_path_poles(
            memory.poles, self.pole_choice, headed, tilt(flying.r_nb), dt, along=isinstance(aim, Along)
        )
        memory = memory._replace(poles=poles)
        return self._conclude(memory, governor, aim, command, extension, allocated, forces, capability, timing, dt)

    def learn(self, memory: MotorMemory) -> MotorMemory:
        """See Steering."""
        estimate = learn_motor_estimate(memory.estimate)
        return memory if estimate is memory.estimate else memory._replace(estimate=estimate)

    def level_setpoint(self, state: VehicleState | None, memory: MotorMemory | None = None) -> MotorSetpoint:
        """Hover thrust, and from a fresh state the torques that turn the thrust axis up and stop the turning."""
        torque = (0.0, 0.0, 0.0) if state is None else self._levelling_torque(state)
        scale = 1.0 if memory is None else self._forces(memory.estimate).thrust_scale
        return MotorSetpoint(self.allocation.allocate((self.vehicle.weight / scale, *torque)).commands)

    def learned_values(self, memory: MotorMemory) -> Learned | None:
        """What this flight found out of its vehicle; None if it was too short or not settled, or nothing is."""
        if not self._observes:
            return None
        found = learned_of(memory.estimate.motion, self.hover_thrust, self.rate_lag)
        return None if found is None else found._replace(yaw_lag=self.yaw_lag)

    @property
    def _observes(self) -> bool:
        return self.vehicle.limits is not None

    def _begin_at(self, estimate: MotorEstimate) -> MotorMemory:
        weight = self.vehicle.weight
        first = TimedWrench(-math.inf, estimate.body_state.acting)
        return MotorMemory(estimate, (first,), Extension(weight))

    def _estimate(self, memory: MotorMemory, state: VehicleState, dt: float, round_trip: float | None) -> MotorMemory:
        """Estimate: begun again after a gap and while setpoints are not flown."""
        # no step of a rate loop stands between the link and the motors
        delay = update_dead_time(memory.delay, round_trip, self.vehicle.dead_time, dt, 0.0)
        gap = state.t_boot - memory.estimate.motion.state.t_boot
        if begins_anew(gap, dt):
            begun = self._begin_at(restart_motor_estimate(memory.estimate, self.body, state))
            return begun._replace(delay=delay, poles=memory.poles)
        if gap <= 0.0:
            return memory._replace(delay=delay)
        if self._observes:
            estimate = advance_motor_estimate(
                memory.estimate, self.body, memory.commands, state, memory.limited, memory.moving
            )
        else:
            estimate = trust_state(memory.estimate, self.body, memory.commands, state)
        commands = recent_commands(memory.commands, state.t_boot - COMMANDS_KEPT)
        return memory._replace(estimate=estimate, commands=commands, delay=delay)

    def _forces(self, estimate: MotorEstimate) -> ForceModel:
        if self._observes:
            return estimate.motion.forces
        return ForceModel(1.0, self.vehicle.drag, NO_DISTURBANCE, self.vehicle.gravity)

    def _capability(self, forces: ForceModel) -> Capability:
        most = THRUST_USED_MAX * forces.thrust_scale * self.allocation.thrust_max / self.vehicle.mass
        return capability_of(forces, most, self.tan_tilt_max)

    def _headed(self, torque: Vec3, w_b: Vec3) -> Vec3:
        """rad/s: the body rates that the law heads for, w + w'/k: what it would ask for at rates."""
        (x, y, _), (jx, jy, _), k = torque, self.vehicle.inertia, self.rate_gain
        return (w_b[0] + x / jx / k, w_b[1] + y / jy / k, w_b[2])

    def _within_rates(self, torque: Vec3, flying: Flying) -> Vec3:
        """``torque`` (N m) as if the body rates that the law heads for were bounded as at rates: far beside the path
        nothing else bounds how fast it turns the body, and the tilt barrier stands here too."""
        limits, k = self.limits, self.rate_gain
        if limits is None:
            return torque
        (x, y, z), (jx, jy, _), (p, q, _) = torque, self.vehicle.inertia, self._headed(torque, flying.w_b)
        p_kept, q_kept = within_barrier(p, q, flying.r_nb, limits)
        p_most, q_most = min(limits.body_rates[0], TILT_RATE_MAX), min(limits.body_rates[1], TILT_RATE_MAX)
        return (
            x + jx * k * (clamped(p_kept, -p_most, p_most) - p), y + jy * k * (clamped(q_kept, -q_most, q_most) - q), z
        )  # fmt: skip

    def _torque(self, memory: MotorMemory, command: Command, flying: Flying, timing: Timing) -> Vec3:
        """Trim, relax: N m to command, without what turns the body anyway. Not relaxed, poles of -6, -6, -6, -14 and a
        motor lag of 50 ms swing at every step. A vehicle that leans moves its height by turning, so that the gain of
        the height's is one on its body rates."""
        w_b, upright = flying.w_b, flying.r_nb[8]
        (u2, u3, u4), (jx, jy, jz) = self._within_rates(command.turn, flying), self.vehicle.inertia
        tp, tq, tr = memory.estimate.body_state.turning(w_b)
        _, l2, l3, l4 = memory.commands[-1].wrench
        ratio = timing.relaxation(self.lift_gain + upright * upright * (self.rate_gain - self.lift_gain))
        return (
            l2 + ratio * (u2 - jx * tp - l2), l3 + ratio * (u3 - jy * tq - l3), l4 + ratio * (u4 - jz * tr - l4)
        )  # fmt: skip

    def _conclude(
        self, memory: MotorMemory, governor: SpeedScale, aim: Aim, command: Command, extension: Extension,
        allocated: Allocated, forces: ForceModel, capability: Capability, timing: Timing, dt: float,
    ) -> Steered:  # fmt: skip
        """The extension integrated within its bounds, what came of it all, and the memory for the next step."""
        estimate, scale = memory.estimate, forces.thrust_scale
        high = capability.specific_thrust * self.vehicle.mass if self._observes else math.inf
        zeta, zeta_dot, before = memory.extension
        # as the torques: the law was asked at half a step of the last zeta_ddot
        zeta_ddot = before + (command.zeta_derivative - before) / (1.0 + self.lift_gain * timing.hold)
        later, later_dot, bound = self.range.twice_integrated(zeta, zeta_dot, zeta_ddot, dt, high)
        sent = self.allocation.wrench(allocated.commands)
        at = max(estimate.motion.state.t_boot + timing.delay, memory.commands[-1].at)
        share = extension.zeta / scale / self.allocation.thrust_max
        memory = MotorMemory(
            estimate,
            commands=(*memory.commands, TimedWrench(at, sent)),
            extension=Extension(later, later_dot, zeta_ddot),
            governor=governor,
            poles=memory.poles,
            delay=memory.delay,
            limited=is_nothing_learned(
                estimate.motion, share, on_a_bound=bound is Bound.LEVEL, slewed=bound is Bound.SLEW
            ),
            moving=is_to_move(command, aim),
        )
        return Steered(
            setpoint=MotorSetpoint(allocated.commands),
            memory=memory,
            command=command,
            zeta=later,
            zeta_dot=later_dot,
            thrust=scale * sent[0] if allocated.saturated else extension.zeta,
            saturated=bound is not Bound.NONE or allocated.saturated,
            thrust_share=share,
            converged=estimate.motion.estimator.converged or not self._observes,
            governor=governor.value,
            estimates=self._estimates(memory, timing) if self._observes else None,
            rotor_left=self._rotor_left(estimate) if self._observes else 1.0,
        )

    def _estimates(self, memory: MotorMemory, timing: Timing) -> Estimates:
        pole = self.path_pole * memory.poles.scale
        return estimates_of(memory.estimate.motion, timing.delay, math.nan, path_pole=pole)

    def _rotor_left(self, estimate: MotorEstimate) -> float:
        """What turns the body beside its motors, as what a single rotor does not give. Damping counts with it: a rotor
        that fails is taken for some at first."""
        body = estimate.body_state
        (jx, jy, _), (x, y, _) = self.vehicle.inertia, body.turning(body.w_b)
        return self.allocation.weakest(body.acting, (-jx * x, -jy * y))

    def _levelling_torque(self, state: VehicleState) -> Vec3:
        """N m: a PD law on the thrust axis, critically damped, without a heading."""
        error_x, error_y = upright_error(state.r_nb)
        p, q, r = state.w_b
        jx, jy, jz = self.vehicle.inertia
        k = LEVEL_FREQUENCY
        return (
            jx * (k * k * error_x - 2.0 * k * p), jy * (k * k * error_y - 2.0 * k * q), -jz * YAW_DAMPING * r
        )  # fmt: skip


def _flying(predicted: PredictedState, extension: Extension, forces: ForceModel, aim: Aim, pole_scale: float) -> Flying:
    """The predicted state as the law takes it."""
    return Flying(
        p_n=predicted.p_n,
        v_n=predicted.v_n,
        r_nb=rotation_matrix(predicted.q_nb),
        zeta=extension.zeta,
        w_b=predicted.w_b,
        zeta_dot=extension.zeta_dot,
        disturbance=forces.disturbance_n,
        drag=forces.drag,
        s=aim.s if isinstance(aim, Along) else 0.0,
        pole_scale=pole_scale,
    )
