"""A flight folder read again: its documents, its tables, its mission where it was flown. What was planned of it is made
in ``replay``; an export needs none of that, and is done sooner without."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError, Fault
from companion.frames import Vec3
from companion.geodesy import GivenHome
from companion.law.gains import law_level
from companion.mission import Mission
from companion.paths.arc import ArcTable
from companion.record.table import Table, read_table
from companion.record.tick_columns import COLUMNS
from companion.vehicle import OutputLevel


@dataclass(frozen=True, slots=True)
class FlightFolder:
    """What stands in a flight folder. ``resolved``: resolved.json. ``mission``: as it is written. ``origin_n`` (m,
    local frame), ``turn`` (rad): where it was flown. ``truth``: the plant's true state, None where there is none.
    ``begun_at``: s, our clock. ``cuts``: in words, which of its files end before their flight did."""

    resolved: dict[str, Any]
    level: OutputLevel
    mission: Mission
    origin_n: Vec3
    turn: float
    vehicle: Document
    table: Table
    truth: Table | None
    begun_at: float
    cuts: tuple[str, ...]

    @property
    def path(self) -> ArcTable:
        """Its path over the arc length, in the vehicle's local frame."""
        return self.mission.placed(self.origin_n, self.turn).table


def read_folder(directory: Path) -> FlightFolder:
    """The flight in a folder. ConfigError: it is not one, or lacks a part."""
    if not directory.is_dir():
        raise ConfigError([Fault(str(directory), 0, "", "no such folder; expected a flight folder")])
    resolved_file = directory / "resolved.json"
    reading = resolved_file
    try:
        resolved = json.loads(resolved_file.read_text(encoding="utf-8"))
        level = OutputLevel(resolved["output"])
        x, y, z = resolved["origin_n"]
        turn = float(resolved["turn_rad"])
        given = GivenHome(*resolved.get("home_told", ()))
        begun_at = float(resolved["begun_at"])
        reading = directory / "mission.yaml"
        mission = _document(reading)
        reading = directory / "vehicle.yaml"
        vehicle = _document(reading)
        reading = directory / "flight.npy"
        table, cut = read_table(reading, COLUMNS)
        truth, truth_cut = _truth(directory / "truth.npy")
    except FileNotFoundError as error:
        message = f"{Path(str(error.filename)).name} is missing; expected a flight folder"
        if error.filename == str(resolved_file) and (directory / "link.tlog").is_file():
            message = "the record ends before the flight began; link.tlog has what was heard until then"
        raise ConfigError([Fault(str(directory), 1, "", message)]) from None
    except UNREADABLE as error:
        raise unreadable(reading, error) from None
    read = mission_from(mission, law_level(level), directory, given, simulated=True)
    cuts = tuple(words for words in (cut, truth_cut) if words is not None)
    return FlightFolder(resolved, level, read, (x, y, z), turn, vehicle, table, truth, begun_at, cuts)


UNREADABLE = (OSError, ValueError, KeyError, TypeError)
"""What a file raises that no flight wrote so."""


def unreadable(file: Path, error: Exception) -> ConfigError:
    """Why ``file`` of a flight folder cannot be read."""
    what = f"key {error} is missing" if isinstance(error, KeyError) else str(error)
    return ConfigError([Fault(str(file), 1, "", f"cannot be read: {what}; expected it as the flight wrote it")])


def _truth(path: Path) -> tuple[Table | None, str | None]:
    """The plant's true state, and how it was cut; None where there is none."""
    if not path.is_file():
        return None, None
    try:
        return read_table(path)
    except ValueError:
        return None, f"{path.name} is cut within its header: no row of it is left"


def _document(path: Path) -> Document:
    return parse(path.read_text(encoding="utf-8"), str(path))
