"""A flight folder as CSV: one file a table with the names of its columns, and a legend with their units.

``flight.csv`` and ``truth.csv`` have the columns of flight.npy and truth.npy in their order (a column of several
numbers is numbered from 0); ``path.csv`` the path in the vehicle's local frame; ``columns.csv`` says unit and meaning
of each; ``px4_TOPIC.csv`` what the vehicle logged itself, where that was joined. Empty: not said, or not measured.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from companion.plan import Plan
from companion.record import rows
from companion.record.export.columns import CLOCK_DECIMALS, Array, as_numbers, unit_of
from companion.record.export.ulog_series import log_tables
from companion.record.replay import RecordedFlight
from companion.record.table import Table
from companion.record.ulog.joined import VehicleLog

CLOCKS = frozenset({"now", "t_boot"})
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


def csv_files(flight: RecordedFlight, log: VehicleLog | None = None) -> dict[str, str]:
    """File name -> content. ``log``: the vehicle's own, joined."""
    meanings = {column.name: column.meaning for column in rows.COLUMNS}
    files = {"flight.csv": _table(flight.table), "path.csv": _path(flight.plan)}
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


def path_points(plan: Plan, count: int = PATH_POINTS) -> tuple[Array, Array]:
    """Arc length (count,) m and place (count, 3) m north, east, down of points along the mission's path."""
    s, points = plan.table.samples(count)[:2]
    return np.asarray(s, dtype=float), np.asarray(points, dtype=float)


def _table(table: Table) -> str:
    columns = list(_columns(table))
    lines = [",".join(name for name, _ in columns)]
    lines += map(",".join, zip(*(values for _, values in columns), strict=True))
    return "\n".join(lines) + "\n"


def _columns(table: Table) -> Iterator[tuple[str, list[str]]]:
    for name in table.dtype.names or ():
        values: NDArray[np.float64] = table[name]
        if values.ndim == 1:
            yield name, as_numbers(values, "", CLOCK_DECIMALS if name in CLOCKS else None)
        else:
            for index in range(values.shape[1]):
                yield f"{name}_{index}", as_numbers(values[:, index], "")


def _path(plan: Plan) -> str:
    s, points = path_points(plan)
    numbers = [as_numbers(column, "") for column in (s, *points.T)]
    return "\n".join([",".join(PATH), *map(",".join, zip(*numbers, strict=True))]) + "\n"


def _legend(legend: list[tuple[str, str, str]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("file", "column", "unit", "meaning"))
    writer.writerows((file, name, unit_of(meaning), meaning) for file, name, meaning in legend)
    return out.getvalue()
