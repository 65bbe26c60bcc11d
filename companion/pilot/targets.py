"""What is aimed at in each phase, and how fast the path is to be flown just now."""

from __future__ import annotations

import math

from companion.flight.phases import Phase
from companion.frames import Vec3, conjugate, multiply
from companion.law.speed_scale import BACKWARDS, STANDSTILL, UNITY, SpeedScale
from companion.mission import Repeat
from companion.pilot.memory import Memory
from companion.plan import Plan
from companion.steering.steering import Aim, Along, At
from companion.vehicle import AttitudeSetpoint, MotorSetpoint, RateSetpoint, Setpoint, TorqueSetpoint, VehicleState

END_WITHIN = 0.35
"""m before the open end of a path at which the end point is aimed at instead. Engineering choice."""
SCALE_RATE = 2.0
"""1/s, how quickly a new factor on the speed is taken up: critically damped. Engineering choice."""
JOIN_WITHIN = 0.6
"""m from a point within which the vehicle is there (engineering choice)."""
JOIN_SPEED = 0.5
"""m/s below which it is at rest there (engineering choice)."""
REST_WITHIN = 0.018
"""m from the end point of a path within which a vehicle is at it. Engineering choice: what the estimate of a quiet
vehicle allows."""
REST_SPEED = 0.1
"""m/s below which it is at rest there. Engineering choice."""
REST_FOR = 4.0
"""s after which a vehicle that wind and noise keep from that rests well enough where it is at a point and at rest.
Engineering choice."""
TRIM_RATE = 0.6
"""1/s, how quickly the point that is held is moved against the error that is left at the end of a path. Engineering
choice: half of the rate that would make the hold swing (four poles at -2)."""
TRIM_MAX = 0.5
"""m, how far at most. Engineering choice."""
TRIM_SPEED = 0.15
"""m/s below which it is: a vehicle on its way there has no error that stays. Engineering choice."""


def here(plan: Plan, state: VehicleState) -> At:
    """Where the vehicle is and points now."""
    return At(state.p_n, plan.mission.heading.of(state.r_nb))


def on_path(plan: Plan, s: float) -> At:
    """The point of the path at arc length ``s``, looking as the mission wants it there."""
    return At(plan.table.at(s)[0], plan.mission.beta(s))


def join(plan: Plan, state: VehicleState, leg: float) -> At:
    """Where the path is joined: at its beginning where it is open, at its nearest point where it goes round."""
    return on_path(plan, plan.table.locate(state.p_n)[0] if plan.table.closed else beginning(plan, leg))


def beginning(plan: Plan, leg: float) -> float:
    """m, where a leg of an open path begins."""
    return 0.0 if plan.direction * leg > 0.0 else plan.table.length


def end(plan: Plan, leg: float) -> float:
    """m, where a leg of an open path ends."""
    return plan.table.length - beginning(plan, leg)


def remaining(plan: Plan, memory: Memory) -> float:
    """m to the open end of the present leg; inf where the path goes round."""
    if plan.table.closed or memory.path.progress is None:
        return math.inf
    return abs(end(plan, memory.path.leg) - memory.path.progress.s)


def is_at(memory: Memory) -> bool:
    """Whether the vehicle rests at the point aimed at."""
    state, aim = memory.state, memory.path.aim
    if state is None or aim is None:
        return False
    return math.dist(state.p_n, aim.p_n) < JOIN_WITHIN and math.hypot(*state.v_n) < JOIN_SPEED


def rests(plan: Plan, memory: Memory, now: float) -> bool:
    """Whether the vehicle has come to rest in the end point of the path. ``now``: s by our clock."""
    state = memory.state
    if state is None:
        return False
    left, speed = math.dist(state.p_n, on_path(plan, end(plan, memory.path.leg)).p_n), math.hypot(*state.v_n)
    if now - memory.entered > REST_FOR:
        return left < JOIN_WITHIN and speed < JOIN_SPEED
    return left < REST_WITHIN and speed < REST_SPEED


def trim_aim(plan: Plan, memory: Memory) -> Memory:
    """The memory with the point that is held at the end of a path moved against the error that is left: an integral
    term, for a level or a vehicle whose disturbances are not estimated."""
    state, aim = memory.state, memory.path.aim
    if memory.phase is not Phase.REST or state is None or aim is None or memory.steering.steered_at is None:
        return memory
    if math.hypot(*state.v_n) > TRIM_SPEED:
        return memory
    step = TRIM_RATE * min(max(state.t_boot - memory.steering.steered_at, 0.0), 0.1)
    wanted = on_path(plan, end(plan, memory.path.leg)).p_n
    x, y, z = (
        min(max(held + step * (w - p), w - TRIM_MAX), w + TRIM_MAX)
        for held, w, p in zip(aim.p_n, wanted, state.p_n, strict=True)
    )
    return memory._replace(path=memory.path._replace(aim=aim._replace(p_n=(x, y, z))))


