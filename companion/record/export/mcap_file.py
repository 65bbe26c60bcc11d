"""A flight folder as one MCAP file that Foxglove and PlotJuggler show at once. Needs the library ``mcap`` (extra log).

Messages are JSON, their schemas say each number's unit. Times are our clock's: s since 1970 where a vehicle flew, s
since the beginning in lockstep. The truth of a simulation is brought to our clock by the states' own stamps.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.flight.phases import Phase
from companion.record.export.channels import Channel, Series, series_of, thinned
from companion.record.export.columns import Array, Numbers, as_lines
from companion.record.export.csv_files import path_points
from companion.record.export.scene import (
    BODY,
    FLOWN_COLOR,
    PATH_COLOR,
    WORLD,
    line_scene,
    pose_columns,
    pose_parts,
    stamp,
    vehicle_scene,
)
from companion.record.export.schemas import Field, series_schema, well_known
from companion.record.export.ulog_series import log_series, our_clock
from companion.record.recorded import FlightFolder
from companion.record.table import Table
from companion.record.ulog.joined import VehicleLog
from companion.vehicle import CompanionError

POSE_RATE, TRUTH_RATE = 50.0, 25.0
"""Hz of poses and of the true state: what a screen shows (engineering choice)."""
FLOWN_RATE = 5.0
"""Hz of the points of the line that was flown."""
Times = NDArray[np.int64]
"""ns."""
INFO = 2
"""Of foxglove.Log.level."""


class FolderContext(NamedTuple):
    """What stands beside the table in a flight folder. ``epoch``: s since 1970 when our clock read zero. ``notes``: s
    since 1970, and the line. ``about``: what the file is about, as words."""

    epoch: float
    notes: Sequence[tuple[float, str]]
    about: dict[str, str]


def write_mcap(file: Path, flight: FlightFolder, context: FolderContext, log: VehicleLog | None = None) -> int:
    """Write it, with the vehicle's own ``log`` where it was joined; how many messages it has. CompanionError: the
    library is missing. OSError: it cannot be written."""
    try:
        from companion.record.export.mcap_writer import write_channels
    except ImportError:
        raise CompanionError(
            "no MCAP file: the library mcap is missing; pip install 'px4-path-companion[log]', or take --csv"
        ) from None
    channels = [*_poses(flight.table, context.epoch), *_scenes(flight, context.epoch), *_truth(flight, context.epoch)]
    channels += [_numbers(series, context.epoch) for series in series_of(flight.table)]
    if log is not None:
        channels += [_numbers(series, context.epoch) for series in log_series(flight.table, log)]
    channels.append(_notes(context))
    phases = {str(index): phase.value for index, phase in enumerate(Phase)}
    with file.open("wb") as out:
        return write_channels(out, channels, {"phases": phases, "flight": context.about})


def _nanoseconds(t: Array, epoch: float) -> Times:
    # in two steps: seconds since 1970 have no nanoseconds in 53 bits
    whole = round(epoch * 1e6) * 1000
    return np.maximum(0, whole + np.round(t * 1e9).astype(np.int64))


def _stamped(between: Sequence[str], times: Times, columns: Sequence[Numbers], missing: str) -> list[bytes]:
    """JSON that begins with its time; ``between``: what stands before each number, and at the end."""
    parts = ['{"timestamp":{"sec":', ',"nsec":', "}" + between[0], *between[1:]]
    return as_lines(parts, [*np.divmod(times, 1_000_000_000), *columns], missing)


def _numbers(series: Series, epoch: float) -> Channel:
    times = _nanoseconds(series.t, epoch)
    between = [f',"{field.name}":' for field in series.fields] + ["}"]
    text = series_schema(series.schema, series.fields)
    return Channel(series.topic, series.schema, text, times, _stamped(between, times, series.values, "null"))


def _places(rows: Table) -> tuple[Array, Array]:
    points = np.column_stack([rows[name] for name in ("north", "east", "down")])
    return points, np.column_stack([rows[f"q_{axis}"] for axis in "wxyz"])


def _poses(table: Table, epoch: float) -> list[Channel]:
    fresh = table[table["fresh"] == 1]
    rows = fresh[thinned(fresh["now"], POSE_RATE)]
    points, quaternions = _places(rows)
    return _moving("/vehicle/pose", points, quaternions, _nanoseconds(rows["now"], epoch), BODY)


def _moving(topic: str, points: Array, quaternions: Array, times: Times, frame: str | None) -> list[Channel]:
    """A pose over time; with ``frame``, what hangs on that frame moves with it."""
    columns = pose_columns(points, quaternions)
    name = "foxglove.PoseInFrame"
    between = pose_parts("position", "orientation", f',"frame_id":"{WORLD}","pose":{{', "}}")
    found = [Channel(topic, name, well_known(name), times, _stamped(between, times, columns, "0"))]
    if frame is not None:
        name = "foxglove.FrameTransform"
        frames = f',"parent_frame_id":"{WORLD}","child_frame_id":"{frame}",'
        between = pose_parts("translation", "rotation", frames, "}")
        found.append(Channel("/tf", name, well_known(name), times, _stamped(between, times, columns, "0")))
    return found


def _scenes(flight: FlightFolder, epoch: float) -> list[Channel]:
    fresh = flight.table[flight.table["fresh"] == 1]
    first = fresh["now"][:1] if len(fresh) else np.array([flight.begun_at])
    times = _nanoseconds(first, epoch)
    at = int(times[0])
    _, points = path_points(flight.path)
    flown, _ = _places(fresh[thinned(fresh["now"], FLOWN_RATE)])
    level = np.tile((1.0, 0.0, 0.0, 0.0), (len(points), 1))
    along = b",".join(as_lines(pose_parts("position", "orientation", "{", "}"), pose_columns(points, level), "0"))
    scene, line = "foxglove.SceneUpdate", "foxglove.PosesInFrame"
    whole = f'{{"timestamp":{stamp(at)},"frame_id":"{WORLD}","poses":['.encode() + along + b"]}"
    drawn = [
        line_scene("path", points, PATH_COLOR, at),
        line_scene("flown", flown, FLOWN_COLOR, at),
        vehicle_scene(at),
    ]
    return [
        Channel("/path", line, well_known(line), times, [whole]),
        Channel("/scene", scene, well_known(scene), np.repeat(times, len(drawn)), drawn),
    ]


def _truth(flight: FlightFolder, epoch: float) -> list[Channel]:
    """The plant's true pose and motion."""
    fresh = flight.table[flight.table["fresh"] == 1]
    if flight.truth is None or len(fresh) < 2:
        return []
    now = our_clock(flight.table, flight.truth["t_boot"])
    known = np.isfinite(now)
    rows, t = flight.truth[known], now[known]
    shown = thinned(rows["t_boot"], TRUTH_RATE)
    rows, t = rows[shown], t[shown]
    fields: list[Field] = []
    values: list[Array] = []
    for column, unit, meaning in (("p_n", "m", "north, east, down"), ("v_n", "m/s", "north, east, down"),
                                  ("rotor_thrusts", "N", "of a rotor")):  # fmt: skip
        for i in range(rows[column].shape[1]):
            fields.append(Field(f"{column}_{i}", unit, f"true, {meaning}"))
            values.append(rows[column][:, i])
    motion = Series("/truth/state", "companion.Truth", tuple(fields), tuple(values), t)
    moving = _moving("/truth/pose", rows["p_n"], rows["q_nb"], _nanoseconds(t, epoch), None)
    return [*moving, _numbers(motion, epoch)]


def _notes(context: FolderContext) -> Channel:
    name = "foxglove.Log"
    times = [max(0, round(seconds * 1e6) * 1000) for seconds, _ in context.notes]
    who = {"level": INFO, "name": "companion", "file": "", "line": 0}
    data = [
        json.dumps({"timestamp": json.loads(stamp(at)), **who, "message": line}).encode()
        for at, (_, line) in zip(times, context.notes, strict=True)
    ]
    return Channel("/notes", name, well_known(name), np.array(times, dtype=np.int64), data)
