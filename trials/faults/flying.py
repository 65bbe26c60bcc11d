"""A case -> a flight, in lockstep: the daemon's own conductor against the plant, every byte between them looked at."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass, field

from companion import pilot
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.conductor import Conductor, Orders
from companion.flight.conduct import Conduct
from companion.flight.phases import Phase
from companion.frames import rotation_matrix, tilt
from companion.library.simulation import start_of
from companion.mavlink.dialect import BY_NAME
from companion.mavlink.link import WANTED as LINK_WANTED
from companion.mavlink.telemetry import WANTED
from companion.mission import Mission, Origin
from companion.plan import law_level
from companion.profiles import ConstantSpeed
from companion.vehicle import Mode, MotorInterface, OutputLevel, Vehicle
from companion.world import Start, World
from companion.world.events import Operator
from sim_bridge.autopilot.mavlink.stream_table import TABLE
from sim_bridge.autopilot.mavlink.streams import STOPPED
from sim_bridge.bridge import Bridge
from sim_bridge.strangers import source
from trials.faults.case import Begin, Case, Strike, shifted
from trials.faults.mutation import Mutator
from trials.faults.traffic import Traffic

COMPANION_ENDPOINT, GROUND_STATION_ENDPOINT = 0, 1
BESIDE = (8.0, -5.0)
"""m north of the path's beginning, and m down: where a flight that joins for a while begins."""
OURS = frozenset({Mode.OFFBOARD, Mode.HOLD})
"""The modes in which the height that is lost counts: what we fly, and what we hand back to."""
NO_VEHICLE_AFTER = 20.0
"""s without an identity after which ``fly`` ends with exit code 3 at the latest."""
UNWANTED = frozenset(
    BY_NAME[name].id for name in TABLE
) - WANTED - LINK_WANTED  # fmt: skip
"""Streams the companion does not read: left out, a flight is computed in three quarters of the time."""


@dataclass(frozen=True)
class Word:
    """What the operator asked for and the vehicle took, s; ``phase``: what the companion was doing."""

    at: float
    order: Operator
    phase: Phase | None
    mode: Mode


