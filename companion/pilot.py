"""One tick of a flight, pure: what is remembered and what is seen -> what is remembered next and what is done.

The pilot knows no MAVLink, no clock and no files. Feeding the same observations again gives the same setpoints, bit for
bit; that is what ``companion replay`` does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight.guards import STALE_AFTER, STREAM_FIRST, Answer, Situation, decide
from companion.flight.phases import PHASES, Event, Phase, Request
from companion.frames import tilt, wrap
from companion.law.bare import LawError
from companion.law.flight import Ramp
from companion.plan import Plan
from companion.steering.steering import Along, Steered, SteeringMemory
from companion.vehicle import Mode, Setpoint, VehicleState, VehicleStatus

DT_MAX = 0.1
"""s; a longer gap between two stamps is integrated as this much."""
LEVEL_FOR = 0.3
"""s of level setpoints after an abort; then silence, so that the autopilot's own failsafe can act."""
WAKE_AFTER = 0.05
"""s without anything arriving after which the pilot looks around anyway."""


class Observation(NamedTuple):
    """What is seen at a tick. ``state``: a new one, or None. ``answer``: to a request, or None. ``link_delay``: s, the
    measured round trip of a message; None until measured."""

    state: VehicleState | None
    status: VehicleStatus
    answer: Answer | None = None
    stop: bool = False
    link_delay: float | None = None


class Progress(NamedTuple):
    """Where the vehicle is along the path. ``s``: m, of the nearest point. ``travelled``: m, since following began, in
    the mission's direction. ``path_error``: m, the distance to the path."""

    s: float
    travelled: float
    path_error: float


class Memory(NamedTuple):
    """What the pilot remembers from tick to tick.

    ``entered``: when the phase began, s by our clock. ``steered_at``: stamp of the last steered state. ``follow_from``:
    stamp at which following began. ``first_fault``: why the flight is not going to be completed.
    """

    phase: Phase = Phase.PREFLIGHT
    entered: float = 0.0
    state: VehicleState | None = None
    state_at: float | None = None
    mode_seen: bool = False
    answer: Answer | None = None
    from_ground: bool = False
    steering: SteeringMemory | None = None
    steered_at: float | None = None
    progress: Progress | None = None
    follow_from: float | None = None
    finished: bool = False
    first_fault: str | None = None


class Outcome(NamedTuple):
    """What is done at a tick: at most one fresh ``setpoint``, the ``request`` that stands, ``notes`` for people.
    ``steered`` and ``ramp``: how the setpoint came about, for the record; None where the law had no say."""

    setpoint: Setpoint | None
    request: Request | None
    notes: tuple[str, ...]
    steered: Steered | None
    ramp: Ramp


STEADY = Ramp()
OWN_MODE = {Phase.TAKE_OFF: Mode.TAKEOFF, Phase.TAKE_OVER: Mode.OFFBOARD, Phase.FOLLOW: Mode.OFFBOARD,
            Phase.LAND: Mode.LAND}  # fmt: skip


def begin(now: float) -> Memory:
    """The memory at the start of a flight."""
    return Memory(entered=now)


def step(plan: Plan, memory: Memory, seen: Observation, now: float) -> tuple[Memory, Outcome]:
    """One tick. ``now``: s, our monotonic clock."""
    memory = _noticed(plan, memory, seen, now)
    notes: list[str] = []
    memory = _decided(plan, memory, seen, now, notes)
    steered, ramp, setpoint = None, STEADY, None
    if PHASES[memory.phase].steers and memory.phase is not Phase.ABORT and seen.state is memory.state:
        ramp = _ramp(plan, memory)
        try:
            memory, steered = _steered(plan, memory, ramp)
            setpoint = steered.setpoint
        except LawError as error:
            memory = _decided(plan, memory, seen, now, notes, law_error=str(error))
    if memory.phase is Phase.ABORT and now - memory.entered <= LEVEL_FOR:
        fresh = memory.state_at is not None and now - memory.state_at <= STALE_AFTER
        setpoint = plan.steering.level(memory.state if fresh else None, memory.steering)
    return memory, Outcome(setpoint, _request(memory, now), tuple(notes), steered, ramp)


def wake_at(memory: Memory, now: float) -> float:
    """When to tick again if nothing arrives."""
    if memory.phase is Phase.DONE:
        return math.inf
    return now + (0.4 * WAKE_AFTER if memory.phase is Phase.ABORT else WAKE_AFTER)


def completed(memory: Memory) -> bool:
    """Whether the flight did what it was to do."""
    return memory.finished and memory.first_fault is None


def _noticed(plan: Plan, memory: Memory, seen: Observation, now: float) -> Memory:
    """The memory with what arrived taken in. A state older than the last one is not a state."""
    state, state_at, progress = memory.state, memory.state_at, memory.progress
    if seen.state is not None and (state is None or seen.state.t_boot >= state.t_boot):
        state, state_at = seen.state, now
        progress = _progressed(plan, memory, seen.state)
    answer = memory.answer
    if seen.answer is not None and seen.answer.request is PHASES[memory.phase].request:
        answer = seen.answer
    mode_seen = memory.mode_seen or seen.status.mode is OWN_MODE.get(memory.phase, Mode.UNKNOWN)
    return memory._replace(state=state, state_at=state_at, progress=progress, answer=answer, mode_seen=mode_seen)


