"""The flight folder: everything a flight leaves behind.

link.tlog       every frame in both directions
flight.npy      one row a tick (see ``rows.COLUMNS``)
truth.npy       simulated flights: the plant's true state
mission.yaml    vehicle.yaml    the files that were flown, as they were; and the plan beside a mission that flies one
world.yaml      simulated flights: the world file
resolved.json   what they resolved to: output level, origin in the vehicle's frame, legends of the table
summary.json    the figures
report.html     the page
"""

from __future__ import annotations

import json
import re
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from companion.flight.conduct import to_dict
from companion.flight.phases import Phase, Request
from companion.flight.situation import Reply
from companion.pilot import Memory, Observation, Outcome
from companion.plan import Plan
from companion.record import rows
from companion.record.circumstances import Simulated, simulation_document, software_version
from companion.record.table import TableWriter
from companion.record.tlog import TlogWriter
from companion.vehicle import Landed, Mode


@dataclass(frozen=True)
class Source:
    """A file that was flown: its name as given and its text. ``attached``: name and text of the file it needs beside
    it, if it needs one (the plan of a mission of kind plan)."""

    name: str
    text: str
    attached: tuple[str, str] | None = None


@dataclass
class Recorder:
    """Writes a flight folder while the flight goes on. ``epoch``: s since 1970 when our clock read zero."""

    directory: Path
    mission: Source
    vehicle: Source
    epoch: float
    simulated: Simulated | None = None
    _tlog: TlogWriter = field(init=False)
    _table: TableWriter | None = field(init=False, default=None)
    _made: list[Path] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        self._made = [path for path in (self.directory, *self.directory.parents) if not path.exists()]
        self.directory.mkdir(parents=True, exist_ok=True)
        for stale in ("flight.npy", "truth.npy", "summary.json", "report.html", "resolved.json", "world.yaml"):
            (self.directory / stale).unlink(missing_ok=True)
        (self.directory / "mission.yaml").write_text(self.mission.text, encoding="utf-8")
        (self.directory / "vehicle.yaml").write_text(self.vehicle.text, encoding="utf-8")
        if self.simulated is not None:
            (self.directory / "world.yaml").write_text(self.simulated.text, encoding="utf-8")
        if self.mission.attached is not None:
            name, text = self.mission.attached
            (self.directory / name).write_text(text, encoding="utf-8")
        self._tlog = TlogWriter(self.directory / "link.tlog", self.epoch)

    @property
    def simulation(self) -> dict[str, Any] | None:
        """The simulated world as resolved.json tells it; None where a vehicle flew."""
        return None if self.simulated is None else simulation_document(self.simulated)

    def frame(self, now: float, raw: bytes) -> None:
        """One frame, either direction."""
        self._tlog.append(now, raw)

    def begin(self, plan: Plan, now: float) -> None:
        """The plan is ready and the pilot begins."""
        resolved = {
            "schema": "companion.resolved/1",
            "version": software_version(),
            "simulation": self.simulation,
            "mission": {"name": plan.mission.name, "file": self.mission.name},
            "vehicle": {"name": plan.vehicle.name, "file": self.vehicle.name},
            "output": plan.level.value,
            "motors": plan.vehicle.motors.value,
            "origin_n": list(plan.mission.placement.origin_n),
            "turn_rad": plan.mission.placement.turn,
            "duration_s": plan.duration,
            "tuning": plan.tuning._asdict(),
            "conduct": to_dict(plan.conduct),
            "learned": None if plan.learned is None else plan.learned._asdict(),
            "begun_at": now,
            "epoch": self.epoch,
            "path_length_m": plan.table.length,
            "columns": {column.name: column.meaning for column in rows.COLUMNS},
            "legend": {
                "phase": [phase.value for phase in Phase],
                "request": [request.value for request in Request],
                "answer": [reply.words for reply in Reply],
                "mode": [mode.words for mode in Mode],
                "landed": [landed.name.lower() for landed in Landed],
            },
        }
        write_json(self.directory / "resolved.json", resolved)
        self._table = TableWriter(self.directory / "flight.npy", rows.COLUMNS)

    def tick(self, seen: Observation, memory: Memory, outcome: Outcome, now: float, latency: float) -> None:
        """One tick of the pilot."""
        if self._table is not None:
            self._table.append(rows.row(seen, memory, outcome, now, latency))

    def flush(self) -> None:
        """Bring everything to the disk's door."""
        self._tlog.flush()
        if self._table is not None:
            self._table.flush()

    def close(self) -> None:
        """The flight is over."""
        self._tlog.close()
        if self._table is not None:
            self._table.close()

    def discard(self) -> None:
        """Nothing happened: leave no folder behind that holds nothing."""
        self.close()
        attached = [] if self.mission.attached is None else [self.mission.attached[0]]
        for name in ("link.tlog", "mission.yaml", "vehicle.yaml", "world.yaml", *attached):
            (self.directory / name).unlink(missing_ok=True)
        for path in self._made:
            if not any(path.iterdir()):
                path.rmdir()


def write_json(path: Path, value: Any) -> None:
    """A JSON file for people and programs."""
    path.write_text(json.dumps(value, indent=2) + "\n", encoding="utf-8")


def new_directory(mission: str) -> Path:
    """A name for a new flight folder: flights/DATE-TIME-MISSION, not taken yet."""
    slug = re.sub(r"[^a-z0-9]+", "-", mission.lower()).strip("-") or "flight"
    stem = Path("flights") / f"{time.strftime('%Y%m%d-%H%M%S')}-{slug}"
    candidate, number = stem, 2
    while candidate.exists():
        candidate = stem.with_name(f"{stem.name}-{number}")
        number += 1
    return candidate
