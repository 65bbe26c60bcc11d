"""One tick, in two halves: the setpoint goes out between them while the path is followed and nothing is the matter.

    observation
        |
    compute_setpoint   take in the state, the answer, the mode (intake)
        |              calm? -> aim (targets) -> steering.steer -> setpoint, "early"
        |                 else -> no setpoint yet
        |  ........ an early setpoint is sent here: the latency ends ........
        |
    supervise          progress along the path, agreement of the states
        |              safety rows -> verdict; events -> changes of phase (transitions)
        |              the setpoint, where none was early: steer, level, or the present attitude
        |              the request (arming, a mode), the payload's commands
        |
    memory, outcome

Whoever has no hurry (replay, tests) calls ``step``, which is both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight import conditions, safety
from companion.flight.asking import update_asking
from companion.flight.bench import judge_tilt
from companion.flight.conduct import ControlAuthority
from companion.flight.guards import STREAM_FIRST
from companion.flight.interruptions import SILENT_AFTER, STATE_AGE_MAX
from companion.flight.phases import PHASES, Event, Phase, Request
from companion.frames import clamped, euler_from_rotation
from companion.law.errors import LawError
from companion.law.speed_scale import UNITY, SpeedScale
from companion.mission import PathAction
from companion.pilot.inputs import is_thrust_judged, safety_inputs
from companion.pilot.intake import compare_states, take_in
from companion.pilot.memory import (
    LawOutput,
    Memory,
    Observation,
    Outcome,
    PathMemory,
    Progress,
    StateAgreement,
    SteeringRecord,
)
from companion.pilot.payload import due
from companion.pilot.targets import (
    choose_aim,
    neutral,
    trim_aim,
    turning,
    update_speed_scale,
)
from companion.pilot.thrust_change import thrust_change_line
from companion.pilot.thrust_response import update_thrust_response
from companion.pilot.transitions import SEARCH_ANEW, Moment, change_phase, report_waiting
from companion.plan import Plan
from companion.steering.steering import Steered
from companion.vehicle import Landed, Mode, Setpoint, VehicleState, VehicleStatus

DT_MAX = 0.1
"""s; a longer gap between two stamps is integrated as this much. Engineering choice."""
LEVEL_FOR = 0.3
"""s of level setpoints after an abort; then silence, so that the autopilot's own failsafe can act. Issue 11."""
WAITS = frozenset({Phase.PREFLIGHT, Phase.STAND_BY, *SILENT_AFTER})
"""The phases that may have to wait for the vehicle."""
REACHED_WITHIN = 1.0
"""m from the path at which it counts as reached: from then on the tube around it is watched. Engineering choice."""


def step(plan: Plan, memory: Memory, observation: Observation, now: float) -> tuple[Memory, Outcome]:
    """One tick, whole. ``now``: s, our monotonic clock."""
    memory, early = compute_setpoint(plan, memory, observation, now)
    return supervise(plan, memory, observation, now, early)


def compute_setpoint(
    plan: Plan, memory: Memory, observation: Observation, now: float
) -> tuple[Memory, LawOutput | None]:
    """What arrived is taken in; and the setpoint for it, where it may go out before the rest of the tick.

    The nearest point of the path is then that of the last state: all that hangs on it here is the factor on the speed
    and where the law begins to look for the nearest point of its own.
    """
    memory = take_in(memory, observation, now, clock_may_stand=plan.conduct.at_once and not memory.clock_runs)
    if not _calm(memory, observation):
        return memory, None
    try:
        return memory, _steer(plan, memory, observation)
    except LawError:
        return memory, None  # the rest asks again, and acts on it


def _calm(memory: Memory, observation: Observation) -> bool:
    """Whether the path is followed on a fresh state and nothing that was seen may stop the setpoint.

    Only a change of phase that is due anyway (the end of the path, of the laps, of the time) then comes one setpoint
    later: every safety row that acts at once is asked here, and one that has to last is breached a tick before.
    """
    return (
        memory.phase is Phase.FOLLOW
        and observation.state is not None
        and observation.state is memory.state
        and _flies_offboard(observation.status)
        and not observation.stop
        and memory.request.answer is None
        and memory.breaches is safety.NOTHING_SINCE
        and memory.watch.jump == 0.0
        and abs(memory.watch.clock_jump) <= conditions.CLOCK_JUMP
        and not observation.companions
    )


