"""The flight folder: everything a flight leaves behind.

link.tlog       every frame in both directions
link.xrce       flights over XRCE: every datagram in both directions
flight.npy      one row a tick (see ``tick_columns``)
truth.npy       simulated flights: the plant's true state
notes.txt       every line that was said, and when
mission.yaml    vehicle.yaml    the files that were flown, as they were; and the plan beside a mission that flies one
world.yaml      simulated flights: the world file
resolved.json   what they resolved to: output level, origin in the vehicle's frame, legends of the table
summary.json    the figures
report.html     the page
failure.txt     where the companion itself failed: the traceback

The folder is a new one or an empty one, and only what was made here is ever removed. It is written by one thread
(``flush``) while another flies; ``docs/record.md`` says what a power cut, a full disk or a kill leaves of it.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from companion.pilot import Memory, Observation, Outcome
from companion.plan import Plan
from companion.record import rows
from companion.record.circumstances import SimulatedWorld, simulation_document
from companion.record.files import sync_directory, write_new, write_whole
from companion.record.growing import GrowingFile
from companion.record.place import Place
from companion.record.resolution import resolution
from companion.record.table import Table, TableWriter
from companion.record.tick_columns import COLUMNS
from companion.record.tlog import TlogWriter
from companion.record.xrce_log import XrceWriter

NOTES_WAITING = 5_000
"""Lines of notes.txt that wait for the disk at most (engineering choice)."""
BYTES_PER_SECOND = 280_000
"""Of the record of a link with 250 states a second; bench/soak measures 50 kB of flight.npy and 60 kB of link.tlog at
100 states a second."""
SPACE_MIN = 10 * 60 * BYTES_PER_SECOND
"""Bytes free below which it is said how much of a flight they hold: ten minutes (engineering choice)."""


@dataclass(frozen=True)
class Source:
    """A file that was flown: its name as given and its text. ``attached``: name and text of the file it needs beside
    it, if it needs one (the plan of a mission of kind plan). ``made``: in Python, so that nobody can look up its
    lines."""

    name: str
    text: str
    attached: tuple[str, str] | None = None
    made: bool = False


@dataclass
class Recorder:
    """Writes a flight folder while the flight goes on. ``epoch``: s since 1970 when our clock read zero.

    ``add_frame``, ``begin``, ``add_tick`` and ``note`` take what is to be kept, never wait and never fail. ``flush``
    writes it, in another thread where there is a clock to keep. Nothing here raises in flight: ``words`` has what a
    person should be told. ConfigError: the folder cannot be one.
    """

    directory: Path
    mission: Source
    vehicle: Source
    epoch: float
    simulated: SimulatedWorld | None = None
    words: deque[str] = field(default_factory=deque)
    _place: Place = field(init=False)
    _given: dict[str, str] = field(init=False)
    _tlog: TlogWriter = field(init=False)
    _notes: GrowingFile = field(init=False)
    _xrce: XrceWriter | None = field(init=False, default=None)
    _table: TableWriter | None = field(init=False, default=None)
    _resolution: dict[str, Any] = field(init=False, default_factory=dict)
    _resolved: str | None = field(init=False, default=None)
    _resolved_written: str | None = field(init=False, default=None)
    _failing: bool = field(init=False, default=False)
    _unrecorded: int = field(init=False, default=0)
    _gone: bool = field(init=False, default=False)
    _abandoned: bool = field(init=False, default=False)
    _traces: list[str] = field(init=False, default_factory=list)
    _writing: threading.Lock = field(init=False, default_factory=threading.Lock)

    def __post_init__(self) -> None:
        self._place = Place(self.directory)
        self._tlog = TlogWriter(self.directory / "link.tlog", self.epoch)
        self._notes = GrowingFile(self.directory / "notes.txt", NOTES_WAITING)
        self._given = {"mission.yaml": self.mission.text, "vehicle.yaml": self.vehicle.text}
        if self.simulated is not None:
            self._given["world.yaml"] = self.simulated.text
        if self.mission.attached is not None:
            self._given.setdefault(*self.mission.attached)
        try:
            self._place.make()
            self._write_given()
            self._place.mine(self._tlog.path.name)
            self._tlog.write()
        except OSError as error:
            self._place.judge(error)
            self._fail(error)
        self._check_space()

    @property
    def simulation(self) -> dict[str, Any] | None:
        """The simulated world as resolved.json tells it; None where a vehicle flew."""
        return None if self.simulated is None else simulation_document(self.simulated)

    def add_frame(self, now: float, raw: bytes) -> None:
        """One frame, either direction."""
        self._tlog.add_frame(now, raw)

    def add_datagram(self, now: float, to_px4: bool, data: bytes) -> None:
        """One datagram of PX4's XRCE client, or one to it."""
        self._xrce = self._xrce or XrceWriter(self.directory, self.epoch)
        self._xrce.add_datagram(now, to_px4, data)

    def note(self, now: float, line: str) -> None:
        """One line that was said."""
        self._notes.append(f"{now + self.epoch:.3f} {repr(line)[1:-1]}\n".encode())

    def begin(self, plan: Plan, now: float) -> None:
        """The plan is ready and the pilot begins."""
        self._table = TableWriter(self.directory / "flight.npy", COLUMNS)
        self._resolution = resolution(plan, self.mission.name, self.vehicle.name, now, self.epoch, self.simulation)
        self._resolved = json.dumps(self._resolution, indent=2) + "\n"

    def add_settings(self, changed: dict[str, float], now: float) -> None:
        """Settings of the plan were changed, for the ticks from ``now`` on."""
        self._resolution["settings"].append({"at": now, "set": changed})
        self._resolved = json.dumps(self._resolution, indent=2) + "\n"

    def add_tick(self, seen: Observation, memory: Memory, outcome: Outcome, now: float, latency: float) -> None:
        """One tick of the pilot."""
        if self._table is None:
            return
        try:
            self._table.row(rows.row(seen, memory, outcome, now, latency))
        except Exception as error:  # a row that cannot be made is no reason to stop flying
            self._unrecorded += 1
            if self._unrecorded == 1:
                self.words.append(
                    f"a tick could not be recorded ({type(error).__name__}: {error}); the flight goes on, and "
                    "flight.npy ends here"
                )
            self._table.lost += 1

    def flush(self, *, sync: bool = False) -> None:
        """Write what waits; with ``sync``, have it reach the disk itself."""
        if self._abandoned:
            return
        failed = None
        with self._writing:
            for action in self._actions(sync):
                try:
                    action()
                except OSError as error:
                    failed = failed or error
        if failed is None:
            self._recover()
        else:
            self._fail(failed)

    def path(self, name: str) -> Path:
        """Where somebody else is about to make a file of this folder (the plant its truth)."""
        return self._place.mine(name)

    def keep(self, name: str, text: str) -> bool:
        """Write a file of the folder whole; whether that was possible (if not, it is said)."""
        if self._abandoned:
            return False
        try:
            write_whole(self._place.mine(name), text)
        except OSError as error:
            self.words.append(f"{name} cannot be written ({error.strerror})")
            return False
        return True

    @property
    def table(self) -> Table | None:
        """What was recorded of the pilot's ticks, whatever has become of its file; None where it never began. To be
        asked before ``close``."""
        return None if self._table is None or self._abandoned else self._table.table()

    @property
    def losses(self) -> list[str]:
        """What the record lacks, in words. At the end of a flight: what still waits will not be written either."""
        lost = [
            (0 if self._table is None else self._table.missing, "ticks of flight.npy, which ends where they began"),
            (self._tlog.lost + self._tlog.waiting, "frames of link.tlog"),
            (self._notes.lost + self._notes.waiting, "lines of notes.txt"),
            (0 if self._xrce is None else self._xrce.lost + self._xrce.waiting, "datagrams of link.xrce"),
        ]
        return [f"the record lacks {count} {what}" for count, what in lost if count]

    @property
    def answers(self) -> bool:
        """Whether the disk does, as far as is known."""
        return not self._abandoned

    def keep_failure(self, trace: str) -> None:
        """A traceback for failure.txt, behind those that are there."""
        self._traces.append(trace)
        self.keep("failure.txt", "\n".join(self._traces))

    def abandon(self) -> None:
        """The disk does not answer: whoever writes there is stuck, and the record is left as it is."""
        self._abandoned = True
        self.words.append("the disk does not answer; what the record holds of the last seconds is not known")

    def close(self) -> None:
        """The flight is over."""
        if self._abandoned:
            return
        self.flush(sync=True)
        for file in (self._tlog, self._notes, self._xrce, self._table):
            try:
                if file is not None:
                    file.close()
            except OSError as error:
                self._fail(error)
        sync_directory(self.directory)

    def discard(self) -> None:
        """Nothing happened: leave nothing behind that was made here, and all that was not."""
        self.close()
        self._place.unmake()

    def _actions(self, sync: bool) -> list[Callable[[], object]]:
        files: list[GrowingFile] = [self._tlog, self._notes, *([] if self._xrce is None else [self._xrce])]
        actions: list[Callable[[], object]] = [self._write_given]
        if self._table is not None:
            files.append(self._table)
            actions.append(self._write_resolved)
        for file in files:
            if file.descriptor is None:
                self._place.mine(file.path.name)
        actions += [file.write for file in files]
        if sync:
            actions += [file.sync for file in files]
        elif self._table is not None:
            actions.append(self._table.count)
        return [*actions, self._look_for_folder]

    def _write_given(self) -> None:
        """The files that were flown; once, or as soon as there is room."""
        if self._given:
            self.directory.mkdir(parents=True, exist_ok=True)
            for name in list(self._given):
                write_new(self._place.mine(name), self._given[name])
                del self._given[name]
            sync_directory(self.directory)

    def _write_resolved(self) -> None:
        text = self._resolved  # another thread may set it at any moment: it is read once and never set here
        if text is not None and text is not self._resolved_written:
            write_whole(self._place.mine("resolved.json"), text)
            self._resolved_written = text

    def _look_for_folder(self) -> None:
        if not self._gone and self._tlog.is_gone:
            self._gone = True
            self.words.append(
                f"the flight folder {self.directory} was deleted; the flight goes on, and nothing of it will be left"
            )

    def _check_space(self) -> None:
        with contextlib.suppress(OSError):
            free = shutil.disk_usage(self.directory).free
            if free < SPACE_MIN:
                self.words.append(
                    f"warning: only {free / 1e6:.0f} MB are free for the record, about {free / BYTES_PER_SECOND:.0f} s "
                    "of flight; the flight is flown, and its record ends when the disk is full"
                )

    def _fail(self, error: OSError) -> None:
        if not self._failing:
            self._failing = True
            self.words.append(
                f"the record cannot be written ({error.strerror}); the flight goes on without, and what still fits in "
                "memory is written once there is room"
            )

    def _recover(self) -> None:
        if self._failing:
            self._failing = False
            self.words.append("; ".join(["the record is written again", *self.losses]))
