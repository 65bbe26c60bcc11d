"""Body rates and thrust: the paper's design one order earlier, for a vehicle that mixes its own motors.

    estimate -> predict (dead time + rate loop) -> govern speed -> law -> yaw compensation -> limits -> encode

    block               module                          memory
    estimate            estimation.vehicle_estimate     VehicleEstimate
    predict             estimation.predictor            the commands on their way, the dead time
    govern speed        steering.speed_governor         SpeedScale
    law                 law.flight, law.hold            zeta, the dynamic extension (Eq. 4)
    yaw compensation    steering.yaw                    YawMemory
    limits              steering.limits, tilt_barrier   whether the last command met one
    encode              steering.encoding               none
    path poles          steering.path_poles             PathPoles; last, for the law of the next step

Jerk -> body rates and the rate of the thrust. Between a state and the effect of its command lie the link and the rate
loop; so the law is evaluated where its command acts, at the state predicted under the commands already sent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.estimation.dead_time import update_dead_time
from companion.estimation.estimator import Prior
from companion.estimation.learned import Learned
from companion.estimation.predictor import PredictedState
from companion.estimation.rate_loop_model import RateLoop, TimedCommand, recent_commands
from companion.estimation.vehicle_estimate import (
    VehicleEstimate,
    advance_estimate,
    begin_estimate,
    learn_pending,
    predict_vehicle,
    predict_yaw,
    restart_estimate,
)
from companion.frames import Heading, Matrix3, Quaternion, Vec3, rotation_matrix, tilt
from companion.law.flight import Command, Flying, Law
from companion.law.hold import HoldLaw
from companion.steering.encoding import Encoding
from companion.steering.limits import (
    THRUST_MAX,
    LimitedRates,
    LimitedThrust,
    ThrustConversion,
    clamp_thrust,
    levelling_rates,
    limit_rates,
    limit_thrust,
)
from companion.steering.path_poles import AS_WRITTEN, PoleChoice, update_path_poles
from companion.steering.rate_memory import RateMemory
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
from companion.steering.steering import Aim, Along, Steered
from companion.steering.tilt_barrier import within_barrier
from companion.steering.timing import Timing
from companion.steering.yaw import (
    RANGE_ASKED_MOST,
    USUAL_THRUST_PER_RATE,
    ThrustPerRate,
    Turning,
    WantedYaw,
    compensate_yaw,
    range_asked,
    wanted_yaw,
    yaw_authority,
    yaw_loop,
)
from companion.steering.yaw_forecast import forecast_yaw_rates
from companion.thrust_range import ThrustRange
from companion.vehicle import Setpoint, Vehicle, VehicleState

UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)
"""Number: the unit quaternion, the attitude where none is known. By definition."""


@dataclass(frozen=True, slots=True)
class RateSteering:
    """The law at the level of rates for one vehicle."""

    law: Law
    hold: HoldLaw
    vehicle: Vehicle
    range: ThrustRange  # of zeta
    rate_loop: RateLoop  # by the vehicle file
    hover_thrust: float  # normalised, by PX4 or the file
    prior: Prior  # of what is estimated
    encoding: Encoding  # what is sent; what it smooths makes the rate loop so much later
    yaw_gain: float  # 1/s, of h4
    tilt_gain: float  # 1/s, the law's largest on the tilt
    course: Course | None = None  # what lies ahead; None: the speed never yields
    tan_tilt_max: float = math.inf  # of the steepest tilt
    lag: float = 0.06  # s, of the rate loop as last found
    heading: Heading = Heading.PROJECTED  # whose heading h4 is
    per_rate: ThrustPerRate = USUAL_THRUST_PER_RATE  # what rate errors take of the motors' range
    path_pole: float = math.nan  # 1/s, of h1 and h2 as recorded where they were chosen
    pole_choice: PoleChoice = AS_WRITTEN  # how far they may be lowered

    def begin(self, state: VehicleState) -> RateMemory:
        """Hovering, as far as anybody knows."""
        estimate = begin_estimate(state, self.prior, self.vehicle.gravity, self.rate_loop, self.lag)
        return self._begin_at(estimate)

    def steer(
        self, memory: RateMemory, state: VehicleState, dt: float, aim: Aim, round_trip: float | None = None
    ) -> Steered:
        """See Steering: the block diagram above."""
        memory = self._estimate(self.learn(memory), state, dt, round_trip)
        timing = self._timing(memory, dt)
        predicted = predict_vehicle(memory.estimate, memory.commands, timing.horizon)
        conversion = self._conversion(memory)
        capability = self._capability(memory, conversion)
        governor, aim = govern_aim(memory.governor, self.course, aim, capability, dt)
        flying = self._flying(memory, predicted, aim)
        command = self._ask(flying, aim)
        thrust = self._limit_thrust(memory, command, capability, conversion, timing, dt)
        wanted = self._wanted_yaw(command, flying, aim, capability, timing)
        turning = self._turning(memory, command, predicted, thrust, capability, timing)
        loop = yaw_loop(memory.estimate.rate_loop, timing.lag, timing.smoothing)
        yaw_rate, yaw = compensate_yaw(memory.yaw, loop, wanted, turning, dt)
        rates = self._limit_rates(memory, command, flying.r_nb, yaw_rate, timing)
        setpoint = self._encode(memory, rates, thrust, timing)
        estimate, limited = memory.estimate, rates.saturated or thrust.saturated
        bound = limited or range_asked(thrust.sent, rates.sent, state.w_b, self.per_rate) > RANGE_ASKED_MOST
        at = max(estimate.motion.state.t_boot + timing.delay, memory.commands[-1].at)
        memory = RateMemory(
            estimate,
            commands=(*memory.commands, TimedCommand(at, rates.meant, thrust.specific)),
            zeta=thrust.zeta,
            governor=governor,
            yaw=yaw,
            poles=update_path_poles(
                memory.poles, self.pole_choice, rates.sent, tilt(flying.r_nb), dt, along=isinstance(aim, Along)
            ),
            delay=memory.delay,
            limited=is_nothing_learned(estimate.motion, thrust.sent, on_a_bound=bound, slewed=thrust.slew_limited),
            moving=is_to_move(command, aim),
        )
        return self._conclude(memory, setpoint, command, thrust, timing, saturated=limited or thrust.slew_limited)

    def learn(self, memory: RateMemory) -> RateMemory:
        """See Steering."""
        if memory.estimate.motion.pending is None:
            return memory
        return memory._replace(estimate=learn_pending(memory.estimate, memory.commands))

    def level_setpoint(self, state: VehicleState | None, memory: RateMemory | None = None) -> Setpoint:
        """See Steering."""
        thrust, q_nb = self.hover_thrust, UPRIGHT
        if memory is not None:
            thrust, q_nb = self._conversion(memory).hover, memory.estimate.motion.state.q_nb
        if state is not None:
            q_nb = state.q_nb
        rates = (0.0, 0.0, 0.0) if state is None else levelling_rates(state.r_nb)
        return self.encoding.level_setpoint(rates, clamp_thrust(thrust), q_nb)

    def learned_values(self, memory: RateMemory) -> Learned | None:
        """What this flight found out of its vehicle; None if it was too short or not settled."""
        lag = memory.estimate.identification.lag - self.encoding.smoothing
        found = learned_of(memory.estimate.motion, self.hover_thrust, lag)
        return None if found is None else found._replace(yaw_lag=memory.estimate.yaw_loop.lag)

    def _begin_at(self, estimate: VehicleEstimate) -> RateMemory:
        state, hovering = estimate.motion.state, estimate.rate_loop_state.specific_thrust
        first = TimedCommand(-math.inf, state.w_b, hovering)
        return RateMemory(estimate, (first,), self.vehicle.weight / max(state.r_nb[8], 0.5))

    def _estimate(self, memory: RateMemory, state: VehicleState, dt: float, round_trip: float | None) -> RateMemory:
        """Estimate: begun again after a gap and while setpoints are not flown."""
        delay = update_dead_time(memory.delay, round_trip, self.vehicle.dead_time, dt)
        gap = state.t_boot - memory.estimate.motion.state.t_boot
        if begins_anew(gap, dt):
            return self._begin_at(restart_estimate(memory.estimate, state))._replace(delay=delay, poles=memory.poles)
        if gap <= 0.0:
            return memory._replace(delay=delay)
        estimate = advance_estimate(memory.estimate, memory.commands, state, memory.limited, memory.moving)
        commands = recent_commands(memory.commands, state.t_boot - COMMANDS_KEPT)
        return RateMemory(
            estimate, commands, memory.zeta, memory.governor, memory.yaw, memory.poles, delay, memory.limited,
            memory.moving,
        )  # fmt: skip

    def _timing(self, memory: RateMemory, dt: float) -> Timing:
        assert memory.delay is not None
        return Timing(memory.delay, 0.5 * dt, memory.estimate.rate_loop.lag, self.encoding.smoothing)

    def _capability(self, memory: RateMemory, conversion: ThrustConversion) -> Capability:
        most = conversion.scale * conversion.specific(THRUST_MAX)
        return capability_of(memory.estimate.motion.forces, most, self.tan_tilt_max)

    def _flying(self, memory: RateMemory, predicted: PredictedState, aim: Aim) -> Flying:
        """The predicted state as the law takes it."""
        forces = memory.estimate.motion.forces
        return Flying(
            p_n=predicted.p_n,
            v_n=predicted.v_n,
            r_nb=rotation_matrix(predicted.q_nb),
            zeta=memory.zeta,
            disturbance=forces.disturbance_n,
            drag=forces.drag,
            s=aim.s if isinstance(aim, Along) else 0.0,
            pole_scale=memory.poles.scale,
        )

    def _ask(self, flying: Flying, aim: Aim) -> Command:
        return ask(self.law, self.hold, flying, aim)

    def _limit_thrust(
        self, memory: RateMemory, command: Command, capability: Capability, conversion: ThrustConversion,
        timing: Timing, dt: float,
    ) -> LimitedThrust:  # fmt: skip
        """Limits, thrust: it answers sooner than the rates do."""
        # zeta is that of the horizon as this step begins; the command is held for the step, whose middle is meant
        after = timing.hold - (timing.lag - memory.estimate.rate_loop.motor_lag)
        most, zeta_derivative = capability.specific_thrust * self.vehicle.mass, command.zeta_derivative
        return limit_thrust(self.range, memory.zeta, zeta_derivative, dt, most, after, conversion)

    def _conversion(self, memory: RateMemory) -> ThrustConversion:
        motion = memory.estimate.motion
        scale, gravity, curve = motion.forces.thrust_scale, motion.gravity, motion.estimator.thrust_curve
        return ThrustConversion(self.vehicle.mass, scale, self.hover_thrust / gravity, gravity, curve)

    def _wanted_yaw(
        self, command: Command, flying: Flying, aim: Aim, capability: Capability, timing: Timing
    ) -> WantedYaw:
        """Yaw compensation: what the law asks for now, and what the path will."""
        forecast, course = None, self.course
        if course is not None and isinstance(aim, Along):
            scale = aim.speed_scale.value
            s = aim.s + course.direction * scale * course.speed(aim.s) * (timing.delay + timing.hold)
            forecast = forecast_yaw_rates(course, s, scale, capability, self.heading)
        chosen, r = not math.isnan(self.path_pole), flying.r_nb
        return wanted_yaw(command, r, self.heading, self.yaw_gain, forecast, timing.lag, chosen=chosen)

    def _turning(
        self, memory: RateMemory, command: Command, predicted: PredictedState, thrust: LimitedThrust,
        capability: Capability, timing: Timing,
    ) -> Turning:  # fmt: skip
        """Yaw compensation: how the vehicle will turn by itself, and how much it can be turned."""
        (p, q, _), (wp, wq, _) = command.turn, predicted.w_b
        most, estimate = self.vehicle.mass * capability.specific_thrust, memory.estimate
        authority = yaw_authority(memory.zeta, most, abs(p - wp) + abs(q - wq), self.per_rate)
        r, r_dot = predict_yaw(estimate, memory.commands, timing.delay + timing.hold)
        limits = self.vehicle.limits
        fastest = math.inf if limits is None else limits.body_rates[2]
        return Turning(r, r_dot, estimate.rate_loop_state.yaw_trim, authority, fastest)

    def _limit_rates(
        self, memory: RateMemory, command: Command, r_nb: Matrix3, yaw_rate: float, timing: Timing
    ) -> LimitedRates:
        """Relax, tilt barrier, limits: body rates. The rate loop of a vehicle that is restrained must not wind up. Not
        relaxed, poles of -6, -6, -6 swing up within a second at 17 states a second."""
        estimate, (p, q, _), last = memory.estimate, command.turn, memory.commands[-1].rates_b
        ratio = timing.relaxation(self.tilt_gain)
        p, q = last[0] + ratio * (p - last[0]), last[1] + ratio * (q - last[1])
        p, q = within_barrier(p, q, r_nb, self.vehicle.limits)
        turn: Vec3 = (0.0, 0.0, 0.0) if estimate.motion.estimator.restrained else (p, q, yaw_rate)
        return limit_rates(turn, estimate.identification.gains, self.vehicle.limits)

    def _encode(self, memory: RateMemory, rates: LimitedRates, thrust: LimitedThrust, timing: Timing) -> Setpoint:
        """Encode: an attitude setpoint counts from the attitude in which it will be followed."""
        q_nb = memory.estimate.motion.state.q_nb
        if self.encoding.needs_attitude:
            q_nb = predict_vehicle(memory.estimate, memory.commands, timing.attitude).q_nb
        return self.encoding.setpoint(rates.sent, thrust.sent, q_nb)

    def _conclude(
        self, memory: RateMemory, setpoint: Setpoint, command: Command, thrust: LimitedThrust, timing: Timing, *,
        saturated: bool,
    ) -> Steered:  # fmt: skip
        """What came of it. ``memory``: for the next step."""
        estimate = memory.estimate
        return Steered(
            setpoint=setpoint,
            memory=memory,
            command=command,
            zeta=thrust.zeta,
            zeta_dot=thrust.zeta_dot,
            thrust=thrust.newtons,
            saturated=saturated,
            thrust_share=thrust.sent,
            converged=estimate.motion.estimator.converged,
            governor=memory.governor.value,
            estimates=estimates_of(
                estimate.motion, timing.delay, timing.lag - timing.smoothing, estimate.rate_loop.yaw_lag,
                self.path_pole * memory.poles.scale,
            ),
        )  # fmt: skip
