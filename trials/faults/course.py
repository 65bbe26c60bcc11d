"""What lockstep and real time share: the vehicle and the orders of a case, its course, and the flight that comes of it."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion import pilot
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.asked_of_vehicle import WANTED
from companion.daemon.conductor import Conductor, Orders
from companion.flight.conduct import Conduct
from companion.flight.phases import Phase
from companion.law.gains import law_level
from companion.library.simulation import start_of
from companion.mission import Mission, Origin
from companion.profiles import ConstantSpeed
from companion.vehicle import Mode, MotorInterface, OutputLevel, Vehicle
from companion.world import Start, World
from companion.world.events import Event, Operator
from sim_bridge.bridge import Bridge
from trials.faults.case import Begin, Case, Strike
from trials.faults.traffic import Traffic

BESIDE = (8.0, -5.0)
"""m north of the path's beginning, and m down: where a flight that joins for a while begins."""
OURS = frozenset({Mode.OFFBOARD, Mode.HOLD})
"""The modes in which the height that is lost counts: what we fly, and what we hand back to."""
NO_VEHICLE_AFTER = 20.0
"""s without an identity after which ``fly`` ends with exit code 3 at the latest."""


@dataclass(frozen=True)
class Word:
    """What the operator asked for and the vehicle took, s; ``phase``: what the companion was doing."""

    at: float
    order: Operator
    phase: Phase | None
    mode: Mode


@dataclass
class Flight:
    """A flight that is over. Times s of the clock it was flown by, heights m above the ground, tilt rad.

    ``event_at``: when the first thing happened, None if nothing did; ``height_then``: how high it flew.
    ``noticed_at``: when the companion gave up; ``done_at``: when it ended, None: it did not. ``lowest``, ``steepest``:
    from the event on, while the vehicle was in OFFBOARD or HOLD. ``mode``, ``armed``: at the end. ``entered``: the
    phases and since when. ``sentence``: what is said at the end. ``mutated``: messages.
    """

    case: Case
    level: OutputLevel
    traffic: Traffic
    event_at: float | None = None
    height_then: float = 0.0
    noticed_at: float | None = None
    done_at: float | None = None
    lowest: float = math.inf
    steepest: float = 0.0
    mode: Mode = Mode.HOLD
    armed: bool = False
    completed: bool = False
    sentence: str | None = None
    notes: list[str] = field(default_factory=list)
    entered: list[tuple[Phase, float]] = field(default_factory=list)
    words: list[Word] = field(default_factory=list)
    mutated: int = 0

    @property
    def is_left_to_failsafe(self) -> bool:
        """Whether PX4's failsafe holds it and the companion watches, which at motors it does for 300 s: PX4 acts on
        setpoints lost for 0.1 s there (COM_OF_LOSS_T), before a state is too old for the companion (0.2 s)."""
        is_watched = bool(self.entered) and self.entered[-1][0] is Phase.RELEASE and self.done_at is None
        return self.level is OutputLevel.MOTORS and is_watched and self.armed and self.mode is Mode.HOLD

    def phase_at(self, t: float) -> Phase | None:
        """What the companion was doing at a time; None: it had not begun."""
        return next((phase for phase, since in reversed(self.entered) if since <= t), None)

    def concluded(self, conductor: Conductor) -> Flight:
        """With what the companion says at the end."""
        memory = conductor.memory
        mode = conductor.telemetry.status.last.mode
        self.completed = memory is not None and pilot.completed(memory)
        self.sentence = conductor.refusal or (None if memory is None else pilot.epilogue(memory, mode))
        if conductor.link.identity is None:
            self.sentence = conductor.link.peers.heard_words(conductor.decoder.counters)
        return self


