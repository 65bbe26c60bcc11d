"""A flight folder as files that other programs open: read back with the readers that those programs use."""

from __future__ import annotations

import csv
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.frames import multiply
from companion.record.export.channels import euler_deg, thinned
from companion.record.export.columns import as_csv, as_lines, unit_of
from companion.record.export.scene import enu_flu
from companion.record.table import load_table
from companion.record.tick_columns import COLUMNS


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("export") / "flown"
    words = ["sim", "circle_r5", "--output", "rates", "--duration", "3", "--settle", "1", "--no-report", "--record"]
    assert CliRunner().invoke(app, [*words, str(where)]).exit_code == 0
    done = CliRunner().invoke(app, ["export-flight", str(where), "--csv", "--mcap"])
    assert done.exit_code == 0, done.output
    return where


@pytest.fixture(scope="module")
def topics(folder: Path) -> dict[str, list[Any]]:
    """Topic -> (schema, message, JSON) of each message, read with the library's own reader, which checks every CRC."""
    found: dict[str, list[Any]] = {}
    with (folder / "flight.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None and schema.encoding == "jsonschema" and channel.message_encoding == "json"
            found.setdefault(channel.topic, []).append((schema, message, json.loads(message.data)))
    return found


def numbers(topics: dict[str, list[Any]], topic: str, field: str) -> np.ndarray[Any, Any]:
    values = [values[field] for _, _, values in topics[topic]]
    return np.array([math.nan if value is None else value for value in values], dtype=float)


def test_a_viewer_finds_poses_path_errors_setpoints_and_notes(topics: dict[str, list[Any]]) -> None:
    schemas = {topic: messages[0][0].name for topic, messages in topics.items()}
    assert schemas["/vehicle/pose"] == "foxglove.PoseInFrame"
    assert schemas["/tf"] == "foxglove.FrameTransform"
    assert schemas["/path"] == "foxglove.PosesInFrame"
    assert schemas["/scene"] == "foxglove.SceneUpdate"
    assert {"/follow", "/vehicle/state", "/setpoint/rates", "/estimates", "/link"} <= set(topics)
    assert [entity["id"] for _, _, values in topics["/scene"] for entity in values["entities"]] == [
        "path",
        "flown",
        "vehicle",
    ]


def test_every_number_has_its_unit_and_every_message_its_schema(topics: dict[str, list[Any]]) -> None:
    for messages in topics.values():
        for schema, _, values in messages[:3]:
            document = json.loads(schema.data)
            assert set(values) == set(document["properties"]), schema.name
            if schema.name.startswith("companion."):
                assert all("unit" in spec for name, spec in document["properties"].items() if name != "timestamp")


def test_the_messages_are_the_recorded_numbers_at_their_times(folder: Path, topics: dict[str, list[Any]]) -> None:
    table = load_table(folder / "flight.npy")
    epoch = json.loads((folder / "resolved.json").read_text())["epoch"]
    times = np.array([message.log_time for _, message, _ in topics["/follow"]]) * 1e-9 - epoch
    for field, column, factor in (
        ("path_error_m", "path_error", 1.0),
        ("yaw_error_deg", "yaw_error", 180.0 / math.pi),
        ("s_m", "s", 1.0),
    ):
        at = np.searchsorted(table["now"], times - 1e-6)
        assert numbers(topics, "/follow", field) == pytest.approx(table[column][at] * factor, rel=1e-8, abs=1e-9)
    stamps = [values["timestamp"] for _, _, values in topics["/follow"]]
    assert all(
        s["sec"] * 10**9 + s["nsec"] == m.log_time for s, (_, m, _) in zip(stamps, topics["/follow"], strict=True)
    )
    sent = table[table["setpoint"] == 2]
    apart = np.diff([message.log_time for _, message, _ in topics["/setpoint/rates"]]) * 1e-9
    assert len(sent) > len(topics["/setpoint/rates"]) > 0.3 * len(sent) and np.median(apart) < 0.0125


def test_a_viewer_sees_north_as_y_and_up_as_z(folder: Path, topics: dict[str, list[Any]]) -> None:
    table = load_table(folder / "flight.npy")
    fresh = table[table["fresh"] == 1]
    _, message, values = topics["/vehicle/pose"][-1]
    row = fresh[np.argmin(np.abs(fresh["now"] - message.log_time * 1e-9))]
    position = values["pose"]["position"]
    assert [position[axis] for axis in "xyz"] == pytest.approx([row["east"], row["north"], -row["down"]], rel=1e-8)
    # the last pose of the transform is the same
    assert topics["/tf"][-1][2]["translation"] == position


def test_an_attitude_is_turned_as_the_frames_are() -> None:
    q = np.random.default_rng(1).normal(size=(20, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    h = math.sqrt(0.5)
    for one, (x, y, z, w) in zip(q, enu_flu(q), strict=True):
        expected = np.array(multiply(multiply((0.0, h, h, 0.0), tuple(one)), (0.0, 1.0, 0.0, 0.0)))
        assert abs(expected @ (w, x, y, z)) == pytest.approx(1.0)
    north = enu_flu(np.array([[1.0, 0.0, 0.0, 0.0]]))[0]  # nose to the north: a quarter turn about up
    assert abs(north @ (0.0, 0.0, h, h)) == pytest.approx(1.0)
    roll, pitch, yaw = euler_deg(np.array([[math.cos(0.25), 0.0, 0.0, math.sin(0.25)]]))
    assert (roll[0], pitch[0]) == (0.0, 0.0) and yaw[0] == pytest.approx(math.degrees(0.5))


def test_the_truth_is_beside_what_was_believed(topics: dict[str, list[Any]]) -> None:
    believed = {m.log_time: values["pose"]["position"] for _, m, values in topics["/vehicle/pose"]}
    clock = np.array(sorted(believed))
    for _, message, values in topics["/truth/pose"][5:-5]:
        near = believed[clock[np.argmin(np.abs(clock - message.log_time))]]
        assert math.dist(near.values(), values["pose"]["position"].values()) < 0.1  # 3 m/s * 20 ms


def test_the_tables_are_the_recorded_columns(folder: Path) -> None:
    table = load_table(folder / "flight.npy")
    with (folder / "flight.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert len(read) == len(table) and list(read[0]) == list(table.dtype.names or ())
    for name in ("now", "north", "path_error", "phase", "sent_3", "latency"):
        values = [math.nan if row[name] == "" else float(row[name]) for row in read]
        assert values == pytest.approx(table[name].astype(float), rel=1e-8, abs=1e-6, nan_ok=True)
    with (folder / "columns.csv").open(newline="") as file:
        legend = {(row["file"], row["column"]): row["unit"] for row in csv.DictReader(file)}
    assert legend["flight.csv", "path_error"] == "m" and legend["flight.csv", "p"] == "rad/s"
    assert legend["truth.csv", "v_n"] == "m/s"
    assert (folder / "truth.csv").is_file() and (folder / "path.csv").read_text().startswith("s,north,east,down\n")


def test_units_and_numbers_as_text() -> None:
    assert {unit_of(column.meaning) for column in COLUMNS} >= {"m", "m/s", "rad", "s", "Hz", "N", ""}
    assert as_lines(["", ""], [np.array([1.5, math.nan, -math.inf])], "null") == [b"1.5", b"null", b"null"]
    assert as_lines(["", ""], [np.array([1, -1], dtype=np.int8)], "null") == [b"1", b"-1"]
    assert as_lines(["", ""], [np.array([1e9 + 0.123456])], "", frozenset({0})) == [b"1000000000.123456"]
    assert as_csv(["t_boot", "a"], [np.array([0.1, 2.0]), np.array([0.1, math.nan])]) == (
        b"t_boot,a\n0.100000,0.1\n2.000000,\n"
    )
    assert as_csv(["a", "b"], [np.zeros(0), np.zeros(0)]) == b"a,b\n"
    assert thinned(np.arange(10) * 0.004, 100.0).tolist() == [0, 3, 5, 8]
    assert thinned(np.zeros(0), 100.0).tolist() == []


def test_lines_are_the_numbers_one_by_one_however_often_a_column_changes() -> None:
    rng, rows = np.random.default_rng(2), 200
    seldom = np.repeat(rng.normal(size=4), rows // 4)
    columns: list[np.ndarray[Any, Any]] = [
        rng.normal(size=rows) * 10.0 ** rng.integers(-12, 12, size=rows),
        seldom,
        np.full(rows, math.nan),
        np.repeat(np.array([1, -1], dtype=np.int8), rows // 2),
        np.where(rng.random(rows) < 0.3, math.inf, rng.normal(size=rows)).astype(np.float32),
        np.arange(rows),
        np.where(np.arange(rows) < 5, math.nan, 7.0),
    ]
    for order in (columns, columns[1:], columns[::-1], columns[1:4]):
        parts = [f"%{i}:" for i in range(len(order) + 1)]
        for clocks in (frozenset[int](), frozenset({0})):
            expected = [
                "".join(
                    part + ("null" if not np.isfinite(value) else str(value) if column.dtype.kind == "i"
                            else format(value, ".6f" if i in clocks else ".9g"))
                    for i, (part, column, value) in enumerate(zip(parts, order, row, strict=False))
                ) + parts[-1]
                for row in zip(*(column.tolist() for column in order), strict=True)
            ]  # fmt: skip
            assert [line.decode() for line in as_lines(parts, order, "null", clocks)] == expected


def test_a_viewer_finds_messages_by_time_and_topic(
    folder: Path, topics: dict[str, list[Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the index of the file, which a viewer reads first; and without it, from the beginning on."""
    monkeypatch.setattr("companion.record.export.mcap_writer.CHUNK_SIZE", 50_000)
    assert CliRunner().invoke(app, ["export-flight", str(folder), "--mcap", "--to", str(tmp_path)]).exit_code == 0
    with (tmp_path / "flight.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None and len(summary.chunk_indexes) > 10
        counts = {summary.channels[i].topic: n for i, n in summary.statistics.channel_message_counts.items()}
        assert counts == {topic: len(messages) for topic, messages in topics.items()}
        of = [message.log_time for _, message, _ in topics["/follow"]]
        asked = reader.iter_messages(topics=["/follow"], starting_at=of[20], ending_before=of[40])
        assert [message.log_time for _, _, message in asked] == of[20:40]
        times = [message.log_time for _, _, message in reader.iter_messages(log_time_order=False)]
        assert times == sorted(times)
        assert {one.name for one in reader.iter_metadata()} == {"phases", "flight"}
    with (tmp_path / "flight.mcap").open("rb") as file:
        kinds = [type(record).__name__ for record in StreamReader(file, validate_crcs=True).records]
    assert kinds[0] == "Header" and kinds[-1] == "Footer" and kinds.count("Message") == len(times)


def test_an_export_waits_for_nothing_that_only_a_flight_needs() -> None:
    """Their import took half of an export's time."""
    words = "import sys; import companion.cli.export_flight, companion.record.export.mcap_file; "
    words += "import companion.record.export.csv_files, companion.record.recorded; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", words], check=True, capture_output=True, text=True).stdout.split()
    assert not {"companion.pilot", "companion.steering", "companion.mavlink.codec", "scipy"} & set(loaded)


def test_what_is_there_is_kept_and_what_is_no_flight_is_named(folder: Path, tmp_path: Path) -> None:
    again = CliRunner().invoke(app, ["export-flight", str(folder), "--mcap"])
    assert "exists already; --force writes over it" in str(again.exception)
    nothing = CliRunner().invoke(app, ["export-flight", str(folder)])
    assert "expected --csv, --mcap or --ulog-join" in str(nothing.exception)
    none = CliRunner().invoke(app, ["export-flight", str(tmp_path), "--csv"])
    assert "expected a flight folder" in str(none.exception)
    assert CliRunner().invoke(app, ["export-flight", str(folder), "--csv", "--to", str(tmp_path)]).exit_code == 0
    assert (tmp_path / "flight.csv").read_text() == (folder / "flight.csv").read_text()


def test_a_record_cut_anywhere_is_exported_to_its_cut(folder: Path, tmp_path: Path) -> None:
    for name in ("resolved.json", "mission.yaml", "vehicle.yaml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    whole = (folder / "flight.npy").read_bytes()
    (tmp_path / "flight.npy").write_bytes(whole[: len(whole) * 2 // 3])
    assert CliRunner().invoke(app, ["export-flight", str(tmp_path), "--mcap"]).exit_code == 0
    with (tmp_path / "flight.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary is not None and summary.statistics is not None and summary.statistics.message_count > 100
    # nothing but the header is left
    (tmp_path / "flight.npy").write_bytes(whole[:100])
    assert CliRunner().invoke(app, ["export-flight", str(tmp_path), "--mcap", "--force"]).exit_code == 0
