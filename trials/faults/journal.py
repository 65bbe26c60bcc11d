"""What was flown already, line by line in a file, so that a long run goes on where it was ended."""

from __future__ import annotations

import json
from pathlib import Path

from companion.vehicle import OutputLevel
from trials.faults.case import Case
from trials.faults.table import Row


class Journal:
    """The rows that were flown at a commit; those of another one are dropped. ``rows``: in the order of flying."""

    def __init__(self, file: Path, commit: str) -> None:
        self.commit = commit
        self.rows: list[Row] = []
        self._file = file
        lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
        if lines[:1] == [json.dumps(commit)]:
            self.rows = [_row(line) for line in lines[1:]]
        else:
            file.parent.mkdir(exist_ok=True)
            file.write_text(json.dumps(commit) + "\n", encoding="utf-8")
        self._flown = {(row.name, row.level, row.udp) for row in self.rows}

    def has(self, flight: tuple[Case, OutputLevel], *, udp: bool = False) -> bool:
        """Whether it was flown."""
        case, level = flight
        return (case.name, level, udp) in self._flown

    def add(self, row: Row) -> None:
        """One more."""
        self.rows.append(row)
        self._flown.add((row.name, row.level, row.udp))
        with self._file.open("a", encoding="utf-8") as out:
            out.write(json.dumps({**row._asdict(), "level": row.level.value}) + "\n")


def _row(line: str) -> Row:
    values = json.loads(line)
    return Row(**{**values, "level": OutputLevel(values["level"]), "wrong": tuple(values["wrong"])})