class Course:
    """What happens in the course of a flight: phases begin, strikes that wait for them are let go, heights are seen.

    ``let``: lets events happen, their times counted from now. ``stop``: the user's.
    """

    def __init__(self, flight: Flight, let: Callable[[tuple[Event, ...]], None]) -> None:
        case = flight.case
        self.flight = flight
        self._let = let
        self._waiting = [*(() if case.phase is None else (Strike(case.phase, case.events),)), *case.strikes]
        self._stop_at = case.stop_at if case.phase is None else None
        self._first_at = min((e.when.begin for e in case.events), default=None) if case.phase is None else None
        if case.link.down or case.link.up:
            self._first_at = 0.0
        self._was_high = False

    def look(self, conductor: Conductor, now: float) -> None:
        """What the companion does now; what is due because of it."""
        flight, memory = self.flight, conductor.memory
        if memory is not None:
            if not flight.entered or flight.entered[-1][0] is not memory.phase:
                flight.entered.append((memory.phase, now))
            if memory.first_fault is not None and flight.noticed_at is None:
                flight.noticed_at = now
            for strike in [strike for strike in self._waiting if strike.phase is memory.phase]:
                self._waiting.remove(strike)
                self._strike(strike, now)
        if conductor.refusal is not None and flight.noticed_at is None:
            flight.noticed_at = now
        if self._stop_at is not None and now >= self._stop_at:
            self._stop_at = None
            conductor.stop()

    def _strike(self, strike: Strike, now: float) -> None:
        """The phase has come on which a strike has waited."""
        case = self.flight.case
        self._let(strike.events)
        if strike.phase is case.phase and case.stop_at is not None:
            self._stop_at = now + case.stop_at
        first_at = now + min((e.when.begin for e in strike.events), default=case.stop_at or 0.0)
        self._first_at = first_at if self._first_at is None else min(first_at, self._first_at)

    def measure(self, now: float, height: float, angle: float, *, is_ours: bool) -> None:
        """Where the vehicle truly is; ``is_ours``: armed, in the air, in one of OURS."""
        flight = self.flight
        if flight.event_at is None and self._first_at is not None and now >= self._first_at:
            flight.event_at, flight.height_then = now, height
        if not is_ours:
            return
        flight.steepest = max(flight.steepest, angle)
        self._was_high = self._was_high or height > 0.9 * flight.height_then
        if flight.event_at is not None and self._was_high:
            flight.lowest = min(flight.lowest, height)


@functools.cache
def mission_of(name: str, speed: float, level: OutputLevel) -> Mission:
    """What is flown."""
    return dataclasses.replace(load_mission(name, law_level(level)), speed=ConstantSpeed(speed))


@functools.cache
def vehicle_of(level: OutputLevel) -> Vehicle:
    """Who flies it."""
    vehicle = load_vehicle("x500")
    return dataclasses.replace(vehicle, motors=MotorInterface.DIRECT) if level is OutputLevel.MOTORS else vehicle


def orders_of(case: Case, level: OutputLevel) -> Orders:
    """What the companion is told."""
    conduct = Conduct(authority=case.authority, finish=case.finish)
    return Orders(
        mission_of(case.mission, case.speed, level), vehicle_of(level), level, case.duration, Origin.LOCAL, set_parameters=True,
        conduct=conduct,
    )  # fmt: skip


def bridge_of(case: Case, level: OutputLevel, seed: int) -> Bridge:
    """The vehicle in its world."""
    start = _start(case, mission_of(case.mission, case.speed, level))
    events = () if case.phase is not None else case.events
    bridge = Bridge(
        vehicle_of(level), World(name="faults", link=case.link, events=events), seed=seed,
        direct=level is OutputLevel.MOTORS, start=start, landed=start is None, endpoints=1, only=WANTED,
    )  # fmt: skip
    bridge.autopilot.parameters.update({"COM_OBL_RC_ACT": 5, **case.parameters})
    return bridge


def _start(case: Case, mission: Mission) -> Start | None:
    if case.begin is Begin.ON_THE_GROUND:
        return None
    start = start_of(mission, held=False)
    if case.begin is Begin.BESIDE:
        north, east, down = start.position_n
        return dataclasses.replace(start, position_n=(north + BESIDE[0], east, down + BESIDE[1]))
    return start
