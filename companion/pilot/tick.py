"""One tick: what arrived is taken in, what it changes is decided, and the law is asked.

A tick is ``compute_setpoint`` and then ``supervise``. While the path is followed and nothing is the matter, the first
has the setpoint already, so that it can be on its way before the safety rows and the changes of phase are looked at.
"""

from __future__ import annotations

import math

from companion.flight import safety
from companion.flight.bench import lacking, looked
from companion.flight.conduct import ControlAuthority
from companion.flight.guards import STALE_AFTER, STREAM_FIRST, decide
from companion.flight.phases import PHASES, Event, Phase, Request
from companion.frames import euler_from_rotation
from companion.law.errors import LawError
from companion.law.speed_scale import UNITY
from companion.pilot.inputs import safety_inputs, situation
from companion.pilot.memory import OWN_MODE, First, Memory, Observation, Outcome, Progress
from companion.pilot.targets import (
    JOIN_WITHIN,
    beginning,
    chosen,
    end,
    here,
    join,
    neutral,
    on_path,
    scaled,
    trimmed,
    turning,
)
from companion.plan import Plan
from companion.steering.steering import At
from companion.vehicle import Landed, Mode, VehicleState

DT_MAX = 0.1
"""s; a longer gap between two stamps is integrated as this much."""
LEVEL_FOR = 0.3
"""s of level setpoints after an abort; then silence, so that the autopilot's own failsafe can act."""
CLOCK_BACK = 1.0
"""s by which a state must be older than the last one to be the sign of a clock set back, and not merely late."""
REACHED_WITHIN = 1.0
"""m from the path at which it counts as reached: from then on the tube around it is watched."""
MOVES, TURNS = 0.1, 0.02
"""m/s and rad/s from which on a position and an attitude must change from state to state."""
SEARCH_ANEW = 0.5
"""m of an estimator's jump from which on the nearest point is sought on the whole path."""

FAULTS = frozenset({
    Event.STOP, Event.TAKEN_OVER, Event.FAILSAFE, Event.DISARMED_EXTERNALLY, Event.STALE, Event.LAW_FAILED,
    Event.ABORT_REQUIRED, Event.HAND_BACK_REQUIRED, Event.REFUSED, Event.TIMED_OUT,
})  # fmt: skip
"""The events after which a flight is not completed."""


def step(plan: Plan, memory: Memory, seen: Observation, now: float) -> tuple[Memory, Outcome]:
    """One tick, whole. ``now``: s, our monotonic clock."""
    memory, early = compute_setpoint(plan, memory, seen, now)
    return supervise(plan, memory, seen, now, early)


def compute_setpoint(plan: Plan, memory: Memory, seen: Observation, now: float) -> tuple[Memory, First | None]:
    """What arrived is taken in; and the setpoint for it, where it may go out before the rest of the tick.

    The nearest point of the path is then that of the last state: all that hangs on it here is the factor on the speed
    and where the law begins to look for the nearest point of its own.
    """
    memory = _noticed(memory, seen, now)
    if not _calm(memory, seen):
        return memory, None
    try:
        return memory, _steered(plan, memory, seen)
    except LawError:
        return memory, None  # the rest asks again, and acts on it


def _calm(memory: Memory, seen: Observation) -> bool:
    """Whether the path is followed on a fresh state and nothing that was seen may stop the setpoint.

    Only a change of phase that is due anyway (the end of the path, of the laps, of the time) then comes one setpoint
    later: every safety row that acts at once is asked here, and one that has to last is breached a tick before.
    """
    return (
        memory.phase is Phase.FOLLOW
        and seen.state is not None
        and seen.state is memory.state
        and seen.status.mode is Mode.OFFBOARD
        and seen.status.armed is not False
        and not seen.stop
        and memory.answer is None
        and memory.since is safety.NOTHING_SINCE
        and memory.jump == 0.0
        and abs(memory.clock_jump) <= safety.CLOCK_JUMP
        and not seen.companions
    )


