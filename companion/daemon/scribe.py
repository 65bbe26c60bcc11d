"""The two threads beside the control thread. Neither can hold it up, and neither holds up the other.

The scribe writes the record and waits for the disk; the teller writes the screen, the status file and systemd's line,
and waits for the terminal.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable

from companion.daemon.conductor import Conductor
from companion.daemon.progress import Watch, status_document
from companion.daemon.realtime import HELPER_PRIORITY, at_priority
from companion.daemon.status_file import StatusFile
from companion.daemon.systemd import Service
from companion.record.folder import Recorder

PERIOD = 0.25
"""s between two looks of either thread. Engineering choice."""
SYNC_PERIOD = 0.75
"""s between two syncs: with PERIOD and the sync itself a power cut costs less than two seconds of the record. Issue 11,
rule 7."""
PROGRESS_PERIOD = 1.0
"""s between two lines of progress. Engineering choice."""
LINES_WAITING = 1000
"""Lines that wait for a screen at most; the oldest is dropped. Engineering choice."""
NOTES = 5
"""Lines that another terminal is shown of what was said. Engineering choice."""
DISK_PATIENCE, SCREEN_PATIENCE = 5.0, 2.0
"""s that the end of a flight waits for either of them. Engineering choice."""


class Helper(threading.Thread):
    """Does its work every ``period`` s until it is told to finish. What it cannot do is said once, and never the
    flight's."""

    period = PERIOD

    def __init__(self, name: str, lines: deque[str], clock: Callable[[], float]) -> None:
        super().__init__(name=name, daemon=True)
        self._lines = lines
        self._clock = clock
        self._finished = threading.Event()
        self._failed = False

    def work(self, now: float) -> None:
        """What it is for."""
        raise NotImplementedError

    def run(self) -> None:
        """See Thread."""
        at_priority(HELPER_PRIORITY)
        while not self._finished.wait(self.period):
            self._work()

    def finish(self, patience: float) -> bool:
        """Do what is left and end; False, where it did not come back within ``patience`` s."""
        self._finished.set()
        if self.ident is not None:
            self.join(patience)
        if self.is_alive():
            return False
        self._work()
        return True

    def _work(self) -> None:
        try:
            self.work(self._clock())
        except Exception as error:  # none of the flight's business
            if not self._failed:
                self._failed = True
                self._lines.append(f"the {self.name} failed ({type(error).__name__}: {error}); the flight goes on")


class Scribe(Helper):
    """Writes the record."""

    def __init__(self, recorder: Recorder, lines: deque[str], clock: Callable[[], float]) -> None:
        super().__init__("scribe", lines, clock)
        self._recorder = recorder
        self._synced_at = -math.inf

    def work(self, now: float) -> None:
        """See Helper."""
        sync = now - self._synced_at >= SYNC_PERIOD
        self._recorder.flush(sync=sync)
        if sync:
            self._synced_at = now
        while self._recorder.words:
            self._lines.append(self._recorder.words.popleft())


class Teller(Helper):
    """Says what is to be said: on the screen, to systemd, to ``companion status``."""

    def __init__(
        self,
        conductor: Conductor,
        notice: StatusFile,
        service: Service,
        say: Callable[[str], None],
        clock: Callable[[], float],
    ) -> None:
        self.lines: deque[str] = deque(maxlen=LINES_WAITING)
        super().__init__("teller", self.lines, clock)
        self._conductor = conductor
        self._status_file = notice
        self._service = service
        self._say = say
        self._noted: deque[str] = deque(maxlen=NOTES)
        self._noticed_at = -math.inf
        self._watch = Watch(PROGRESS_PERIOD)

    def work(self, now: float) -> None:
        """See Helper."""
        while self.lines:
            self._noted.append(self.lines.popleft())
            self._say(self._noted[-1])
        line = self._watch.look(self._conductor, now)
        if line is not None:
            self._say(line)
            self._service.status(line)
        if line is not None or now - self._noticed_at >= PROGRESS_PERIOD:
            self._noticed_at = now
            self._status_file.write({**status_document(self._conductor), "progress": line, "notes": list(self._noted)})
