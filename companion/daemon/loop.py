"""A conductor on a real link in real time: one thread, blocking receive, the control step inside the receive.

What does not feed the setpoint (files, the screen) is done by a second thread that sleeps nearly always.
"""

from __future__ import annotations

import gc
import math
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable

from companion.daemon.conductor import Conductor
from companion.daemon.port import Port
from companion.daemon.priority import parted
from companion.daemon.progress import Watch, about, standing
from companion.daemon.realtime import HELPER_PRIORITY, at_priority, punctual
from companion.daemon.rhythm import Rhythm
from companion.daemon.signals import ending_signals
from companion.daemon.status_file import Notice
from companion.daemon.systemd import Service
from companion.daemon.warm_up import Rehearsal
from companion.mavlink.peer import Received
from companion.record.folder import Recorder
from companion.vehicle import CompanionError

SWITCH_INTERVAL = 5e-5
"""s that another Python thread may keep the control thread waiting; Python's default of 5 ms is a whole period."""
SCRIBE_PERIOD = 0.25
PROGRESS_PERIOD = 1.0
NOTES = 5
"""Lines that another terminal is shown of what was said."""
IDLE_MAX = 0.1
"""s of waiting at most, to see signals and time-outs."""


class NoVehicleError(CompanionError):
    """Nothing that is a vehicle was heard (exit code 3)."""


def clock() -> float:
    """s, monotonic; the only clock of a flight."""
    return time.monotonic()


def run(
    conductor: Conductor, port: Port, recorder: Recorder | None, say: Callable[[str], None], wait_for_vehicle: float
) -> bool:
    """Fly until the conductor is done. True where a signal asked for the end.

    ``say`` takes lines for a person. NoVehicleError: none within ``wait_for_vehicle`` s.
    """
    interval = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    _freeze()
    gc.disable()
    service = Service(os.environ)
    scribe = _Scribe(conductor, port, recorder, say, service)
    scribe.start()
    try:
        with punctual() as priority, ending_signals(conductor.stop) as stopped:
            say(priority)
            service.ready(f"listening to {port.describe()}")
            _fly(conductor, port, service, wait_for_vehicle)
    finally:
        service.stopping()
        scribe.finish()
        service.close()
        gc.enable()
        gc.unfreeze()
        sys.setswitchinterval(interval)
    return bool(stopped)


def _fly(conductor: Conductor, port: Port, service: Service, wait_for_vehicle: float) -> None:
    if port.called is not None:
        conductor.link.peers.call(port.called)
    begun = clock()
    rhythm, rehearsal = Rhythm(), Rehearsal()
    states = 0
    frozen = False
    while not conductor.done:
        batch = _next(conductor, port, rhythm, rehearsal)
        arrived = clock()
        if batch:
            urgent, later = (
                (batch, []) if port.stream else parted(batch, conductor.decoder.wanted, conductor.link.peers.heard)
            )
            conductor.receive(urgent, arrived)
            _send(conductor, port, arrived)
            if conductor.states != states:
                states = conductor.states
                rhythm.arrived(arrived)
                gc.collect(0)  # now, and not in the middle of a tick
            if later:
                conductor.receive(later, arrived)
                _send(conductor, port, arrived)
        now = clock()
        if now >= conductor.next_timer():
            conductor.on_timer(now)
            _send(conductor, port)
        service.alive(now)
        if conductor.plan is not None and not frozen:
            frozen = True
            _freeze()
        if conductor.link.identity is None and now - begun > wait_for_vehicle:
            heard = conductor.link.peers.heard_words(conductor.decoder.counters)
            raise NoVehicleError(
                f"no vehicle: listened to {port.describe()} for {wait_for_vehicle:g} s and heard {heard}"
            )


def _next(conductor: Conductor, port: Port, rhythm: Rhythm, rehearsal: Rehearsal) -> list[Received]:
    """What arrives next; nothing, where something else is due first."""
    now = clock()
    timer = min(conductor.next_timer(), now + IDLE_MAX)
    while (early := rhythm.rehearse_at(now)) < timer:
        batch = port.receive(early - now)
        if batch:
            return batch
        begun = clock()
        if not rehearsal.fly(conductor):
            break
        now = clock()
        rhythm.rehearsed(begun, now)
        batch = port.receive(0.0)
        if batch:
            rhythm.was_late()
            return batch
    while clock() < rhythm.watch_until:
        batch = port.receive(0.0)
        if batch:
            return batch
    return port.receive(max(timer - clock(), 0.0))


def _send(conductor: Conductor, port: Port, arrived: float = math.nan) -> None:
    to = conductor.link.peers.to
    for datagram in conductor.datagrams():
        if to is not None:
            port.send(datagram, to)
    conductor.sent(clock() - arrived)
    for datagram in conductor.datagrams():
        if to is not None:
            port.send(datagram, to)


def _freeze() -> None:
    """What is here now is here to stay: looking at it again in a collection would take three periods of 250 Hz."""
    gc.collect()
    gc.freeze()


class _Scribe(threading.Thread):
    """Writes the record and the screen."""

    def __init__(
        self, conductor: Conductor, port: Port, recorder: Recorder | None, say: Callable[[str], None], service: Service
    ) -> None:
        super().__init__(name="scribe", daemon=True)
        self._notice = Notice(about(conductor.orders, port.describe(), recorder))
        self._noted: deque[str] = deque(maxlen=NOTES)
        self._noticed_at = -math.inf
        self._conductor = conductor
        self._recorder = recorder
        self._say = say
        self._service = service
        self._watch = Watch(PROGRESS_PERIOD)
        self._finished = threading.Event()
        self._full = False

    def run(self) -> None:
        at_priority(HELPER_PRIORITY)
        while not self._finished.wait(SCRIBE_PERIOD):
            self._write()

    def finish(self) -> None:
        """Write what is left and end."""
        self._finished.set()
        self.join()
        self._write()
        self._notice.remove()

    def _write(self) -> None:
        if self._recorder is not None and not self._full:
            try:
                self._recorder.flush()
            except OSError as error:
                self._full = True
                self._say(f"the record cannot be written ({error.strerror}); the flight goes on without")
        notes = self._conductor.notes
        for _ in range(len(notes)):
            self._noted.append(notes.pop(0))
            self._say(self._noted[-1])
        now = clock()
        line = self._watch.look(self._conductor, now)
        if line is not None:
            self._say(line)
            self._service.status(line)
        if line is not None or now - self._noticed_at >= PROGRESS_PERIOD:
            self._noticed_at = now
            self._notice.write({**standing(self._conductor), "progress": line, "notes": list(self._noted)})
