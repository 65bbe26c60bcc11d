"""A ULog on the clock of our states' stamps, and kept so beside the record."""

from __future__ import annotations

import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from companion.config.syntax.faults import ConfigError, Fault
from companion.record.series import is_rising
from companion.record.table import Table
from companion.record.ulog.clock import Alignment, alignment
from companion.record.ulog.reading import Array, LogSeries, read_ulog
from companion.record.ulog.topics import BODY_RATES

KEPT = "ulog.npz"
"""Its name in the flight folder."""
DAMAGED = (OSError, ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)
"""What numpy and zipfile raise at an archive that was cut or spoilt."""


@dataclass(frozen=True)
class VehicleLog:
    """``file``: the name of the log. ``alignment``: how its clock was found. ``topics``: PX4's name -> its series,
    times in s of ``t_boot``, the stamp of our states."""

    file: str
    alignment: Alignment
    topics: dict[str, LogSeries]


def joined(file: Path, table: Table) -> VehicleLog:
    """The log of a flight whose record is ``table``. ConfigError: it is none, or of another flight."""
    topics = read_ulog(file)
    stamps, rates = _body_rates(table)
    theirs = topics[BODY_RATES]
    found = alignment(stamps, rates, theirs.t, np.column_stack([theirs.columns[axis] for axis in "pqr"]))
    if found is None:
        message = (
            f"its body rates are not those of this flight (log: {theirs.t[0]:.1f} to {theirs.t[-1]:.1f} s after boot, "
            f"flight: {stamps[0]:.1f} to {stamps[-1]:.1f} s); expected the log of the same flight"
            if len(stamps)
            else "the flight has no state to join it by"
        )
        raise ConfigError([Fault(str(file), 0, "", message)])
    moved = {name: LogSeries(series.t + found.offset, series.columns) for name, series in topics.items()}
    return VehicleLog(file.name, found, moved)


def keep(directory: Path, log: VehicleLog) -> Path:
    """Write it into the flight folder; the file."""
    arrays: dict[str, Any] = {"log": np.array(log.file), "alignment": np.array(log.alignment)}
    for name, series in log.topics.items():
        arrays |= {f"{name}/{column}": values for column, values in {"t": series.t, **series.columns}.items()}
    path = directory / KEPT
    np.savez_compressed(path, **arrays)
    return path


def kept(directory: Path) -> VehicleLog | None:
    """What ``keep`` wrote; None where nothing is there that can be read."""
    try:
        with np.load(directory / KEPT, allow_pickle=False) as read:
            arrays = {name: read[name] for name in read.files}
        file, found = str(arrays.pop("log")), Alignment(*map(float, arrays.pop("alignment")))
    except (*DAMAGED, KeyError, TypeError):  # what is missing in it, what is no archive at all
        return None
    topics: dict[str, LogSeries] = {}
    for name, values in arrays.items():
        topic, _, column = name.partition("/")
        if column == "t":
            topics[topic] = LogSeries(values, {})
    for name, values in arrays.items():
        topic, _, column = name.partition("/")
        if column != "t" and topic in topics:
            topics[topic].columns[column] = values
    return VehicleLog(file, found, topics)


def _body_rates(table: Table) -> tuple[Array, Array]:
    """(n,) s and (n, 3) rad/s of the states that came, in the order of their stamps."""
    rows = table[table["fresh"] == 1]
    stamps = rows["t_boot"].astype(float)
    if not len(rows):
        return stamps, np.zeros((0, 3))
    rising = is_rising(stamps)
    return stamps[rising], np.column_stack([rows[axis] for axis in "pqr"]).astype(float)[rising]
