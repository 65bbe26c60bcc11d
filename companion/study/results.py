"""The results of a study: one line a flight, appended as it lands; whole as CSV and Parquet.

study.yaml       the study as it was
files.json       the files it flies, as they were, for a replay
rows.jsonl       one JSON line a flight, in the order of landing; a kill costs at most the line that is being written
results.csv      the same in the order of the flights, written when the study ends or is asked for its report
results.parquet  the same, where pyarrow is there
"""

from __future__ import annotations

import csv
import fcntl
import io
import json
import os
import re
import time
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

from companion.config.syntax.faults import ConfigError, Fault
from companion.record.files import write_whole
from companion.study.reading import Study
from companion.study.stored import files_text, study_with

Row = dict[str, Any]
LAST = ("version", "wall_s")
"""Columns that stand at the end; wall times are the only ones that differ from run to run."""


class Results:
    """The folder of a study that is run. One writer at a time. ``rows``: of every flight so far, by its number."""

    def __init__(self, directory: Path, study: Study, resume: bool) -> None:
        self.directory = directory
        directory.mkdir(parents=True, exist_ok=True)
        log = directory / "rows.jsonl"
        if not resume and any(directory.iterdir()):
            raise _fault(directory, "is not empty; expected a new or an empty folder, or --resume")
        if resume and (directory / "study.yaml").is_file():
            if (directory / "study.yaml").read_text(encoding="utf-8") != study.text:
                raise _fault(
                    directory, "holds another study, or its file has changed since; expected the same to go on"
                )
        else:
            write_whole(directory / "study.yaml", study.text)
            write_whole(directory / "files.json", files_text(study))
        self._file: IO[bytes] = log.open("ab")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise _fault(directory, "is being written by another companion") from None
        self.rows, whole = _read(log)
        self._file.truncate(whole)  # a line that was cut by a kill is flown again

    def add(self, row: Row) -> bool:
        """Keep a flight, on the disk; False: it is there already."""
        if row["index"] in self.rows:
            return False
        self._file.write((json.dumps(row) + "\n").encode())
        self._file.flush()
        os.fsync(self._file.fileno())
        self.rows[row["index"]] = row
        return True

    def close(self) -> None:
        """Write the tables."""
        self._file.close()
        write_tables(self.directory, self.rows.values())


def load_rows(directory: Path) -> list[Row]:
    """The flights of a study so far, in their order. ConfigError: it is no folder of a study."""
    log = directory / "rows.jsonl"
    if not log.is_file():
        raise ConfigError([Fault(str(directory), 0, "", "no rows.jsonl in it; expected the folder of a study")])
    rows, _ = _read(log)
    return [rows[index] for index in sorted(rows)]


def load_run_study(directory: Path) -> Study:
    """The study that was run in a folder, of the files as they were then. ConfigError: it is no folder of a study."""
    try:
        text = (directory / "study.yaml").read_text(encoding="utf-8")
        return study_with(text, (directory / "files.json").read_text(encoding="utf-8"))
    except (OSError, ValueError, KeyError, TypeError) as error:
        message = f"its study.yaml and files.json cannot be read ({error}); expected the folder of a study that was run"
        raise ConfigError([Fault(str(directory), 0, "", message)]) from None


def new_study_directory(name: str) -> Path:
    """studies/DATE-TIME-NAME, not taken yet."""
    stem = Path("studies") / f"{time.strftime('%Y%m%d-%H%M%S')}-{_slug(name)}"
    candidate, number = stem, 2
    while candidate.exists():
        candidate, number = stem.with_name(f"{stem.name}-{number}"), number + 1
    return candidate


def last_study_directory(name: str) -> Path | None:
    """The newest folder of a study of this name; None where there is none."""
    found = sorted(Path("studies").glob(f"????????-??????-{_slug(name)}*"))
    return found[-1] if found else None


def write_tables(directory: Path, rows: Iterable[Row]) -> None:
    """results.csv and, where pyarrow is there, results.parquet: the same flights give the same files, wall times
    apart."""
    ordered = sorted(rows, key=lambda row: int(row["index"]))
    names = list(dict.fromkeys(name for row in ordered for name in row if name not in LAST))
    names += [name for name in LAST if any(name in row for row in ordered)]
    out = io.StringIO()
    writer = csv.DictWriter(out, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(ordered)
    write_whole(directory / "results.csv", out.getvalue())
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return
    columns = {name: _column([row.get(name) for row in ordered]) for name in names}
    parquet.write_table(pyarrow.table(columns), directory / "results.parquet")


def _column(values: list[Any]) -> list[Any]:
    """Of one type: what is a list, or of several types, as JSON."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float}:
        return [None if value is None else float(value) for value in values] if float in kinds else values
    if len(kinds) == 1 and kinds <= {bool, str}:
        return values
    return [None if value is None else json.dumps(value) for value in values]


def _read(log: Path) -> tuple[dict[int, Row], int]:
    """The rows by their numbers, and how many bytes of whole lines there are."""
    rows: dict[int, Row] = {}
    whole = 0
    with log.open("rb") as file:
        for line in file:
            try:
                row = json.loads(line) if line.endswith(b"\n") else None
            except ValueError:
                row = None
            if row is None:
                break
            rows.setdefault(int(row["index"]), row)
            whole += len(line)
    return rows, whole


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower())[:60].strip("-") or "study"


def _fault(directory: Path, complaint: str) -> ConfigError:
    return ConfigError([Fault("--record", 0, "", f"{directory} {complaint}")])
