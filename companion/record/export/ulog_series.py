"""The vehicle's own log as series and tables beside ours."""

from __future__ import annotations

import numpy as np

from companion.record.export.channels import Series
from companion.record.export.columns import Array, as_csv
from companion.record.export.schemas import Field
from companion.record.series import is_rising
from companion.record.table import Table
from companion.record.ulog.joined import VehicleLog
from companion.record.ulog.topics import TOPICS, Column

COLUMNS: dict[str, dict[str, Column]] = {
    topic.name: {column.name: column for column in topic.columns} for topic in TOPICS
}


def our_clock(table: Table, t_boot: Array) -> Array:
    """Times of our clock, s, at stamps of the vehicle's; NaN before the first state and after the last."""
    fresh = table[table["fresh"] == 1]
    if len(fresh) < 2:
        return np.full(len(t_boot), np.nan)
    stamps = fresh["t_boot"]
    rising = is_rising(stamps)
    now = np.interp(t_boot, stamps[rising], fresh["now"][rising], left=np.nan, right=np.nan)
    return np.asarray(now, dtype=float)


def log_series(table: Table, log: VehicleLog) -> list[Series]:
    """A series a topic, while we recorded."""
    found = []
    for name, topic in log.topics.items():
        now = our_clock(table, topic.t)
        known = np.isfinite(now)
        fields = tuple(Field(*COLUMNS[name][column][1:]) for column in topic.columns)
        values = tuple(column[known] for column in topic.columns.values())
        if known.any():
            found.append(Series(f"/px4/{name}", f"companion.px4.{name}", fields, values, now[known]))
    return found


def log_tables(table: Table, log: VehicleLog) -> tuple[dict[str, bytes], list[tuple[str, str, str]]]:
    """File name -> CSV of a topic; (file, column, "unit, meaning") of each column."""
    files: dict[str, bytes] = {}
    legend: list[tuple[str, str, str]] = []
    for name, topic in log.topics.items():
        file = f"px4_{name}.csv"
        clocks = [our_clock(table, topic.t), topic.t]
        files[file] = as_csv(["now", "t_boot", *topic.columns], [*clocks, *topic.columns.values()])
        legend += [(file, "now", "s, our clock"), (file, "t_boot", "s, the vehicle's clock")]
        for column in topic.columns:
            of = COLUMNS[name][column]
            legend.append((file, column, f"{of.unit}, {of.meaning}"))
    return files, legend
