"""A flight folder as CSV: one file a table with the names of its columns, and a legend with their units.

``flight.csv`` and ``truth.csv`` have the columns of flight.npy and truth.npy in their order (a column of several
numbers is numbered from 0); ``path.csv`` the path in the vehicle's local frame; ``columns.csv`` says unit and meaning
of each; ``px4_TOPIC.csv`` what the vehicle logged itself, where that was joined. Empty: not said, or not measured.
"""

from __future__ import annotations

import csv
import io

import numpy as np

from companion.paths.arc import ArcTable
from companion.record.export.columns import Array, Numbers, as_csv, unit_of
from companion.record.export.ulog_series import log_tables
from companion.record.recorded import FlightFolder
from companion.record.table import Table
from companion.record.tick_columns import COLUMNS
from companion.record.ulog.joined import VehicleLog

PATH_POINTS = 1000
TRUTH = {
    "t_boot": "s, the vehicle's clock",
    "p_n": "m, true position north, east, down",
    "v_n": "m/s, true velocity north, east, down",
    "q_nb": "true attitude quaternion w, x, y, z, body to world",
    "w_b": "rad/s, true body rates",
    "rotor_thrusts": "N, of each rotor",
    "commands": "of each rotor, in the vehicle file's units",
}
PATH = {"s": "m, arc length", "north": "m, local frame", "east": "m, local frame", "down": "m, local frame"}


def csv_files(flight: FlightFolder, log: VehicleLog | None = None) -> dict[str, bytes]:
    """File name -> content. ``log``: the vehicle's own, joined."""
    meanings = {column.name: column.meaning for column in COLUMNS}
    files = {"flight.csv": _table(flight.table), "path.csv": _path(flight.path)}
    legend = [("flight.csv", name, meanings.get(name, "")) for name in flight.table.dtype.names or ()]
    if flight.truth is not None:
        files["truth.csv"] = _table(flight.truth)
        legend += [("truth.csv", name, TRUTH.get(name, "")) for name in flight.truth.dtype.names or ()]
    legend += [("path.csv", name, meaning) for name, meaning in PATH.items()]
    if log is not None:
        tables, meant = log_tables(flight.table, log)
        files |= tables
        legend += meant
    files["columns.csv"] = _legend(legend)
    return files


def path_points(path: ArcTable, count: int = PATH_POINTS) -> tuple[Array, Array]:
    """Arc length (count,) m and place (count, 3) m north, east, down of points along the mission's path."""
    s, points = path.samples(count)[:2]
    return np.asarray(s, dtype=float), np.asarray(points, dtype=float)


def _table(table: Table) -> bytes:
    names: list[str] = []
    columns: list[Numbers] = []
    for name in table.dtype.names or ():
        values = table[name]
        if values.ndim == 1:
            names.append(name)
            columns.append(values)
        else:
            names += [f"{name}_{index}" for index in range(values.shape[1])]
            columns += list(values.T)
    return as_csv(names, columns)


def _path(path: ArcTable) -> bytes:
    s, points = path_points(path)
    return as_csv(list(PATH), [s, *points.T])


def _legend(legend: list[tuple[str, str, str]]) -> bytes:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("file", "column", "unit", "meaning"))
    writer.writerows((file, name, unit_of(meaning), meaning) for file, name, meaning in legend)
    return out.getvalue().encode()
