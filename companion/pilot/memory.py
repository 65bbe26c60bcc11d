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
from companion.pilot.lift import NO_LIFT, Lift
from companion.steering.steering import At, Steered, SteeringMemory
from companion.vehicle import Mode, Setpoint, VehicleState, VehicleStatus

WAKE_AFTER = 0.05
"""s without anything arriving after which the pilot looks around anyway."""


class Observation(NamedTuple):
    """What is seen at a tick. ``state``: a new one, or None. ``answer``: to a request, or None. ``link_delay``: s, the
    measured round trip of a message; None until measured. ``rate``: Hz of states, None until measured. ``behind``:
    states that came together with this one and were passed over. ``companions``: others that speak on the link.
    ``speed_scale``: the factor on the mission's speed that is asked for. ``late``: s by which the state is older than
    the youngest this link has brought. ``clock_pace``: s of the vehicle's clock a second of ours, None until measured.
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
    clock_pace: float | None = None


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
    """What is remembered of the states themselves, to tell good ones from others.

    ``arrived_at``: s, our clock, when the last one arrived, ``late`` s late. ``gaps``: when the last gaps ended.
    ``jump``: m that the last one lies beside where the one before led, ``flagged``: its reset counter says so.
    ``clock_jump``: s that the vehicle's clock ran ahead of ours, or was set back. ``older``: how many in a row were
    older. ``unusable``: why what came last is no state. ``same_place``, ``same_attitude``: the last one repeated those
    of the one before, and yet moves, or turns. ``checked``: the last one that was compared; ``sums``: with the ones
    before. ``place_stands``, ``attitude_stands``: too little of it for what velocity and rates say. ``velocity_off``
    m/s, ``rates_off`` rad/s: how far they disagree. ``lift``: the thrust that comes of what is commanded.
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
    lift: Lift = NO_LIFT


class Missing(NamedTuple):
    """What a flight that waits lacks: ``words`` without their figures, ``since`` s, and whether that was ``told``."""

    words: str
    since: float
    told: bool = False


class PayloadProgress(NamedTuple):
    """How far the payload's commands are. ``start``: m from the path's beginning in the way it is flown, where
    following began; ``reach``: m from there on the same count up to which they were sent. ``sent``: how many."""

    start: float
    reach: float
    sent: int


class Memory(NamedTuple):
    """What the pilot remembers from tick to tick.

    ``entered``: when the phase began, s by our clock. ``state_at``: s, our clock, when the last state was measured, as
    far as its lateness is known; ``watch``: of the states. ``mode_seen``: the phase's own mode was; ``asking``: what
    the phase asks for, ``answer``: to it, ``answered_at`` s; ``decided_in``: the mode in which that began.
    ``clock_runs``: the stamps advance. ``steered_at``: stamp of the last steered state, ``steered``: what came of it.
    ``follow_from``: stamp at which following began, ``leg_from``: at which the present leg of a path did. ``leg``: +1
    in the mission's direction, -1 back; ``legs``: flown to their ends. ``aim``: the point that is held or gone to.
    ``reached``: the path was reached in this leg. ``scale``: the factor on the speed and its rate, 1/s. ``since``: of
    the safety rows. ``first_fault``: why the flight is not going to be completed, ``fault_event`` its kind, ``advice``
    what to do then; ``last_event``: what began the phase. ``done``: for the sentence it ends with. ``missing``:
    before it begins. ``shown``: on the bench. ``payload``: of this leg, None before its first tick; ``payload_sent``:
    commands in the legs before.
    """

    phase: Phase = Phase.PREFLIGHT
    entered: float = 0.0
    state: VehicleState | None = None
    state_at: float | None = None
    mode_seen: bool = False
    asking: Asking | None = None
    answer: Answer | None = None
    answered_at: float = 0.0
    decided_in: Mode | None = None
    clock_runs: bool = False
    from_ground: bool = False
    steering: SteeringMemory | None = None
    steered: Steered | None = None
    steered_at: float | None = None
    progress: Progress | None = None
    follow_from: float | None = None
    leg_from: float | None = None
    leg: float = 1.0
    legs: int = 0
    aim: At | None = None
    reached: bool = False
    scale: SpeedScale = UNITY
    watch: StateWatch = StateWatch()
    since: Since = NOTHING_SINCE
    finished: bool = False
    first_fault: str | None = None
    fault_event: Event | None = None
    advice: str | None = None
    last_event: Event | None = None
    done: Done = Done()
    missing: Missing | None = None
    shown: Shown = NOTHING_SHOWN
    payload: PayloadProgress | None = None
    payload_sent: int = 0

    @property
    def place(self) -> Vec3:
        """m, where the vehicle is."""
        assert self.state is not None
        return self.state.p_n


class Outcome(NamedTuple):
    """What is done at a tick: at most one fresh ``setpoint``, the ``request`` that stands and whether it is ``sent``
    now, ``notes`` for people.

    ``steered`` and ``ramp``: how the setpoint came about, for the record; None where the law had no say.
    ``actions``: what the payload is to do now, once."""

    setpoint: Setpoint | None
    request: Request | None
    notes: tuple[str, ...]
    steered: Steered | None
    ramp: SpeedScale
    sent: bool = False
    actions: tuple[PathAction, ...] = ()


class First(NamedTuple):
    """What the law said before the rest of a tick: the setpoint with how it came about, the factor on the speed, and
    ``scale`` as in Memory."""

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
    asks_at = next_at(memory.asking, memory.phase)
    return asks_at if now < asks_at < at else at


def completed(memory: Memory) -> bool:
    """Whether the flight did what it was to do."""
    return memory.finished and memory.first_fault is None


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
