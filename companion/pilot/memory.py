"""What the pilot sees, remembers and does, as values."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight.bench import NOTHING_SHOWN, Shown
from companion.flight.phases import Event, Phase, Request
from companion.flight.safety import NOTHING_SINCE, Since
from companion.flight.situation import Answer
from companion.frames import Vec3
from companion.law.speed_scale import UNITY, SpeedScale
from companion.steering.steering import At, Steered, SteeringMemory
from companion.vehicle import Mode, Setpoint, VehicleState, VehicleStatus

WAKE_AFTER = 0.05
"""s without anything arriving after which the pilot looks around anyway."""


class Observation(NamedTuple):
    """What is seen at a tick. ``state``: a new one, or None. ``answer``: to a request, or None. ``link_delay``: s, the
    measured round trip of a message; None until measured. ``rate``: Hz of states, None until measured. ``behind``:
    states that came together with this one and were passed over. ``companions``: others that speak on the link.
    ``speed_scale``: the factor on the mission's speed that is asked for."""

    state: VehicleState | None
    status: VehicleStatus
    answer: Answer | None = None
    stop: bool = False
    link_delay: float | None = None
    rate: float | None = None
    behind: int = 0
    companions: int = 0
    speed_scale: float = 1.0


class Progress(NamedTuple):
    """Where the vehicle is along the path. ``s``: m, of the nearest point. ``travelled``: m, since following began, in
    the direction that was flown. ``path_error``: m, the distance to the path."""

    s: float
    travelled: float
    path_error: float


class Memory(NamedTuple):
    """What the pilot remembers from tick to tick.

    ``entered``: when the phase began, s by our clock. ``steered_at``: stamp of the last steered state, ``steered``:
    what came of it. ``follow_from``: stamp at which following began, ``leg_from``: at which the present leg of a path
    did. ``leg``: +1 in the mission's direction, -1 back; ``legs``: flown to their ends. ``aim``: the point that is held
    or gone to. ``reached``: the path was reached in this leg. ``scale``: the factor on the speed and its rate, 1/s.
    ``jump`` m and ``clock_jump`` s: of the last state. ``same_place``, ``same_attitude``: it repeated those of the
    state before, and yet moves, or turns. ``gaps``: s by our clock, when the last gaps in the states ended. ``since``:
    of the safety rows. ``first_fault``: why the flight is not going to be completed, ``fault_event`` its kind,
    ``advice`` what to do then; ``last_event``: what began the phase. ``flew``: setpoints were sent. ``shown``: on the
    bench.
    """

    phase: Phase = Phase.PREFLIGHT
    entered: float = 0.0
    state: VehicleState | None = None
    state_at: float | None = None
    mode_seen: bool = False
    answer: Answer | None = None
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
    jump: float = 0.0
    clock_jump: float = 0.0
    same_place: bool = False
    same_attitude: bool = False
    gaps: tuple[float, ...] = ()
    since: Since = NOTHING_SINCE
    finished: bool = False
    first_fault: str | None = None
    fault_event: Event | None = None
    advice: str | None = None
    last_event: Event | None = None
    flew: bool = False
    shown: Shown = NOTHING_SHOWN

    @property
    def place(self) -> Vec3:
        """m, where the vehicle is."""
        assert self.state is not None
        return self.state.p_n


class Outcome(NamedTuple):
    """What is done at a tick: at most one fresh ``setpoint``, the ``request`` that stands, ``notes`` for people.
    ``steered`` and ``ramp``: how the setpoint came about, for the record; None where the law had no say."""

    setpoint: Setpoint | None
    request: Request | None
    notes: tuple[str, ...]
    steered: Steered | None
    ramp: SpeedScale


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
    """When to tick again if nothing arrives."""
    if memory.phase is Phase.DONE:
        return math.inf
    return now + (0.4 * WAKE_AFTER if memory.phase is Phase.ABORT else WAKE_AFTER)


def completed(memory: Memory) -> bool:
    """Whether the flight did what it was to do."""
    return memory.finished and memory.first_fault is None


OWN_MODE: dict[Phase, Mode] = {
    Phase.TAKE_OFF: Mode.TAKEOFF,
    **dict.fromkeys((Phase.TAKE_OVER, Phase.SETTLE, Phase.JOIN, Phase.FOLLOW, Phase.REST), Mode.OFFBOARD),
    Phase.LAND: Mode.LAND,
    Phase.RETURN: Mode.RETURN,
}
"""The mode a phase flies in; seen in one phase it counts in the next that has the same."""
