"""What a moment changes of the phase, and what is remembered of it."""

from __future__ import annotations

from typing import NamedTuple

from companion.flight import safety
from companion.flight.asking import begin_asking
from companion.flight.bench import lacking
from companion.flight.conduct import ControlAuthority
from companion.flight.epilogue import ADVICE_AFTERWARDS
from companion.flight.guards import decide
from companion.flight.phases import PHASES, Event, Phase
from companion.flight.waiting import waited_for
from companion.pilot.inputs import situation
from companion.pilot.memory import (
    OWN_MODE,
    FlightFault,
    Memory,
    Missing,
    Observation,
    PathMemory,
    Progress,
    SteeringRecord,
)
from companion.pilot.targets import JOIN_WITHIN, beginning, end, here, join, on_path
from companion.plan import Plan
from companion.steering.steering import At
from companion.vehicle import KnownStatus, VehicleState

MISSING_REPORTED_AFTER = 3.0
"""s after which what a flight waits for is told. Engineering choice."""
SEARCH_ANEW = 0.5
"""m of an estimator's jump from which on the nearest point is sought on the whole path. Engineering choice."""
SLOW_CLOCK = 0.97
"""Ratio: s of the vehicle's clock a second of ours below which that is said. Engineering choice: no crystal is off by
0.1 %."""
SLOW_CLOCK_ADVICE = "the simulation is slower than real time: give it more of the computer, then start again"

FAULTS = frozenset({
    Event.STOP, Event.STOP_ON_GROUND, Event.TAKEN_OVER, Event.FAILSAFE, Event.DISARMED_EXTERNALLY, Event.STALE,
    Event.LAW_FAILED, Event.ABORT_REQUIRED, Event.HAND_BACK_REQUIRED, Event.REFUSED, Event.TIMED_OUT, Event.STATUS_LOST,
    Event.SILENT, Event.NOT_OURS,
})  # fmt: skip
"""The events after which a flight is not completed."""


BY_ITSELF = (Phase.LAND, Phase.RETURN, Phase.DISARM, Phase.RELEASE)
"""The phases in which the vehicle does not fly on our setpoints any more, and that is known."""


class Moment(NamedTuple):
    """What does not change within a tick. ``notes`` collects lines for people."""

    plan: Plan
    observation: Observation
    status: KnownStatus
    verdict: safety.Verdict
    now: float
    notes: list[str]


def change_phase(moment: Moment, memory: Memory, law_error: str | None = None) -> Memory:
    """The memory after every change of phase that this moment brings."""
    plan, observation, status, verdict, now, notes = moment
    while True:
        decision = decide(situation(plan, memory, observation, status, verdict, now, law_error))
        if decision is None:
            return memory
        phase, event, reason = decision
        reason, advice = _with_clock(moment, event, reason)
        notes.append(f"{memory.phase.value} -> {phase.value}: {reason}")
        if phase is Phase.REHEARSE and plan.conduct.authority is ControlAuthority.BENCH:
            notes.append(f"tilt the vehicle by hand, 15 degrees to every side: {lacking(memory.shown)}")
        memory = _enter(moment, memory, phase, event, reason, advice)


def _with_clock(moment: Moment, event: Event, reason: str) -> tuple[str, str | None]:
    """The reason and what is advised; of states that lack or come late, the vehicle's clock where that is the cause."""
    advice = moment.verdict.advice if event in (Event.ABORT_REQUIRED, Event.HAND_BACK_REQUIRED) else None
    rate = moment.observation.clock_rate
    late = event in (Event.STALE, Event.STATUS_LOST) or advice in safety.LINK_ADVICE
    if not late or rate is None or rate >= SLOW_CLOCK:
        return reason, advice
    return f"{reason}; its clock runs at {rate:.2f} of real time", SLOW_CLOCK_ADVICE


