"""A conductor on a real link in real time: one thread, blocking receive, the control step inside the receive.

What does not feed the setpoint (files, the screen) is done by a second thread that sleeps nearly always.
"""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Callable

from companion.daemon.address import Port
from companion.daemon.conductor import Conductor
from companion.daemon.progress import Watch
from companion.daemon.signals import ending_signals
from companion.record.folder import Recorder
from companion.vehicle import CompanionError

SWITCH_INTERVAL = 5e-5
"""s that another Python thread may keep the control thread waiting; Python's default of 5 ms is a whole period."""
SCRIBE_PERIOD = 0.25
PROGRESS_PERIOD = 1.0


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
    gc.collect()
    gc.freeze()  # a full collection of what is imported takes three periods of 250 Hz
    scribe = _Scribe(conductor, recorder, say)
    scribe.start()
    try:
        with ending_signals(conductor.stop) as stopped:
            _fly(conductor, port, wait_for_vehicle)
    finally:
        scribe.finish()
        gc.unfreeze()
        sys.setswitchinterval(interval)
    return bool(stopped)


def _fly(conductor: Conductor, port: Port, wait_for_vehicle: float) -> None:
    begun = clock()
    while not conductor.done:
        batch = port.receive(min(conductor.next_timer() - clock(), 0.1))
        arrived = clock()
        if batch:
            conductor.receive(batch, arrived)
            for datagram in conductor.datagrams():
                port.send(datagram)
            conductor.sent(clock() - arrived)
        now = clock()
        if now >= conductor.next_timer():
            conductor.on_timer(now)
            for datagram in conductor.datagrams():
                port.send(datagram)
            conductor.sent()
        if conductor.link.identity is None and now - begun > wait_for_vehicle:
            counters = conductor.decoder.counters
            raise NoVehicleError(
                f"no vehicle: listened to {port.describe()} for {wait_for_vehicle:g} s and heard "
                f"{counters.frames + counters.unknown} MAVLink messages and {counters.garbage_bytes} bytes of garbage, "
                "but no autopilot's heartbeat; is it on, and does it send here?"
            )


class _Scribe(threading.Thread):
    """Writes the record and the screen."""

    def __init__(self, conductor: Conductor, recorder: Recorder | None, say: Callable[[str], None]) -> None:
        super().__init__(name="scribe", daemon=True)
        self._conductor = conductor
        self._recorder = recorder
        self._say = say
        self._watch = Watch(PROGRESS_PERIOD)
        self._finished = threading.Event()

    def run(self) -> None:
        while not self._finished.wait(SCRIBE_PERIOD):
            self._write()

    def finish(self) -> None:
        """Write what is left and end."""
        self._finished.set()
        self.join()
        self._write()

    def _write(self) -> None:
        if self._recorder is not None:
            self._recorder.flush()
        notes = self._conductor.notes
        for _ in range(len(notes)):
            self._say(notes.pop(0))
        line = self._watch.look(self._conductor, clock())
        if line is not None:
            self._say(line)