def _flies_offboard(status: VehicleStatus) -> bool:
    """Whether the last that was said is that it flies in OFFBOARD; how old that may be, the rest of the tick knows."""
    mode, armed = status.mode, status.armed
    return mode is not None and mode.value is Mode.OFFBOARD and (armed is None or armed.value)


def supervise(
    plan: Plan, memory: Memory, observation: Observation, now: float, early: LawOutput | None
) -> tuple[Memory, Outcome]:
    """The rest of the tick, after ``compute_setpoint`` gave ``memory`` and ``early``:

        progress and agreement of the state -> safety rows -> changes of phase -> setpoint -> request

    Where ``early`` has the setpoint already, the one for this state is not computed again.
    """
    fresh = observation.state is not None and observation.state is memory.state
    if fresh and observation.state is not None:
        state = observation.state
        memory = memory._replace(
            path=_update_progress(plan, memory, state),
            agreement=_compare_state(plan, memory, state, observation.round_trip or 0.0),
        )
        memory = trim_aim(plan, memory)
    status = observation.status.known_at(now)
    breaches, verdict = safety.update_breaches(
        memory.breaches, safety_inputs(plan, memory, observation, status, now), plan.conduct.limits, now
    )
    if breaches is not memory.breaches:
        memory = memory._replace(breaches=breaches)
    moment = Moment(plan, observation, status, verdict, now, [])
    before = memory.steering.steered
    if early is not None:
        memory = change_phase(moment, _keep_steering(plan, memory, early))
        command = Commanded(early.steered.setpoint, early.steered, early.ramp)
    else:
        memory = change_phase(moment, memory)
        memory, command = _command(moment, memory, fresh)
    if memory.phase in WAITS:
        memory = report_waiting(moment, memory)
    memory, request, sent = _request(moment, memory)
    actions: tuple[PathAction, ...] = ()
    if fresh:
        memory, actions = due(plan, memory)
    changed = thrust_change_line(before, command.steered)
    if changed is not None:
        moment.notes.append(changed)
    if command.setpoint is not None and not memory.done.flew and status.mode is Mode.OFFBOARD:
        memory = memory._replace(done=memory.done._replace(flew=True))
    notes, ramp = tuple(moment.notes), command.ramp
    return memory, Outcome(command.setpoint, request, notes, command.steered, ramp, sent, actions)


def _compare_state(plan: Plan, memory: Memory, state: VehicleState, delay: float) -> StateAgreement:
    """What the state says against the one before, and against what was commanded."""
    agreement, steered, vehicle = memory.agreement, memory.steering.steered, plan.vehicle
    old, response = agreement.checked, agreement.thrust_response
    if old is not None and steered is not None:
        judged = is_thrust_judged(plan, memory)
        response = update_thrust_response(response, old, state, steered, vehicle.mass, vehicle.gravity, delay, judged)
    return compare_states(agreement, state, response)


class Commanded(NamedTuple):
    """The setpoint of a tick, if there is one, and how the law came to it."""

    setpoint: Setpoint | None = None
    steered: Steered | None = None
    ramp: SpeedScale = UNITY


NOTHING = Commanded()


def _command(moment: Moment, memory: Memory, fresh: bool) -> tuple[Memory, Commanded]:
    """The setpoint for the present phase. ``fresh``: this tick has a new state."""
    plan, observation, status, _, now, notes = moment
    command = NOTHING
    if memory.phase is Phase.REHEARSE and plan.conduct.authority is ControlAuthority.BENCH:
        memory = _judge_bench(plan, memory, notes) if fresh else memory
    elif fresh and PHASES[memory.phase].steers and memory.phase is not Phase.ABORT:
        try:
            law = _steer(plan, memory, observation)
            memory = _keep_steering(plan, memory, law)
            setpoint = None if memory.phase is Phase.REHEARSE else law.steered.setpoint
            command = Commanded(setpoint, law.steered, law.ramp)
        except LawError as error:
            memory = change_phase(moment, memory, str(error))
    elif fresh and memory.phase is Phase.STAND_BY and memory.state is not None and status.mode is not None:
        command = Commanded(neutral(plan, memory.state, status.landed is not Landed.IN_AIR))
    at = memory.state_at
    age = math.inf if at is None else now - at
    # not for longer after the last state either, where the abort came late: a pilot who selects OFFBOARD then
    if memory.phase is Phase.ABORT and now - memory.entered <= LEVEL_FOR and age <= STATE_AGE_MAX + LEVEL_FOR:
        stands = memory.watch.same_attitude or memory.agreement.attitude_stands
        usable = age <= STATE_AGE_MAX and not stands
        command = Commanded(plan.steering.level_setpoint(memory.state if usable else None, memory.steering.memory))
    return memory, command