def supervise(plan: Plan, memory: Memory, seen: Observation, now: float, early: First | None) -> tuple[Memory, Outcome]:
    """The rest of the tick, after ``compute_setpoint`` gave ``memory`` and ``early``."""
    if seen.state is not None and seen.state is memory.state:
        memory = trimmed(plan, _progressed(plan, memory, seen.state))
    since, verdict = safety.watched(memory.since, safety_inputs(plan, memory, seen, now), plan.conduct.limits, now)
    if since is not memory.since:
        memory = memory._replace(since=since)
    if early is not None:
        memory = _after(plan, memory, early)
    notes: list[str] = []
    memory = _decided(plan, memory, seen, verdict, now, notes)
    if early is not None:
        if not memory.flew:
            memory = memory._replace(flew=True)
        request = _request(plan, memory, seen, now)
        return memory, Outcome(early.steered.setpoint, request, tuple(notes), early.steered, early.ramp)
    steered, ramp, setpoint = None, UNITY, None
    fresh = seen.state is not None and seen.state is memory.state
    if memory.phase is Phase.REHEARSE and plan.conduct.authority is ControlAuthority.BENCH:
        memory = _shown(plan, memory, notes) if fresh else memory
    elif fresh and PHASES[memory.phase].steers and memory.phase is not Phase.ABORT:
        try:
            asked = _steered(plan, memory, seen)
            memory, steered, ramp = _after(plan, memory, asked), asked.steered, asked.ramp
            setpoint = None if memory.phase is Phase.REHEARSE else steered.setpoint
        except LawError as error:
            memory = _decided(plan, memory, seen, verdict, now, notes, str(error))
    elif fresh and memory.phase is Phase.STAND_BY and memory.state is not None:
        setpoint = neutral(plan, memory.state, seen.status.landed is not Landed.IN_AIR)
    if memory.phase is Phase.ABORT and now - memory.entered <= LEVEL_FOR:
        recent = memory.state_at is not None and now - memory.state_at <= STALE_AFTER
        usable = recent and not memory.same_attitude
        setpoint = plan.steering.level(memory.state if usable else None, memory.steering)
    if setpoint is not None and not memory.flew and memory.phase is not Phase.STAND_BY:
        memory = memory._replace(flew=True)
    return memory, Outcome(setpoint, _request(plan, memory, seen, now), tuple(notes), steered, ramp)


def _noticed(memory: Memory, seen: Observation, now: float) -> Memory:
    """The memory with what arrived taken in. A state older than the last one is not a state."""
    answer = memory.answer
    if seen.answer is not None and seen.answer.request is PHASES[memory.phase].request:
        answer = seen.answer
    mode_seen = memory.mode_seen or seen.status.mode is OWN_MODE.get(memory.phase, Mode.UNKNOWN)
    new, old = seen.state, memory.state
    if new is None or old is None or memory.state_at is None or -CLOCK_BACK < new.t_boot - old.t_boot < 0.0:
        memory = memory._replace(answer=answer, mode_seen=mode_seen, jump=0.0, clock_jump=0.0)
        if new is None or old is not None:
            return memory
        return memory._replace(state=new, state_at=now)
    passed = new.t_boot - old.t_boot
    jump = 0.0
    if new.resets != old.resets:
        jump = math.dist(new.p_n, [p + v * passed for p, v in zip(old.p_n, old.v_n, strict=True)])
    ahead = passed - (now - memory.state_at)
    # a link that fell silent and delivers late is no clock that jumped
    clock_jump = ahead if passed < 0.0 or ahead > 0.0 else 0.0
    same_place, same_attitude = memory.same_place, memory.same_attitude
    if passed > 0.0:  # not the same state once more
        same_place = new.p_n == old.p_n and (same_place or math.hypot(*new.v_n) > MOVES)
        same_attitude = new.q_nb == old.q_nb and (same_attitude or math.hypot(*new.w_b) > TURNS)
    gaps = memory.gaps
    if now - memory.state_at > safety.GAP:
        gaps = (*(ended for ended in gaps if now - ended < safety.GAPS_WITHIN), now)
    return memory._replace(
        answer=answer, mode_seen=mode_seen, state=new, state_at=now, jump=jump, clock_jump=clock_jump,
        same_place=same_place, same_attitude=same_attitude, gaps=gaps,
    )  # fmt: skip


def _progressed(plan: Plan, memory: Memory, state: VehicleState) -> Memory:
    """The memory with where a new state is along the path."""
    known, moved = memory.progress, 0.0
    if known is None or memory.jump > SEARCH_ANEW:
        s, distance = plan.table.locate(state.p_n)
    else:
        # a step no longer than the vehicle can have come: a path that crosses itself keeps its branch
        s, distance = plan.table.nearest(state.p_n, known.s, 1.0 + 0.2 * math.hypot(*state.v_n))
        if memory.phase is Phase.FOLLOW:
            moved = plan.direction * memory.leg * plan.table.difference(s, known.s)
    progress = Progress(s, moved if known is None else known.travelled + moved, distance)
    reached = memory.reached or (memory.phase is Phase.FOLLOW and distance < REACHED_WITHIN)
    return memory._replace(progress=progress, reached=reached)


def _decided(
    plan: Plan, memory: Memory, seen: Observation, verdict: safety.Verdict, now: float, notes: list[str],
    law_error: str | None = None,
) -> Memory:  # fmt: skip
    """The memory after every change of phase that this moment brings."""
    while True:
        decision = decide(situation(plan, memory, seen, verdict, now, law_error))
        if decision is None:
            return memory
        phase, event, reason = decision
        notes.append(f"{memory.phase.value} -> {phase.value}: {reason}")
        if phase is Phase.REHEARSE and plan.conduct.authority is ControlAuthority.BENCH:
            notes.append(f"tilt the vehicle by hand, 15 degrees to every side: {lacking(memory.shown)}")
        memory = _entered(plan, memory, phase, event, reason, verdict, now)


