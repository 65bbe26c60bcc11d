"""What the pilot sees, remembers and does, as values."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight.asking import Asking, next_at
from companion.flight.bench import NOTHING_SHOWN, Shown
from companion.flight.epilogue import Done
from companion.flight.interruptions import STATE_AGE_MAX
from companion.flight.phases import FLOWN, Event, Phase, Request
from companion.flight.safety import NOTHING_SINCE, Since
from companion.flight.situation import Answer
from companion.frames import Vec3
from companion.law.speed_scale import UNITY, SpeedScale
from companion.mission import PathAction
from companion.pilot.thrust_response import NO_RESPONSE, ThrustResponse
from companion.steering.steering import At, Steered, SteeringMemory
from companion.vehicle import Mode, Setpoint, VehicleState, VehicleStatus

WAKE_AFTER = 0.05
"""s without anything arriving after which the pilot looks around anyway. Engineering choice."""


class Observation(NamedTuple):
    """What a tick is given.

    ``state``: a new one, or None.
    ``status``: what the vehicle says of itself, each fact with its age.
    ``answer``: to a request, or None.
    ``stop``: the user wants the vehicle handed back.
    ``link_delay``: s, the round trip of a message; None until measured.
    ``rate``: Hz of states; None until measured.
    ``behind``: states that came together with this one and were passed over.
    ``companions``: others that speak on the link.
    ``speed_scale``: the factor on the mission's speed that the ground station asks for.
    ``late``: s by which the state is older than the youngest this link has brought.
    ``clock_rate``: s of the vehicle's clock a second of ours; None until measured.
    """

    state: VehicleState | None
    status: VehicleStatus
    answer: Answer | None = None
    stop: bool = False
    link_delay: float | None = None
    rate: float | None = None
    behind: int = 0
    companions: int = 0
    speed_scale: float = 1.0
    late: float = 0.0
    clock_rate: float | None = None


class Progress(NamedTuple):
    """Where the vehicle is along the path. ``s``: m, of the nearest point. ``travelled``: m, since following began, in
    the direction that was flown. ``path_error``: m, the distance to the path."""

    s: float
    travelled: float
    path_error: float


class Sums(NamedTuple):
    """What moved and turned within the last moment, and what velocity and body rates make of that time (m, rad)."""

    moved: Vec3 = (0.0, 0.0, 0.0)
    by_velocity: Vec3 = (0.0, 0.0, 0.0)
    turned: Vec3 = (0.0, 0.0, 0.0)
    by_rates: Vec3 = (0.0, 0.0, 0.0)


class StateWatch(NamedTuple):
    """Whether states agree with each other, with the clock and with what was commanded.

    ``arrived_at``: s, our clock, when the last one arrived; ``late``: by so much (s).
    ``gaps``: s, our clock, when the last gaps ended.
    ``jump``: m that the last one lies beside where the one before led; ``flagged``: its reset counter says so.
    ``clock_jump``: s that the vehicle's clock ran ahead of ours, or was set back.
    ``older``: how many in a row were older than the last usable one; ``unusable``: why what came last is no state.
    ``same_place``, ``same_attitude``: the last one repeats the one before, although it moves, or turns.
    ``checked``: the last one that was compared; ``sums``: with those before it.
    ``place_stands``, ``attitude_stands``: too little changed for what velocity and rates say.
    ``velocity_off`` m/s, ``rates_off`` rad/s: how far change and velocity, change and body rates disagree.
    ``thrust_response``: the thrust that comes of what is commanded.
    """

    arrived_at: float = 0.0
    late: float = 0.0
    gaps: tuple[float, ...] = ()
    jump: float = 0.0
    flagged: bool = False
    clock_jump: float = 0.0
    older: int = 0
    unusable: str | None = None
    same_place: bool = False
    same_attitude: bool = False
    checked: VehicleState | None = None
    sums: Sums = Sums()
    place_stands: bool = False
    attitude_stands: bool = False
    velocity_off: float = 0.0
    rates_off: float = 0.0
    thrust_response: ThrustResponse = NO_RESPONSE


class Missing(NamedTuple):
    """What a flight that waits lacks: ``words`` without their figures, ``since`` s, and whether that was
    ``reported``."""

    words: str
    since: float
    reported: bool = False


class PayloadProgress(NamedTuple):
    """How far the payload's commands are.

    ``start``: m from the path's beginning in the way it is flown, where following began; None before the first tick of
    a leg.
    ``reach``: m on the same count up to which commands were sent.
    ``sent``: how many, in all legs.
    """

    start: float | None = None
    reach: float = 0.0
    sent: int = 0


class RequestMemory(NamedTuple):
    """What the present phase asks of the vehicle, and what came back.

    ``asking``: arming or a mode, and how often it was sent; None where the phase asks for nothing.
    ``answer``: the vehicle's to it, ``answered_at`` s by our clock.
    ``decided_in``: the mode in which it was first asked for.
    ``mode_seen``: telemetry has shown the phase's own mode.
    """

    asking: Asking | None = None
    answer: Answer | None = None
    answered_at: float = 0.0
    decided_in: Mode | None = None
    mode_seen: bool = False


class SteeringRecord(NamedTuple):
    """What the steering remembers, and its last step.

    ``memory``: the blocks' memories; None before the first step.
    ``steered``: what came of the last step, at the state with the stamp ``steered_at`` (s).
    ``scale``: the ground station's factor on the speed, with its rate.
    """

    memory: SteeringMemory | None = None
    steered: Steered | None = None
    steered_at: float | None = None
    scale: SpeedScale = UNITY


class PathMemory(NamedTuple):
    """Where the flight is along its path.

    ``progress``: at the last state.
    ``follow_from``: stamp (s) at which following began; ``leg_from``: at which the present leg did.
    ``leg``: +1 in the mission's direction, -1 back; ``legs``: flown to their ends.
    ``aim``: the point that is held or gone to; None along the path.
    ``reached``: the path was reached in this leg, so that the tube around it is watched.
    """

    progress: Progress | None = None
    follow_from: float | None = None
    leg_from: float | None = None
    leg: float = 1.0
    legs: int = 0
    aim: At | None = None
    reached: bool = False


class FlightFault(NamedTuple):
    """Why a flight is not going to be completed: the first event that pre-empted it, and what to do then."""

    reason: str
    event: Event
    advice: str | None = None


class Memory(NamedTuple):
    """What the pilot remembers from tick to tick: its own part, and the blocks' memories side by side.

    ``phase``: since ``entered`` (s by our clock); ``last_event``: what began it.
    ``state``: the last usable one; ``state_at``: s, our clock, when it was measured, as far as its lateness is known.
    ``clock_runs``: its stamps advance.
    ``from_ground``: the flight began on the ground; ``finished``: what was to be followed was.
    ``watch``: whether states agree with each other. ``request``: arming and modes. ``path``: where along it.
    ``steering``: the law. ``breaches``: since when each safety row is breached. ``payload``: its commands.
    ``fault``: why the flight is not completed. ``done``: what was done, for the sentence at the end.
    ``missing``: what a flight that waits lacks. ``shown``: on the bench.
    """

    phase: Phase = Phase.PREFLIGHT
    entered: float = 0.0
    last_event: Event | None = None
    state: VehicleState | None = None
    state_at: float | None = None
    clock_runs: bool = False
    from_ground: bool = False
    finished: bool = False
    watch: StateWatch = StateWatch()
    request: RequestMemory = RequestMemory()
    path: PathMemory = PathMemory()
    steering: SteeringRecord = SteeringRecord()
    breaches: Since = NOTHING_SINCE
    payload: PayloadProgress = PayloadProgress()
    fault: FlightFault | None = None
    done: Done = Done()
    missing: Missing | None = None
    shown: Shown = NOTHING_SHOWN

    @property
    def first_fault(self) -> str | None:
        """Why the flight is not going to be completed, in words; None while it may be."""
        return None if self.fault is None else self.fault.reason


class Outcome(NamedTuple):
    """What a tick does.

    ``setpoint``: at most one, computed in this tick.
    ``request``: what is asked of the vehicle; ``sent``: now.
    ``notes``: lines for people.
    ``steered``, ``ramp``: how the setpoint came about, for the record; None where the law was not asked.
    ``actions``: what the payload is to do now, once.
    """

    setpoint: Setpoint | None
    request: Request | None
    notes: tuple[str, ...]
    steered: Steered | None
    ramp: SpeedScale
    sent: bool = False
    actions: tuple[PathAction, ...] = ()


class LawOutput(NamedTuple):
    """What one step of the steering gave.

    ``steered``: the setpoint and how it came about. ``ramp``: the factor on the mission's speed it was flown with.
    ``scale``: as in ``SteeringRecord``.
    """

    steered: Steered
    ramp: SpeedScale
    scale: SpeedScale


def begin(now: float) -> Memory:
    """The memory at the start of a flight."""
    return Memory(entered=now)


def wake_at(memory: Memory, now: float) -> float:
    """When to tick again if nothing arrives: in time to notice that it does not, and to ask again."""
    if memory.phase is Phase.DONE:
        return math.inf
    at = now + (0.4 * WAKE_AFTER if memory.phase is Phase.ABORT else WAKE_AFTER)
    if memory.state_at is not None and now <= memory.state_at + STATE_AGE_MAX:
        at = min(at, memory.state_at + STATE_AGE_MAX + 1e-3)
    asks_at = next_at(memory.request.asking, memory.phase)
    return asks_at if now < asks_at < at else at


def completed(memory: Memory) -> bool:
    """Whether the flight did what it was to do."""
    return memory.finished and memory.fault is None


LEFT_WITHIN = 1.0
"""s within which a vehicle that is given back must have left a flight mode of ours (engineering choice)."""


def may_be_selected(memory: Memory, now: float) -> bool:
    """Whether a flight mode of ours may be selected, or stayed in. It stays so for a moment when the vehicle is given
    back: PX4 answers a mode that cannot be flown with Return, and Hold has been asked for."""
    given_back = memory.phase in (Phase.HAND_BACK, Phase.ABORT) and now - memory.entered < LEFT_WITHIN
    return memory.phase in (Phase.STAND_BY, *FLOWN) or given_back


OWN_MODE: dict[Phase, Mode] = {
    Phase.TAKE_OFF: Mode.TAKEOFF,
    **dict.fromkeys((Phase.TAKE_OVER, Phase.SETTLE, Phase.JOIN, Phase.FOLLOW, Phase.REST), Mode.OFFBOARD),
    Phase.LAND: Mode.LAND,
    Phase.RETURN: Mode.RETURN,
}
"""The mode a phase flies in; seen in one phase it counts in the next that has the same."""
