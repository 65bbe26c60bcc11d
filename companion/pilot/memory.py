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
    """What a tick is given."""

    state: VehicleState | None  # a new one, or None
    status: VehicleStatus  # what the vehicle says of itself, each fact with its age
    answer: Answer | None = None  # to a request, or None
    stop: bool = False  # the user wants the vehicle handed back
    round_trip: float | None = None  # s, of a message; None until measured
    rate: float | None = None  # Hz of states; None until measured
    behind: int = 0  # states that came together with this one and were passed over
    companions: int = 0  # others that speak on the link
    speed_scale: float = 1.0  # the factor on the mission's speed that the ground station asks for
    late: float = 0.0  # s by which the state is older than the youngest this link has brought
    clock_rate: float | None = None  # s of the vehicle's clock a second of ours; None until measured


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
    """What is known of how the states come."""

    arrived_at: float = 0.0  # s, our clock, when the last one arrived
    late: float = 0.0  # s that it was late
    gaps: tuple[float, ...] = ()  # s, our clock, when the last gaps ended
    jump: float = 0.0  # m that the last one lies beside where the one before led
    flagged: bool = False  # its reset counter says so
    clock_jump: float = 0.0  # s that the vehicle's clock ran ahead of ours, or was set back
    older: int = 0  # how many in a row were older than the last usable one
    unusable: str | None = None  # why what came last is no state
    same_place: bool = False  # the last one repeats the position of the one before, although it moves
    same_attitude: bool = False  # the same of the attitude, although it turns


class StateAgreement(NamedTuple):
    """Whether states agree with those before them and with what was commanded."""

    checked: VehicleState | None = None  # the last one that was compared
    sums: Sums = Sums()  # of it with those before it
    place_stands: bool = False  # too little changed for what the velocity says
    attitude_stands: bool = False  # too little changed for what the rates say
    velocity_off: float = 0.0  # m/s by which change and velocity disagree
    rates_off: float = 0.0  # rad/s by which change and body rates disagree
    thrust_response: ThrustResponse = NO_RESPONSE  # the thrust that comes of what is commanded


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
    """What the present phase asks of the vehicle, and what came back."""

    asking: Asking | None = None  # arming or a mode, and how often it was sent; None where the phase asks for nothing
    answer: Answer | None = None  # the vehicle's to it
    answered_at: float = 0.0  # s, our clock; or when its own mode was first seen, where no answer had accepted it
    decided_in: Mode | None = None  # the mode in which it was first asked for
    mode_seen: bool = False  # telemetry has shown the phase's own mode


class SteeringRecord(NamedTuple):
    """What the steering remembers, and its last step."""

    memory: SteeringMemory | None = None  # the blocks' memories; None before the first step
    steered: Steered | None = None  # what came of the last step
    steered_at: float | None = None  # s, the stamp of its state
    scale: SpeedScale = UNITY  # the ground station's factor on the speed, with its rate


class PathMemory(NamedTuple):
    """Where the flight is along its path."""

    progress: Progress | None = None  # at the last state
    follow_from: float | None = None  # s, stamp at which following began
    leg_from: float | None = None  # s, stamp at which the present leg did
    leg: float = 1.0  # +1 in the mission's direction, -1 back
    legs: int = 0  # flown to their ends
    aim: At | None = None  # the point that is held or gone to; None along the path
    reached: bool = False  # the path was reached in this leg, so that the tube around it is watched


class FlightFault(NamedTuple):
    """Why a flight is not going to be completed: the first event that pre-empted it, and what to do then."""

    reason: str
    event: Event
    advice: str | None = None


class Memory(NamedTuple):
    """What the pilot remembers from tick to tick: its own part, and the blocks' memories side by side."""

    phase: Phase = Phase.PREFLIGHT
    entered: float = 0.0  # s, our clock, when the phase began
    last_event: Event | None = None  # what began it
    state: VehicleState | None = None  # the last usable one
    state_at: float | None = None  # s, our clock, when it was measured, as far as its lateness is known
    clock_runs: bool = False  # its stamps advance
    from_ground: bool = False  # the flight began on the ground
    finished: bool = False  # what was to be followed was
    watch: StateWatch = StateWatch()  # how states come
    agreement: StateAgreement = StateAgreement()  # whether they agree with each other
    request: RequestMemory = RequestMemory()  # arming and modes
    path: PathMemory = PathMemory()  # where along it
    steering: SteeringRecord = SteeringRecord()  # the law
    breaches: Since = NOTHING_SINCE  # since when each safety row is breached
    payload: PayloadProgress = PayloadProgress()  # its commands
    fault: FlightFault | None = None  # why the flight is not completed
    done: Done = Done()  # what was done, for the sentence at the end
    missing: Missing | None = None  # what a flight that waits lacks
    shown: Shown = NOTHING_SHOWN  # on the bench

    @property
    def first_fault(self) -> str | None:
        """Why the flight is not going to be completed, in words; None while it may be."""
        return None if self.fault is None else self.fault.reason


class Outcome(NamedTuple):
    """What a tick does."""

    setpoint: Setpoint | None  # at most one, computed in this tick
    request: Request | None  # what is asked of the vehicle
    notes: tuple[str, ...]  # lines for people
    steered: Steered | None  # how the setpoint came about; None where the law was not asked
    ramp: SpeedScale  # the factor on the speed it was flown with
    sent: bool = False  # the request: now
    actions: tuple[PathAction, ...] = ()  # what the payload is to do now, once


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