@dataclass
class Flight:
    """A flight that is over. Times s of the bridge's clock, heights m above the ground, tilt rad.

    ``event_at``: when the first thing happened, None if nothing did; ``height_then``: how high it flew.
    ``noticed_at``: when the companion gave up; ``done_at``: when it ended, None: it did not. ``lowest``, ``steepest``:
    from the event on, while the vehicle was in OFFBOARD or HOLD; ``steepest_before``: until the companion gave up.
    ``mode``, ``armed``: at the end. ``entered``: the phases and since when. ``sentence``: what is said at the end. ``mutated``: messages.
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
    steepest_before: float = 0.0
    mode: Mode = Mode.HOLD
    armed: bool = False
    completed: bool = False
    sentence: str | None = None
    notes: list[str] = field(default_factory=list)
    entered: list[tuple[Phase, float]] = field(default_factory=list)
    words: list[Word] = field(default_factory=list)
    mutated: int = 0

    @property
    def in_air_at_end(self) -> bool:
        """Whether it still flies."""
        return self.armed

    def phase_at(self, t: float) -> Phase | None:
        """What the companion was doing at a time; None: it had not begun."""
        return next((phase for phase, since in reversed(self.entered) if since <= t), None)


@functools.cache
def _mission(name: str, speed: float, level: OutputLevel) -> Mission:
    return dataclasses.replace(load_mission(name, law_level(level)), speed=ConstantSpeed(speed))


@functools.cache
def _vehicle(level: OutputLevel) -> Vehicle:
    vehicle = load_vehicle("x500")
    return dataclasses.replace(vehicle, motors=MotorInterface.DIRECT) if level is OutputLevel.MOTORS else vehicle


def _start(case: Case, mission: Mission) -> Start | None:
    if case.begin is Begin.ON_THE_GROUND:
        return None
    start = start_of(mission, held=False)
    if case.begin is Begin.BESIDE:
        north, east, down = start.position_n
        return dataclasses.replace(start, position_n=(north + BESIDE[0], east, down + BESIDE[1]))
    return start


def fly(case: Case, level: OutputLevel, seed: int = 0) -> Flight:
    """Fly a case. What the companion raises is raised."""
    return Sortie(case, level, seed).fly()


class Sortie:
    """One flight going on."""

    def __init__(self, case: Case, level: OutputLevel, seed: int) -> None:
        vehicle, mission = _vehicle(level), _mission(case.mission, case.speed, level)
        start = _start(case, mission)
        events = () if case.phase is not None else case.events
        self.bridge = Bridge(
            vehicle, World(name="faults", link=case.link, events=events), seed=seed,
            direct=level is OutputLevel.MOTORS, start=start, landed=start is None, endpoints=1,
        )  # fmt: skip
        for msgid in UNWANTED:
            self.bridge.links[COMPANION_ENDPOINT].set_interval(msgid, STOPPED)
        self.bridge.autopilot.parameters.update({"COM_OBL_RC_ACT": 5, **case.parameters})
        conduct = Conduct(authority=case.authority, finish=case.finish)
        orders = Orders(mission, vehicle, level, case.duration, Origin.LOCAL, set_parameters=True, conduct=conduct)
        self.conductor = Conductor(orders, None, 0.0)
        self.flight = Flight(case, level, Traffic(vehicle))
        self._case = case
        self._waiting = [*(() if case.phase is None else (Strike(case.phase, case.events),)), *case.strikes]
        self._mutator = Mutator(case.mutated, seed) if case.mutated else None
        self._stop_at = case.stop_at if case.phase is None else None
        self._first_at = min((e.when.begin for e in case.events), default=None) if case.phase is None else None
        if case.link.down or case.link.up:
            self._first_at = 0.0
        self._orders_seen = 0
        self._was_high = False

    def fly(self) -> Flight:
        """Fly to the end, and watch the vehicle for a while longer."""
        flight, bridge = self.flight, self.bridge
        while not self._is_over(self._case.time_out):
            self._step()
            self._look()
        unmet = self.conductor.link.identity is None
        flight.done_at = bridge.now if self.conductor.done or unmet else None
        until = bridge.now + self._case.watched_for
        while bridge.now < until:
            bridge.step()
            bridge.datagrams()
            self._take_orders()
            self._measure()
        memory = self.conductor.memory
        mode = self.conductor.telemetry.status.last.mode
        flight.completed = memory is not None and pilot.completed(memory)
        flight.sentence = self.conductor.refusal or (None if memory is None else pilot.epilogue(memory, mode))
        if unmet:
            flight.sentence = self.conductor.link.peers.heard_words(self.conductor.decoder.counters)
        flight.mutated = 0 if self._mutator is None else self._mutator.changed
        commander = bridge.autopilot.commander
        flight.mode, flight.armed = commander.mode, commander.armed
        return flight

    def _is_over(self, time_out: float) -> bool:
        """Whether there is nothing left to wait for. Who meets no vehicle waits no longer than the daemon does."""
        unmet = self.conductor.link.identity is None and self.bridge.now > NO_VEHICLE_AFTER
        return self.conductor.done or unmet or self.bridge.now >= time_out

    def _step(self) -> None:
        """One step of the plant, and all that is said about it."""
        conductor, bridge = self.conductor, self.bridge
        bridge.step()
        now = bridge.now
        arrived = self._arrived()
        while arrived or now >= conductor.next_timer():
            if arrived:
                conductor.receive(arrived, now)
            if now >= conductor.next_timer():
                conductor.on_timer(now)
            self._send(now)
            conductor.sent()
            self._send(now)
            arrived = self._arrived()
            if conductor.done:
                break

    def _arrived(self) -> list[tuple[bytes, int]]:
        own = source(COMPANION_ENDPOINT, self.bridge.ports_dialled)
        mutate = self._mutator
        arrived = [
            (data if mutate is None else mutate(data), source(endpoint, self.bridge.ports_dialled))
            for endpoint, data in self.bridge.datagrams()
            if endpoint != GROUND_STATION_ENDPOINT
        ]
        for data, sender in arrived:
            if sender == own:
                self.flight.traffic.hear(data, self.bridge.now)
        return arrived

    def _send(self, now: float) -> None:
        """What the companion says goes to where it met the vehicle; if that is its port no more, it is lost."""
        to = self.conductor.link.peers.to
        for data in self.conductor.datagrams():
            self.flight.traffic.say(data, now)
            if to == source(COMPANION_ENDPOINT, self.bridge.ports_dialled):
                self.bridge.receive(data, COMPANION_ENDPOINT)

    def _look(self) -> None:
        """What the companion does now; what is due because of it."""
        conductor, flight, now = self.conductor, self.flight, self.bridge.now
        flight.notes += conductor.notes
        conductor.notes.clear()
        memory = conductor.memory
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
        self._take_orders()
        self._measure()

    def _strike(self, strike: Strike, now: float) -> None:
        """The phase has come on which a strike has waited."""
        t = self.bridge.truth.t_boot
        for event in strike.events:
            self.bridge.world_events.add(shifted(event, t))
        if strike.phase is self._case.phase and self._case.stop_at is not None:
            self._stop_at = now + self._case.stop_at
        first_at = now + min((e.when.begin for e in strike.events), default=self._case.stop_at or 0.0)
        self._first_at = first_at if self._first_at is None else min(first_at, self._first_at)

    def _take_orders(self) -> None:
        orders = self.bridge.orders
        for at, order, result in orders[self._orders_seen :]:
            memory = self.conductor.memory
            if result == 0:
                phase = None if memory is None else memory.phase
                self.flight.words.append(Word(at, order, phase, self.bridge.autopilot.commander.mode))
        self._orders_seen = len(orders)

    def _measure(self) -> None:
        flight, truth, commander = self.flight, self.bridge.truth, self.bridge.autopilot.commander
        height, lean = -truth.p_n[2], tilt(rotation_matrix(truth.q_nb))
        if flight.event_at is None and self._first_at is not None and self.bridge.now >= self._first_at:
            flight.event_at, flight.height_then = self.bridge.now, height
        if not commander.armed or truth.on_ground or commander.mode not in OURS:
            return
        if flight.noticed_at is None or (flight.noticed_at == self.bridge.now):
            flight.steepest_before = max(flight.steepest_before, lean)
        flight.steepest = max(flight.steepest, lean)
        self._was_high = self._was_high or height > 0.9 * flight.height_then
        if flight.event_at is not None and self._was_high:
            flight.lowest = min(flight.lowest, height)