def _entered(
    plan: Plan, memory: Memory, phase: Phase, event: Event, reason: str, verdict: safety.Verdict, now: float
) -> Memory:
    came_from = memory.phase
    if memory.first_fault is None and event in FAULTS:
        advice = verdict.advice if event in (Event.ABORT_REQUIRED, Event.HAND_BACK_REQUIRED) else None
        memory = memory._replace(first_fault=reason, fault_event=event, advice=advice)
    memory = memory._replace(
        phase=phase,
        entered=now,
        answer=None,
        last_event=event,
        # OFFBOARD seen while taking over counts: following begins in it
        mode_seen=memory.mode_seen and OWN_MODE.get(phase) is OWN_MODE.get(came_from),
        from_ground=memory.from_ground or event is Event.READY_ON_GROUND,
        finished=memory.finished or event is Event.FINISHED,
    )
    state = memory.state
    if state is None:
        return memory
    if phase is Phase.FOLLOW:
        memory = memory._replace(leg_from=state.t_boot, reached=plan.conduct.at_once, aim=None)
        if event is Event.TURNED:
            return memory._replace(leg=-memory.leg, legs=memory.legs + 1)
        if event is Event.JOINED and not plan.table.closed and not plan.conduct.at_once:
            # at its beginning, even where another part of the path is near: its end, or a crossing
            s, distance = plan.table.nearest(state.p_n, beginning(plan, memory.leg), SEARCH_ANEW + JOIN_WITHIN)
            memory = memory._replace(progress=Progress(s, 0.0, distance))
        return memory._replace(follow_from=state.t_boot if memory.follow_from is None else memory.follow_from)
    if phase is Phase.STAND_BY:
        return memory._replace(steering=None, steered=None, steered_at=None, aim=None, leg=1.0, legs=0)
    return memory._replace(aim=_aim(plan, memory, phase, state))


def _aim(plan: Plan, memory: Memory, phase: Phase, state: VehicleState) -> At | None:
    """The point that is held or gone to from now on; None to go on along the path."""
    if phase in (Phase.JOIN, Phase.REHEARSE):
        return join(plan, state, memory.leg)
    if phase is Phase.REST:
        return on_path(plan, end(plan, memory.leg))
    if phase is Phase.HAND_BACK and plan.conduct.authority is not ControlAuthority.PILOT:
        return memory.aim
    if phase in (Phase.TAKE_OVER, Phase.HAND_BACK) or memory.aim is None:
        return here(plan, state)
    return memory.aim


def _after(plan: Plan, memory: Memory, asked: First) -> Memory:
    """The memory once the law was asked, and has learned from what it saw."""
    state, steered = memory.state, asked.steered
    assert state is not None
    return memory._replace(
        steering=plan.steering.learn(steered.memory), steered=steered, steered_at=state.t_boot, scale=asked.scale
    )


def _steered(plan: Plan, memory: Memory, seen: Observation) -> First:
    """The law's setpoint for the newest state. The extension stands still until the vehicle flies on it."""
    state = memory.state
    assert state is not None
    steering = plan.steering.begin(state) if memory.steering is None else memory.steering
    dt = 0.0
    if memory.phase not in (Phase.TAKE_OVER, Phase.REHEARSE) and memory.steered_at is not None:
        dt = min(max(state.t_boot - memory.steered_at, 0.0), DT_MAX)
    wanted = min(max(seen.speed_scale, 0.0), plan.conduct.speed_scale_max)
    scale = scaled(memory, wanted, dt)
    if scale != memory.scale:
        memory = memory._replace(scale=scale)
    aim, ramp = chosen(plan, memory)
    steered = plan.steering.steer(steering, state, dt, aim, seen.link_delay)
    return First(steered, ramp._replace(value=ramp.value * steered.command.end_scale), scale)


def _shown(plan: Plan, memory: Memory, notes: list[str]) -> Memory:
    """On the bench: what was shown."""
    state = memory.state
    assert state is not None
    _, pitch, roll = euler_from_rotation(state.r_nb)
    shown, told = looked(memory.shown, roll, pitch, turning(plan, state))
    if told is not None:
        notes.append(told)
    return memory._replace(shown=shown)


def _request(plan: Plan, memory: Memory, seen: Observation, now: float) -> Request | None:
    phase = memory.phase
    if plan.conduct.authority is not ControlAuthority.COMPANION:
        return None  # the pilot arms and changes the mode, nobody else
    if phase is Phase.TAKE_OVER and now - memory.entered < STREAM_FIRST:
        return None
    if phase is Phase.RELEASE and seen.status.armed is not False:
        return None  # a failsafe that flies is left alone; on the ground OFFBOARD is ended for good
    return PHASES[phase].request
