"""A conductor on a real link in real time: one thread, blocking receive, the control step inside the receive.

What does not feed the setpoint (files, the screen) is done by two other threads that sleep nearly always. Whatever
escapes a turn is caught here and nowhere else; from then on the last resort stands in the conductor's place.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence

from companion.daemon.beside import Beside, XrceLink
from companion.daemon.conductor import Conductor
from companion.daemon.forwarding import Endpoint, Forwarder
from companion.daemon.last_resort import LastResort
from companion.daemon.live import Publisher
from companion.daemon.port import Port
from companion.daemon.priority import split_by_priority
from companion.daemon.progress import about
from companion.daemon.realtime import punctual
from companion.daemon.rhythm import Rhythm
from companion.daemon.scribe import DISK_PATIENCE, SCREEN_PATIENCE, Scribe, Teller
from companion.daemon.status_file import StatusFile
from companion.daemon.systemd import Service
from companion.daemon.warm_up import WarmUp
from companion.mavlink.codec import Decoder
from companion.mavlink.own_parameters import WANTED as OWN_WANTED
from companion.mavlink.peer import Received
from companion.record.folder import Recorder
from companion.vehicle import CompanionError

SWITCH_INTERVAL = 5e-5
"""s that another Python thread may keep the control thread waiting; Python's default of 5 ms is a whole period.
Engineering choice."""
IDLE_MAX = 0.1
"""s of waiting at most, to see signals and time-outs. Engineering choice."""


class NoVehicleError(CompanionError):
    """Nothing that is a vehicle was heard (exit code 3)."""


def clock() -> float:
    """s, monotonic; the only clock of a flight."""
    return time.monotonic()


def run(
    conductor: Conductor,
    port: Port,
    recorder: Recorder | None,
    say: Callable[[str], None],
    wait_for_vehicle: float,
    forward: Sequence[Endpoint] = (),
    xrce: Port | None = None,
) -> LastResort | None:
    """Fly until the conductor is done. What ended the flight in its place, where the companion itself failed.

    ``say`` takes lines for a person. ``forward``: who shares the link. ``xrce``: where PX4's XRCE
    client is served, if the conductor commands over it. NoVehicleError: none within ``wait_for_vehicle`` s.
    """
    beside = None if xrce is None or conductor.xrce is None else XrceLink(xrce, conductor.xrce)
    if beside is not None:
        port = Beside(port, beside, clock)
    with _without_interruptions(), contextlib.closing(Service(os.environ)) as service:
        notice = StatusFile(about(conductor.orders, port.describe(), recorder))
        teller = Teller(conductor, notice, service, say, clock)
        publisher = Publisher(conductor, teller.lines, clock)
        forwarder = Forwarder(forward, conductor.notes.append) if forward else None
        scribe = None if recorder is None else Scribe(recorder, teller.lines, clock)
        try:
            teller.start()
            publisher.start()
            if forwarder is not None:
                conductor.relay(forwarder.give)
            if scribe is not None:
                scribe.start()
            with punctual() as priority:
                say(priority)
                service.ready(f"listening to {port.describe()}")
                return _Flight(conductor, port, service, recorder, teller, forwarder, beside).fly(wait_for_vehicle)
        finally:
            service.stopping()
            if scribe is not None and recorder is not None and not scribe.finish(DISK_PATIENCE):
                recorder.abandon()
            publisher.finish(SCREEN_PATIENCE)
            if forwarder is not None:
                teller.lines.extend(forwarder.close(SCREEN_PATIENCE))
            teller.finish(SCREEN_PATIENCE)
            publisher.remove()
            notice.remove()


@contextlib.contextmanager
def _without_interruptions() -> Iterator[None]:
    """While it lasts, neither the interpreter's other threads nor its collections come between."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    _freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        gc.unfreeze()
        sys.setswitchinterval(interval)


