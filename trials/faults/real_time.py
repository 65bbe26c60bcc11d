"""A case -> a flight over UDP, in real time: the daemon's own loop and socket, the vehicle a process of its own."""

from __future__ import annotations

import multiprocessing
import time
from multiprocessing.connection import Connection
from typing import NamedTuple

from companion.daemon.address import UdpPort
from companion.daemon.conductor import Conductor
from companion.daemon.loop import NoVehicleError, clock, run
from companion.daemon.realtime import PRIORITY, at_priority
from companion.mavlink.peer import Received, Source
from companion.vehicle import Mode, OutputLevel
from companion.world.events import Event, Operator
from sim_bridge.server import LOOPBACK, Address, Endpoint, Server
from trials.faults.case import Case, shifted
from trials.faults.course import NO_VEHICLE_AFTER, Course, Flight, Word, bridge_of, orders_of, vehicle_of
from trials.faults.flying import seen
from trials.faults.traffic import Traffic

WAIT_FOR_VEHICLE = 10.0
"""s, as ``fly`` waits."""


class Seen(NamedTuple):
    """Of the vehicle at a step: s of the machine's clock, m, rad, whether it flies in OFFBOARD or HOLD."""

    at: float
    height: float
    angle: float
    is_ours: bool


class Told(NamedTuple):
    """What the vehicle's process tells at the end. ``orders``: s, the order, the answer, the mode then. ``behind``: s
    that the plant's time slipped behind the machine's."""

    seen: list[Seen]
    orders: list[tuple[float, Operator, int | None, Mode]]
    mode: Mode
    armed: bool
    behind: float


class _Overdue(BaseException):
    """The flight does not end; nothing in the loop catches this."""


def fly_over_udp(case: Case, level: OutputLevel) -> tuple[Flight, float]:
    """Fly a case; and the s that the plant slipped behind. What the companion raises is raised."""
    port = UdpPort(LOOPBACK, 0, listen=True)
    near, far = multiprocessing.get_context("spawn").Pipe()
    plant = multiprocessing.get_context("spawn").Process(target=vehicle, args=(case, level, port.local, far))
    plant.start()
    far.close()  # the plant's end: where it dies, ``recv`` tells
    try:
        first = near.recv()
        conductor = Conductor(orders_of(case, level), None, clock())
        flight = Flight(case, level, Traffic(vehicle_of(level)))
        course = Course(flight, near.send)
        begun = clock()
        check_sortie = _LookedAt(port, near, conductor, course, {first}, begun)
        try:
            run(conductor, check_sortie, None, flight.notes.append, WAIT_FOR_VEHICLE)
            flight.done_at = clock() - begun
        except NoVehicleError:
            flight.done_at = clock() - begun
        except _Overdue:
            pass
        time.sleep(case.watched_for)
        near.send(None)
        while not isinstance(told := near.recv(), Told):
            pass
        _add(course, told, begun)
        return flight.concluded(conductor), told.behind
    finally:
        near.close()
        port.close()
        plant.join(5.0)
        plant.kill()


def _add(course: Course, told: Told, begun: float) -> None:
    """What the vehicle's process has seen."""
    flight = course.flight
    flight.mode, flight.armed = told.mode, told.armed
    for at, order, result, mode in told.orders:
        if result == 0:
            flight.words.append(Word(at - begun, order, flight.phase_at(at - begun), mode))
    for moment in told.seen:
        course.measure(moment.at - begun, moment.height, moment.angle, is_ours=moment.is_ours)


class _LookedAt:
    """A port whose every byte is looked at, and the course of the flight with it."""

    stream = False
    called: Source | None = None
    exposed = False

    def __init__(
        self, port: UdpPort, plant: Connection, conductor: Conductor, course: Course, own: set[Address], begun: float
    ) -> None:
        self._port, self._plant, self._conductor, self._course = port, plant, conductor, course
        self._own, self._begun = own, begun

    def receive(self, timeout: float) -> list[Received]:
        """See Port."""
        self._course.look(self._conductor, clock() - self._begun)
        if clock() - self._begun > max(self._course.flight.case.time_out, NO_VEHICLE_AFTER):
            raise _Overdue
        batch = self._port.receive(timeout)
        if self._plant.poll():
            self._own.add(self._plant.recv())
        now = clock() - self._begun
        for data, sender in batch:
            if sender in self._own:
                self._course.flight.traffic.hear(data, now)
        return batch

    def send(self, data: bytes, to: Source) -> None:
        """See Port."""
        self._course.flight.traffic.say(data, clock() - self._begun)
        self._port.send(data, to)

    def close(self) -> None:
        """See Port."""

    def describe(self) -> str:
        """See Port."""
        return self._port.describe()


def vehicle(case: Case, level: OutputLevel, companion: Address, told: Connection) -> None:
    """The vehicle's process: it tells its port, takes events, and tells what it saw when it is told to end."""
    bridge = bridge_of(case, level, 0)
    looks: list[Seen] = []
    orders: list[tuple[float, Operator, int | None, Mode]] = []
    over: list[bool] = []
    server = Server(bridge, [Endpoint((LOOPBACK, 0), companion)], log=lambda line: None, after_step=lambda: look())
    port = server.local
    told.send(port)

    def look() -> None:
        nonlocal port
        now = time.monotonic()
        looks.append(Seen(now, *seen(bridge)))
        for _, order, result in bridge.orders[len(orders) :]:
            orders.append((now, order, None if result is None else int(result), bridge.autopilot.commander.mode))
        if server.local != port:
            port = server.local
            told.send(port)
        while told.poll():
            events: tuple[Event, ...] | None = told.recv()
            if events is None:
                over.append(True)
                return
            for event in events:
                bridge.world_events.add(shifted(event, bridge.truth.t_boot))

    at_priority(PRIORITY + 5)  # the vehicle is punctual, whatever else the machine has to do
    begun = time.monotonic()
    server.run(lambda: bool(over))
    behind = time.monotonic() - begun - bridge.now
    commander = bridge.autopilot.commander
    told.send(Told(looks, orders, commander.mode, commander.armed, behind))
    server.close()