def _enter(moment: Moment, memory: Memory, phase: Phase, event: Event, reason: str, advice: str | None) -> Memory:
    plan, status = moment.plan, moment.status
    came_from = memory.phase
    if memory.fault is None and event in FAULTS:
        if event in (Event.TIMED_OUT, Event.REFUSED):
            advice = ADVICE_AFTERWARDS.get(came_from)
        memory = memory._replace(fault=FlightFault(reason, event, advice))
    ends_own_mode = plan.conduct.own_mode is not None and phase in (Phase.HAND_BACK, Phase.ABORT)
    asks = plan.conduct.authority is ControlAuthority.COMPANION or ends_own_mode
    request = PHASES[phase].request if asks else None
    asking = begin_asking(request, memory.request.asking, status)
    memory = memory._replace(
        phase=phase,
        entered=moment.now,
        last_event=event,
        request=memory.request._replace(
            asking=asking,
            answer=memory.request.answer if asking is not None and asking is memory.request.asking else None,
            decided_in=memory.request.decided_in if request is None else status.mode,
            # OFFBOARD seen while taking over counts: following begins in it
            mode_seen=memory.request.mode_seen and OWN_MODE.get(phase) is OWN_MODE.get(came_from),
        ),
        from_ground=memory.from_ground or event is Event.READY_ON_GROUND,
        finished=memory.finished or event is Event.FINISHED,
        done=memory.done._replace(
            left=memory.done.left or phase in BY_ITSELF,
            armed=memory.done.armed or event is Event.ARMED,  # seen, where the answer to ARM was lost
        ),
    )
    state = memory.state
    if state is None:
        return memory
    if phase is Phase.FOLLOW:
        memory = memory._replace(payload=memory.payload._replace(start=None))
        return memory._replace(path=_begin_leg(plan, memory.path, event, state))
    if phase is Phase.STAND_BY:
        memory = memory._replace(steering=SteeringRecord(scale=memory.steering.scale))
        return memory._replace(path=memory.path._replace(aim=None, leg=1.0, legs=0))
    return memory._replace(path=memory.path._replace(aim=_aim(plan, memory, phase, state)))


def _begin_leg(plan: Plan, path: PathMemory, event: Event, state: VehicleState) -> PathMemory:
    """Following begins, or goes back from the end of an open path."""
    path = path._replace(leg_from=state.t_boot, reached=plan.conduct.at_once, aim=None)
    if event is Event.TURNED:
        return path._replace(leg=-path.leg, legs=path.legs + 1)
    if event is Event.JOINED and not plan.table.closed and not plan.conduct.at_once:
        # at its beginning, even where another part of the path is near: its end, or a crossing
        s, distance = plan.table.nearest(state.p_n, beginning(plan, path.leg), SEARCH_ANEW + JOIN_WITHIN)
        path = path._replace(progress=Progress(s, 0.0, distance))
    return path._replace(follow_from=state.t_boot if path.follow_from is None else path.follow_from)


def _aim(plan: Plan, memory: Memory, phase: Phase, state: VehicleState) -> At | None:
    """The point that is held or gone to from now on; None to go on along the path."""
    if phase in (Phase.JOIN, Phase.REHEARSE):
        return join(plan, state, memory.path.leg)
    if phase is Phase.REST:
        return on_path(plan, end(plan, memory.path.leg))
    if phase is Phase.HAND_BACK and plan.conduct.authority is not ControlAuthority.PILOT:
        return memory.path.aim
    if phase in (Phase.TAKE_OVER, Phase.HAND_BACK) or memory.path.aim is None:
        return here(plan, state)
    return memory.path.aim


def report_waiting(moment: Moment, memory: Memory) -> Memory:
    """What a flight waits for is said when it has lacked for a while, and again when that changes."""
    plan, observation, status, verdict, now, notes = moment
    lacks = waited_for(situation(plan, memory, observation, status, verdict, now, None))
    words = "" if lacks is None else "".join(letter for letter in lacks if not letter.isdigit())
    known = memory.missing
    if known is None or known.words != words:
        return memory._replace(missing=Missing(words, now))
    if known.reported or lacks is None or now - known.since < MISSING_REPORTED_AFTER:
        return memory
    notes.append(f"waiting: {lacks}")
    return memory._replace(missing=known._replace(reported=True))