class _Flight:
    """A flight's turns: wait for what arrives, act, send; whoever flies."""

    def __init__(
        self,
        conductor: Conductor,
        port: Port,
        service: Service,
        recorder: Recorder | None,
        teller: Teller,
        forwarder: Forwarder | None,
        xrce: XrceLink | None = None,
    ) -> None:
        self._conductor = conductor
        self._flown: Conductor | LastResort = conductor
        self._port = port
        self._service = service
        self._recorder = recorder
        self._teller = teller
        self._forwarder = forwarder
        self._asked = Decoder(wanted=OWN_WANTED, signing=conductor.decoder.signing)
        self._xrce = xrce
        self._rhythm, self._warm_up = Rhythm(), WarmUp()
        self._states = 0
        self._frozen = False

    def fly(self, wait_for_vehicle: float) -> LastResort | None:
        """Turn after turn until it is done."""
        if self._port.called is not None:
            self._conductor.link.peers.call(self._port.called)
        begun = clock()
        while not self._flown.done:
            try:
                self._turn()
            except Exception as error:  # the one place that catches whatever escapes
                if isinstance(self._flown, LastResort):
                    self._flown.stumble(clock())
                else:
                    self._flown = LastResort(self._conductor, error, clock())
                    self._conductor.notes.append(f"the companion itself failed: {error!r}")
            if self._conductor.link.identity is None and clock() - begun > wait_for_vehicle:
                raise self._nobody(wait_for_vehicle)
        self._hand_over(clock())
        return self._flown if isinstance(self._flown, LastResort) else None

    def _turn(self) -> None:
        flown = self._flown
        batch = self._next()
        arrived, states = clock(), self._states
        if batch:
            urgent, later = self._split(batch)
            flown.receive(urgent, arrived)
            self._send(arrived)
            if self._conductor.states != self._states:
                self._states = self._conductor.states
                self._rhythm.add_arrival(arrived)
                gc.collect(0)  # now, and not in the middle of a tick
            if later:
                flown.receive(later, arrived)
                self._send(arrived)
        now = clock()
        if now >= flown.next_timer():
            flown.on_timer(now)
            self._send()
        if self._forwarder is not None:
            self._send_on(self._forwarder.exchange(now, answered=self._states != states), now)
        self._service.alive(now)
        self._hand_over(now)
        if self._conductor.plan is not None and not self._frozen:
            self._frozen = True
            _freeze()

    def _split(self, batch: list[Received]) -> tuple[list[Received], list[Received]]:
        """What is taken in before the setpoint, and after it."""
        if self._port.stream:
            return batch, []
        return split_by_priority(batch, self._conductor.decoder.wanted, self._conductor.link.peers.heard)

    def _next(self) -> list[Received]:
        """What arrives next; nothing, where something else is due first."""
        port, rhythm = self._port, self._rhythm
        now = clock()
        timer = min(self._flown.next_timer(), now + IDLE_MAX)
        while (early := rhythm.warm_up_at(now)) < timer and self._flown is self._conductor:
            batch = port.receive(early - now)
            if batch:
                return batch
            begun = clock()
            if not self._warm_up.run(self._conductor):
                break
            now = clock()
            rhythm.add_warm_up(begun, now)
            batch = port.receive(0.0)
            if batch:
                rhythm.was_late()
                return batch
        while clock() < rhythm.watch_until:
            batch = port.receive(0.0)
            if batch:
                return batch
        return port.receive(max(timer - clock(), 0.0))

    def _send(self, arrived: float = math.nan) -> None:
        to = self._conductor.link.peers.to
        if self._xrce is not None:
            self._xrce.flush(clock())
        for datagram in self._flown.datagrams():  # the setpoint
            if to is not None:
                self._port.send(datagram, to)
        self._flown.finish_tick(clock() - arrived)  # the rest of the tick, pilot.supervise, and the record
        for datagram in self._flown.datagrams():  # what that queued
            if to is not None:
                self._port.send(datagram, to)
        if self._xrce is not None:  # a setpoint that came with the rest of the tick
            self._xrce.flush(clock())

    def _send_on(self, frames: list[bytes], now: float) -> None:
        """What endpoints have for the vehicle, unchanged. Who asks for our own parameters or sets them is answered, as
        a ground station behind the vehicle is."""
        to, identity = self._conductor.link.peers.to, self._conductor.link.identity
        if to is None:
            return
        for frame in frames:
            self._port.send(frame, to)
            if self._recorder is not None:
                self._recorder.add_frame(now, frame)
            for asked in self._asked.datagram(frame):
                if identity is not None and self._flown is self._conductor:
                    self._conductor.ground.receive(asked, identity.system, now, of_vehicle=False)

    def _hand_over(self, now: float) -> None:
        """What was said goes to the record and to the screen."""
        notes = self._conductor.notes
        if not notes:
            return
        for note in notes:
            if self._recorder is not None:
                self._recorder.note(now, note)
            self._teller.lines.append(note)
        notes.clear()

    def _nobody(self, waited: float) -> NoVehicleError:
        heard = self._conductor.link.peers.heard_words(self._conductor.decoder.counters)
        return NoVehicleError(f"no vehicle: listened to {self._port.describe()} for {waited:g} s and heard {heard}")


def _freeze() -> None:
    """What is here now is here to stay: looking at it again in a collection would take three periods of 250 Hz."""
    gc.collect()
    gc.freeze()