def _update_progress(plan: Plan, memory: Memory, state: VehicleState) -> PathMemory:
    """Where a new state is along the path."""
    path, moved = memory.path, 0.0
    known = path.progress
    if known is None or memory.watch.jump > SEARCH_ANEW:
        s, distance = plan.table.locate(state.p_n)
    else:
        # a step no longer than the vehicle can have come: a path that crosses itself keeps its branch
        s, distance = plan.table.nearest(state.p_n, known.s, 1.0 + 0.2 * math.hypot(*state.v_n))
        if memory.phase is Phase.FOLLOW:
            moved = plan.direction * path.leg * plan.table.difference(s, known.s)
    progress = Progress(s, moved if known is None else known.travelled + moved, distance)
    reached = path.reached or (memory.phase is Phase.FOLLOW and distance < REACHED_WITHIN)
    return PathMemory(progress, path.follow_from, path.leg_from, path.leg, path.legs, path.aim, reached)


def _keep_steering(plan: Plan, memory: Memory, output: LawOutput) -> Memory:
    """The memory once the law was asked, and has learned from what it saw."""
    state, steered = memory.state, output.steered
    assert state is not None
    learned = plan.steering.learn(steered.memory)
    return memory._replace(steering=SteeringRecord(learned, steered, state.t_boot, output.scale))


def _steer(plan: Plan, memory: Memory, observation: Observation) -> LawOutput:
    """The law's setpoint for the newest state. The extension stands still until the vehicle flies on it."""
    state = memory.state
    assert state is not None
    last = memory.steering
    steering = plan.steering.begin(state) if last.memory is None else last.memory
    dt = 0.0
    if memory.phase not in (Phase.TAKE_OVER, Phase.REHEARSE) and last.steered_at is not None:
        dt = clamped(state.t_boot - last.steered_at, 0.0, DT_MAX)
    wanted = clamped(observation.speed_scale, 0.0, plan.conduct.speed_scale_max)
    scale = update_speed_scale(memory, wanted, dt)
    if scale != last.scale:
        memory = memory._replace(steering=last._replace(scale=scale))
    aim, ramp = choose_aim(plan, memory)
    steered = plan.steering.steer(steering, state, dt, aim, observation.round_trip)
    end_scale = steered.command.end_scale
    return LawOutput(steered, ramp if end_scale == 1.0 else ramp._replace(value=ramp.value * end_scale), scale)


def _judge_bench(plan: Plan, memory: Memory, notes: list[str]) -> Memory:
    """On the bench: what was shown."""
    state = memory.state
    assert state is not None
    _, pitch, roll = euler_from_rotation(state.r_nb)
    shown, line = judge_tilt(memory.shown, roll, pitch, turning(plan, state))
    if line is not None:
        notes.append(line)
    return memory._replace(shown=shown)


def _request(moment: Moment, memory: Memory) -> tuple[Memory, Request | None, bool]:
    """What the phase asks for, and whether that is sent now."""
    asking, status, now = memory.request.asking, moment.status, moment.now
    if asking is None:
        return memory, None, False
    if memory.phase is Phase.TAKE_OVER and now - memory.entered < STREAM_FIRST:
        return memory, None, False
    if memory.phase is Phase.RELEASE and status.armed is not False:
        return memory, None, False  # a failsafe that flies is left alone; on the ground OFFBOARD is ended for good
    lost = memory.last_event is Event.STALE
    later, sent = update_asking(asking, memory.request.answer, status, memory.phase, now, lost=lost)
    if sent and asking.request is Request.ARM and not memory.done.arm_asked:
        memory = memory._replace(done=memory.done._replace(arm_asked=True))
    if sent and asking.request is Request.OFFBOARD and not memory.done.begun:
        memory = memory._replace(done=memory.done._replace(begun=True))
    if sent and asking.request is Request.HOLD:
        memory = memory._replace(done=memory.done._replace(hold_asked=memory.done.hold_asked + 1))
    if later is not asking:
        memory = memory._replace(request=memory.request._replace(asking=later))
    return memory, asking.request, sent