def _progressed(plan: Plan, memory: Memory, state: VehicleState) -> Progress:
    known = memory.progress
    if known is None:
        s, distance = plan.table.locate(state.p_n)
        return Progress(s, 0.0, distance)
    # a step no longer than the vehicle can have come: a path that crosses itself keeps its branch
    reach = 1.0 + 0.2 * math.hypot(*state.v_n)
    s, distance = plan.table.nearest(state.p_n, known.s, reach)
    moved = plan.direction * plan.table.difference(s, known.s) if memory.phase is Phase.FOLLOW else 0.0
    return Progress(s, known.travelled + moved, distance)


def _decided(
    plan: Plan, memory: Memory, seen: Observation, now: float, notes: list[str], law_error: str | None = None
) -> Memory:
    """The memory after every change of phase that this moment brings."""
    while True:
        situation = Situation(
            phase=memory.phase,
            now=now,
            entered=memory.entered,
            status=seen.status,
            mode_seen=memory.mode_seen,
            state_at=memory.state_at,
            answer=memory.answer,
            from_ground=memory.from_ground,
            stop=seen.stop,
            finished=_finished(plan, memory),
            law_error=law_error,
        )
        decision = decide(situation)
        if decision is None:
            return memory
        phase, event, reason = decision
        notes.append(f"{memory.phase.value} -> {phase.value}: {reason}")
        memory = _entered(memory, phase, event, reason, now)


def _entered(memory: Memory, phase: Phase, event: Event, reason: str, now: float) -> Memory:
    fault = memory.first_fault
    if fault is None and event in FAULTS:
        fault = reason
    begins = phase is Phase.FOLLOW and memory.state is not None
    return memory._replace(
        phase=phase,
        entered=now,
        answer=None,
        # OFFBOARD seen while taking over counts: following begins in it
        mode_seen=memory.mode_seen and OWN_MODE.get(phase) is OWN_MODE.get(memory.phase),
        from_ground=memory.from_ground or event is Event.READY_ON_GROUND,
        follow_from=memory.state.t_boot if begins and memory.state is not None else memory.follow_from,
        finished=memory.finished or event is Event.FINISHED,
        first_fault=fault,
    )


FAULTS = frozenset(
    {Event.STOP, Event.TAKEN_OVER, Event.LOST_POWER, Event.STALE, Event.LAW_FAILED, Event.REFUSED, Event.TIMED_OUT}
)


def _finished(plan: Plan, memory: Memory) -> str | None:
    if memory.phase is not Phase.FOLLOW or memory.state is None or memory.follow_from is None:
        return None
    if plan.duration is not None and memory.state.t_boot - memory.follow_from >= plan.duration:
        return f"followed for {plan.duration:g} s"
    if plan.laps is not None and memory.progress is not None:
        laps = memory.progress.travelled / plan.table.length
        if laps >= plan.laps:
            return f"flew {plan.laps:g} laps"
    return None


def _ramp(plan: Plan, memory: Memory) -> Ramp:
    """The factor on alpha: a smooth step in time, because a speed that rises with displacement alone never starts."""
    if plan.ramp_time == 0.0:
        return STEADY
    if memory.follow_from is None or memory.state is None:
        return Ramp(0.0, 0.0, 0.0)
    T = plan.ramp_time
    t = (memory.state.t_boot - memory.follow_from) / T
    if t >= 1.0:
        return STEADY
    return Ramp(
        t**3 * (10.0 - 15.0 * t + 6.0 * t * t),
        30.0 * t * t * (1.0 - t) ** 2 / T,
        60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / T**2,
    )


def _steered(plan: Plan, memory: Memory, ramp: Ramp) -> tuple[Memory, Steered]:
    """The law's setpoint for the newest state. The extension stands still until the vehicle flies on it."""
    state = memory.state
    assert state is not None
    steering = plan.steering.begin(state) if memory.steering is None else memory.steering
    dt = 0.0
    if memory.phase is not Phase.TAKE_OVER and memory.steered_at is not None:
        dt = min(max(state.t_boot - memory.steered_at, 0.0), DT_MAX)
    assert memory.progress is not None
    steered = plan.steering.steer(steering, state, dt, Along(memory.progress.s, ramp))
    return memory._replace(steering=steered.memory, steered_at=state.t_boot), steered


def _request(memory: Memory, now: float) -> Request | None:
    if memory.phase is Phase.TAKE_OVER and now - memory.entered < STREAM_FIRST:
        return None
    return PHASES[memory.phase].request


def yaw_error(steered: Steered) -> float:
    """rad, psi - beta, wrapped."""
    return wrap(steered.command.yaw - steered.command.beta)


def tilt_of(state: VehicleState) -> float:
    """rad, how far the thrust axis leans."""
    return tilt(state.r_nb)
