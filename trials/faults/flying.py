"""A case -> a flight, in lockstep: the daemon's own conductor against the plant, every byte between them looked at."""

from __future__ import annotations

from companion.daemon.conductor import Conductor
from companion.frames import rotation_matrix, tilt
from companion.mavlink.peer import PEER_SILENT
from companion.vehicle import OutputLevel
from companion.world.events import Event
from sim_bridge.bridge import Bridge
from sim_bridge.strangers import source
from sim_bridge.world_events import COMPANION, GROUND_STATION
from trials.faults.case import Case, shifted
from trials.faults.course import (
    NO_VEHICLE_AFTER,
    OURS,
    Course,
    Flight,
    Word,
    bridge_of,
    orders_of,
    vehicle_of,
)
from trials.faults.mutation import Mutator
from trials.faults.traffic import Traffic

WATCHED = 5.0
"""s for which a vehicle that a failsafe holds is watched, where the companion would for 300 s."""

TURNS_MAX = 1000
"""Turns of the companion at one moment: more is a timer that is due again and again."""


def fly(case: Case, level: OutputLevel, seed: int = 0) -> Flight:
    """Fly a case. What the companion raises is raised."""
    return Sortie(case, level, seed).fly()


def seen(bridge: Bridge) -> tuple[float, float, bool]:
    """Of the vehicle now: height above the ground (m), tilt (rad), whether it flies in one of OURS."""
    truth, commander = bridge.truth, bridge.autopilot.commander
    is_ours = commander.armed and not truth.on_ground and commander.mode in OURS
    return -truth.p_n[2], tilt(rotation_matrix(truth.q_nb)), is_ours


class Sortie:
    """One flight going on."""

    def __init__(self, case: Case, level: OutputLevel, seed: int) -> None:
        self.bridge = bridge_of(case, level, seed)
        self.conductor = Conductor(orders_of(case, level), None, 0.0)
        self.flight = Flight(case, level, Traffic(vehicle_of(level)))
        self._course = Course(self.flight, self._let)
        self._case = case
        self._mutator = Mutator(case.mutated, seed) if case.mutated else None
        self._orders_seen = 0

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
        flight.mutated = 0 if self._mutator is None else self._mutator.changed
        return flight.concluded(self.conductor)

    def _is_over(self, time_out: float) -> bool:
        """Whether there is nothing left to wait for. Who meets no vehicle waits no longer than the daemon does."""
        now, flight = self.bridge.now, self.flight
        unmet = self.conductor.link.identity is None and now > NO_VEHICLE_AFTER
        watched = flight.is_left_to_failsafe and now - flight.entered[-1][1] > WATCHED
        return self.conductor.done or unmet or watched or now >= time_out

    def _step(self) -> None:
        """One step of the plant, and all that is said about it."""
        conductor, bridge = self.conductor, self.bridge
        bridge.step()
        now = bridge.now
        arrived, turns = self._arrived(), 0
        while arrived or now >= conductor.next_timer():
            turns += 1
            if turns > TURNS_MAX:
                raise RuntimeError(f"the companion has not done with {now:g} s after {turns} turns")
            if arrived:
                conductor.receive(arrived, now)
            if now >= conductor.next_timer():
                conductor.on_timer(now)
            self._send(now)
            conductor.finish_tick()
            self._send(now)
            arrived = self._arrived()
            if conductor.done:
                break

    def _arrived(self) -> list[tuple[bytes, int]]:
        own = source(COMPANION, self.bridge.ports_dialled)
        now, peers = self.bridge.now, self.conductor.link.peers
        # in flight another port is taken for the vehicle's only once the old one has been silent
        is_heard = peers.heard in (None, own) or now - peers.heard_at > PEER_SILENT
        mutate = self._mutator
        arrived = [
            (data if mutate is None else mutate(data), source(endpoint, self.bridge.ports_dialled))
            for endpoint, data in self.bridge.datagrams()
            if endpoint != GROUND_STATION
        ]
        for data, sender in arrived:
            if sender == own and is_heard:
                self.flight.traffic.hear(data, now)
        return arrived

    def _send(self, now: float) -> None:
        """What the companion says goes to where it met the vehicle; if that is its port no more, it is lost."""
        to = self.conductor.link.peers.to
        for data in self.conductor.datagrams():
            self.flight.traffic.say(data, now)
            if to == source(COMPANION, self.bridge.ports_dialled):
                self.bridge.receive(data, COMPANION)

    def _look(self) -> None:
        """What the companion does now; what is due because of it."""
        conductor = self.conductor
        self.flight.notes += conductor.notes
        conductor.notes.clear()
        self._course.look(conductor, self.bridge.now)
        self._take_orders()
        self._measure()

    def _let(self, events: tuple[Event, ...]) -> None:
        t = self.bridge.truth.t_boot
        for event in events:
            self.bridge.world_events.add(shifted(event, t))

    def _take_orders(self) -> None:
        orders = self.bridge.orders
        for at, order, result in orders[self._orders_seen :]:
            memory = self.conductor.memory
            if result == 0:
                phase = None if memory is None else memory.phase
                self.flight.words.append(Word(at, order, phase, self.bridge.autopilot.commander.mode))
        self._orders_seen = len(orders)

    def _measure(self) -> None:
        commander = self.bridge.autopilot.commander
        self.flight.mode, self.flight.armed = commander.mode, commander.armed
        height, angle, is_ours = seen(self.bridge)
        self._course.measure(self.bridge.now, height, angle, is_ours=is_ours)
