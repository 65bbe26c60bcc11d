"""A flight folder as one MCAP file that Foxglove and PlotJuggler show at once. Needs the library ``mcap`` (extra log).

Messages are JSON, their schemas say each number's unit. Times are our clock's: s since 1970 where a vehicle flew, s
since the beginning in lockstep. The truth of a simulation is brought to our clock by the states' own stamps.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from companion.flight.phases import Phase
from companion.record.export.channels import Series, series_of, thinned
from companion.record.export.columns import Array, as_numbers
from companion.record.export.csv_files import path_points
from companion.record.export.scene import (
    BODY,
    FLOWN_COLOR,
    PATH_COLOR,
    WORLD,
    line_scene,
    poses,
    stamp,
    vehicle_scene,
)
from companion.record.export.schemas import Field, series_schema, well_known
from companion.record.export.ulog_series import log_series, our_clock
from companion.record.replay import RecordedFlight
from companion.record.table import Table
from companion.record.ulog.joined import VehicleLog
from companion.vehicle import CompanionError

POSE_RATE, TRUTH_RATE = 50.0, 25.0
"""Hz of poses and of the true state: what a screen shows (engineering choice)."""
FLOWN_RATE = 5.0
"""Hz of the points of the line that was flown."""
INFO = 2
"""Of foxglove.Log.level."""


class Message(NamedTuple):
    """``t``: ns. ``channel``: its place among the channels."""

    t: int
    channel: int
    data: bytes


class Channel(NamedTuple):
    """``topic``, ``schema`` by name and text, and its messages: (ns, JSON)."""

    topic: str
    schema: str
    text: bytes
    messages: list[tuple[int, bytes]]


class FolderContext(NamedTuple):
    """What stands beside the table in a flight folder. ``epoch``: s since 1970 when our clock read zero. ``notes``: s
    since 1970, and the line. ``about``: what the file is about, as words."""

    epoch: float
    notes: Sequence[tuple[float, str]]
    about: dict[str, str]


def write_mcap(file: Path, flight: RecordedFlight, context: FolderContext, log: VehicleLog | None = None) -> int:
    """Write it, with the vehicle's own ``log`` where it was joined; how many messages it has. CompanionError: the
    library is missing. OSError: it cannot be written."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise CompanionError(
            "no MCAP file: the library mcap is missing; pip install 'px4-path-companion[log]', or take --csv"
        ) from None
    channels = [*_poses(flight.table, context.epoch), *_scenes(flight, context.epoch), *_truth(flight, context.epoch)]
    channels += [_numbers(series, context.epoch) for series in series_of(flight.table)]
    if log is not None:
        channels += [_numbers(series, context.epoch) for series in log_series(flight.table, log)]
    channels.append(_notes(context))
    order = [Message(t, i, data) for i, channel in enumerate(channels) for t, data in channel.messages]
    order.sort(key=itemgetter(0))
    with file.open("wb") as out:
        writer = Writer(out)
        writer.start(profile="", library="companion")
        ids = [
            writer.register_channel(c.topic, "json", writer.register_schema(c.schema, "jsonschema", c.text))
            for c in channels
        ]
        for t, i, data in order:
            writer.add_message(ids[i], t, data, t)
        phases = {str(index): phase.value for index, phase in enumerate(Phase)}
        writer.add_metadata("phases", phases)
        writer.add_metadata("flight", context.about)
        writer.finish()  # type: ignore[no-untyped-call]
    return len(order)


def _nanoseconds(t: Array, epoch: float) -> list[int]:
    # in two steps: seconds since 1970 have no nanoseconds in 53 bits
    whole = round(epoch * 1e6) * 1000
    return [max(0, whole + nanoseconds) for nanoseconds in np.round(t * 1e9).astype(np.int64).tolist()]


def _numbers(series: Series, epoch: float) -> Channel:
    times = _nanoseconds(series.t, epoch)
    keys = "".join(f',"{field.name}":%s' for field in series.fields)
    template = f'{{"timestamp":%s{keys}}}'
    columns = [as_numbers(np.asarray(values), "null") for values in series.values]
    data = [(template % row).encode() for row in zip(map(stamp, times), *columns, strict=True)]
    text = series_schema(series.schema, series.fields)
    return Channel(series.topic, series.schema, text, list(zip(times, data, strict=True)))


def _places(rows: Table) -> tuple[Array, Array]:
    points = np.column_stack([rows[name] for name in ("north", "east", "down")])
    return points, np.column_stack([rows[f"q_{axis}"] for axis in "wxyz"])


def _poses(table: Table, epoch: float) -> list[Channel]:
    fresh = table[table["fresh"] == 1]
    rows = fresh[thinned(fresh["now"], POSE_RATE)]
    points, quaternions = _places(rows)
    return _moving("/vehicle/pose", points, quaternions, _nanoseconds(rows["now"], epoch), BODY)


def _moving(topic: str, points: Array, quaternions: Array, times: list[int], frame: str | None) -> list[Channel]:
    """A pose over time; with ``frame``, what hangs on that frame moves with it."""
    bodies = poses(points, quaternions)
    stamps = list(map(stamp, times))
    name = "foxglove.PoseInFrame"
    data = [
        f'{{"timestamp":{at},"frame_id":"{WORLD}","pose":{{{body}}}}}'.encode()
        for at, body in zip(stamps, bodies, strict=True)
    ]
    found = [Channel(topic, name, well_known(name), list(zip(times, data, strict=True)))]
    if frame is not None:
        name = "foxglove.FrameTransform"
        data = [
            (
                f'{{"timestamp":{at},"parent_frame_id":"{WORLD}","child_frame_id":"{frame}",'
                + body.replace('"position"', '"translation"').replace('"orientation"', '"rotation"')
                + "}"
            ).encode()
            for at, body in zip(stamps, bodies, strict=True)
        ]
        found.append(Channel("/tf", name, well_known(name), list(zip(times, data, strict=True))))
    return found


def _scenes(flight: RecordedFlight, epoch: float) -> list[Channel]:
    fresh = flight.table[flight.table["fresh"] == 1]
    first = fresh["now"][:1] if len(fresh) else np.array([flight.begun_at])
    (at,) = _nanoseconds(first, epoch)
    _, points = path_points(flight.plan)
    flown, _ = _places(fresh[thinned(fresh["now"], FLOWN_RATE)])
    level = np.tile((1.0, 0.0, 0.0, 0.0), (len(points), 1))
    along = ",".join(f"{{{pose}}}" for pose in poses(points, level))
    scene, line = "foxglove.SceneUpdate", "foxglove.PosesInFrame"
    whole = f'{{"timestamp":{stamp(at)},"frame_id":"{WORLD}","poses":[{along}]}}'.encode()
    return [
        Channel("/path", line, well_known(line), [(at, whole)]),
        Channel(
            "/scene",
            scene,
            well_known(scene),
            [
                (at, line_scene("path", points, PATH_COLOR, at)),
                (at, line_scene("flown", flown, FLOWN_COLOR, at)),
                (at, vehicle_scene(at)),
            ],
        ),
    ]


def _truth(flight: RecordedFlight, epoch: float) -> list[Channel]:
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
    messages = []
    for seconds, line in context.notes:
        at = max(0, round(seconds * 1e6) * 1000)
        entry = {"timestamp": json.loads(stamp(at)), "level": INFO, "message": line, "name": "companion"}
        messages.append((at, json.dumps({**entry, "file": "", "line": 0}).encode()))
    return Channel("/notes", name, well_known(name), messages)