def goes_back(plan: Plan, memory: Memory) -> bool:
    """Whether the path is flown back from its end."""
    if plan.mission.repeat is not Repeat.BACK_AND_FORTH:
        return False
    return plan.laps is None or memory.path.legs + 1 < plan.laps


def choose_aim(plan: Plan, memory: Memory) -> tuple[Aim, SpeedScale]:
    """What the law is to do in the present phase, and the factor on the speed."""
    phase, progress = memory.phase, memory.path.progress
    assert progress is not None
    along = phase is Phase.FOLLOW or plan.conduct.at_once
    if phase is Phase.REHEARSE:
        along = progress.path_error < JOIN_WITHIN
    if memory.path.aim is None or along:
        ramp = _ramp(plan, memory)
        return Along(progress.s, ramp), ramp
    return memory.path.aim, STANDSTILL


def update_speed_scale(memory: Memory, wanted: float, dt: float) -> SpeedScale:
    """The ground station's factor on the speed, ``dt`` s later."""
    value, rate, _ = memory.steering.scale
    if wanted == value and rate == 0.0:
        return memory.steering.scale
    rate += dt * SCALE_RATE * (SCALE_RATE * (wanted - value) - 2.0 * rate)
    value += dt * rate
    return SpeedScale(wanted) if abs(wanted - value) < 1e-5 and abs(rate) < 1e-5 else SpeedScale(value, rate)


def _ramp(plan: Plan, memory: Memory) -> SpeedScale:
    """The factor on alpha: the start, what the user asks for, and the sign of the leg. How the speed falls towards an
    open end is a matter of displacement, and the law's."""
    scale = _start(plan, memory) * (UNITY if memory.steering.scale == UNITY else memory.steering.scale)
    return scale if memory.path.leg > 0.0 else scale * BACKWARDS


def _start(plan: Plan, memory: Memory) -> SpeedScale:
    """A smooth step in time, because a speed that rises with displacement alone never starts."""
    if plan.ramp_time == 0.0:
        return UNITY
    if memory.path.leg_from is None or memory.state is None:
        return STANDSTILL
    return smooth_start(memory.state.t_boot - memory.path.leg_from, plan.ramp_time)


def smooth_start(since: float, T: float) -> SpeedScale:
    """The factor on alpha ``since`` s after a start that takes ``T`` s: from 0 to 1 without a corner in its rate."""
    t = since / T
    if t >= 1.0:
        return UNITY
    return SpeedScale(
        t**3 * (10.0 - 15.0 * t + 6.0 * t * t),
        30.0 * t * t * (1.0 - t) ** 2 / T,
        60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / T**2,
    )


def turning(plan: Plan, state: VehicleState) -> Vec3:
    """What levels the vehicle, by what is sent: rates (rad/s), a rotation (rad), torques (N m or shares)."""
    setpoint = plan.steering.level_setpoint(state)
    if isinstance(setpoint, RateSetpoint):
        return setpoint.rates_b
    if isinstance(setpoint, AttitudeSetpoint):
        w, x, y, z = multiply(conjugate(state.q_nb), setpoint.q_nb)
        return (math.copysign(2.0, w) * x, math.copysign(2.0, w) * y, math.copysign(2.0, w) * z)
    if isinstance(setpoint, TorqueSetpoint):
        return setpoint.torque_b
    thrusts = [rotor.thrust_max * c for rotor, c in zip(plan.vehicle.rotors, setpoint.commands, strict=True)]
    arms = [rotor.position_b for rotor in plan.vehicle.rotors]
    roll = -sum(y * thrust for (_, y, _), thrust in zip(arms, thrusts, strict=True))
    return (roll, sum(x * thrust for (x, _, _), thrust in zip(arms, thrusts, strict=True)), 0.0)


def neutral(plan: Plan, state: VehicleState, grounded: bool) -> Setpoint:
    """What is streamed while the pilot flies: the present attitude kept, without turning, at the thrust of a hover;
    none on the ground."""
    level = plan.steering.level_setpoint(state)
    if isinstance(level, MotorSetpoint):
        return MotorSetpoint((0.0,) * len(level.commands)) if grounded else level
    thrust = 0.0 if grounded else level.thrust
    if isinstance(level, TorqueSetpoint):
        return TorqueSetpoint((0.0, 0.0, 0.0), 0.0) if grounded else level
    if isinstance(level, RateSetpoint):
        return RateSetpoint((0.0, 0.0, 0.0), thrust)
    return AttitudeSetpoint(state.q_nb, thrust)
