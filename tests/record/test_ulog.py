"""The vehicle's own log beside ours: the clocks found to 10 ms, the curves in every export, faults in one line."""

from __future__ import annotations

import csv
import json
import random
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.config.syntax.faults import ConfigError
from companion.record.table import Table, load_table
from companion.record.ulog.clock import Alignment, alignment
from companion.record.ulog.joined import VehicleLog, joined, keep, kept
from companion.record.ulog.reading import LogSeries, read_ulog
from companion.record.ulog.topics import BODY_RATES
from sim_bridge.autopilot.logger.logger import LOGGED
from sim_bridge.autopilot.logger.ulog import ULogFile

pytest.importorskip("pyulog", reason="the extra ulog is not installed")

DATA = Path(__file__).parents[1] / "data"
SHIFT = 37.123
"""s by which the log's clock is ahead."""


def logged(table: Table, shift: float, noise: float = 0.0) -> bytes:
    """A log of a recorded flight as PX4 would have written it: 50 Hz of body rates, its own noise."""
    rng = np.random.default_rng(1)
    file = ULogFile([each.topic for each in LOGGED], 0, {"sys_name": "PX4"})
    rows = table[table["fresh"] == 1]
    due = -1.0
    for row in rows:
        if row["t_boot"] >= due:
            due = row["t_boot"] + 0.02
            at = round(1e6 * (row["t_boot"] + shift))
            file.write(0, at + 300, at, *(np.array([row[axis] for axis in "pqr"]) + noise * rng.normal(size=3)))
            file.write(1, at, *(row[f"sent_{i}"] for i in range(3)), 0.0, 0.0, -row["sent_3"])
            file.write(2, at, at, *(row[f"q_{axis}"] for axis in "wxyz"))
            place = (row[name] for name in ("north", "east", "down", "v_north", "v_east", "v_down", "yaw"))
            file.write(4, at, at, *place)
            file.write(5, at, at, 0.5, 0.5, 0.5, 0.5, *(np.nan,) * 8)
    return bytes(file.data)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("ulog") / "flown"
    words = ["sim", "figure8", "--output", "rates", "--duration", "8", "--settle", "1", "--no-report", "--record"]
    assert CliRunner().invoke(app, [*words, str(where)]).exit_code == 0
    (where / "own.ulg").write_bytes(logged(load_table(where / "flight.npy"), SHIFT, 0.02))
    return where


def test_the_clocks_are_found_to_10_ms(folder: Path) -> None:
    log = joined(folder / "own.ulg", load_table(folder / "flight.npy"))
    assert log.alignment.offset == pytest.approx(-SHIFT, abs=0.003)
    assert log.alignment.correlation > 0.95


@pytest.mark.parametrize("shift", [0.0, 12.345])
def test_a_log_of_px4_itself_is_joined_to_10_ms(shift: float) -> None:
    """14 s of PX4's own simulation on the way to and along a figure of eight, and the states that reached us meanwhile
    (every second one). Their places are the log's own, so that every millisecond of an error shows."""
    log = read_ulog(DATA / "px4_flight.ulg")
    with np.load(DATA / "px4_flight.npz") as received:
        ours = {name: received[name].astype(float) for name in received.files}
    rates, place = log["vehicle_angular_velocity"], log["vehicle_local_position"]
    stamps = ours["t_boot"] + shift
    found = alignment(
        stamps, np.column_stack([ours[axis] for axis in "pqr"]), rates.t, np.column_stack([rates.columns[a] for a in "pqr"])
    )  # fmt: skip
    assert found is not None and found.offset == pytest.approx(shift, abs=0.003) and found.correlation > 0.95
    t = place.t + found.offset
    within = (t > stamps[0]) & (t < stamps[-1])
    assert within.sum() > 200
    for name in ("north", "east", "down"):
        apart = place.columns[name][within] - np.interp(t[within], stamps, ours[name])
        assert np.abs(apart).max() < 0.02  # 2 m/s for 10 ms
    assert set(log) >= {"vehicle_attitude", "vehicle_rates_setpoint", "actuator_motors"}


def test_a_lap_like_another_is_taken_by_the_same_clock() -> None:
    t = np.arange(0.0, 60.0, 0.01)
    lap = np.column_stack([np.sin(t), np.cos(t), 0.3 * np.sin(2.0 * t)])
    noise = 0.05 * np.random.default_rng(2).normal(size=lap.shape)
    found = alignment(t[500:], (lap + noise)[500:], t[2000:4000], lap[2000:4000])
    assert found is not None and abs(found.offset) < 0.01


def test_another_flight_and_too_little_are_refused() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 30.0, 0.02)
    smooth = np.cumsum(rng.normal(size=(2, len(t), 3)), axis=1)
    assert alignment(t, np.diff(smooth[0], axis=0, prepend=0.0), t, np.diff(smooth[1], axis=0, prepend=0.0)) is None
    assert alignment(t, smooth[0], t[:100], smooth[0][:100]) is None


def test_every_export_has_the_vehicles_curves(folder: Path) -> None:
    ran = CliRunner().invoke(app, ["export-flight", str(folder), "--ulog-join", str(folder / "own.ulg")])
    assert ran.exit_code == 0 and "clocks -3712" in ran.output
    assert 'id="figure-px4-setpoints"' in (folder / "report.html").read_text()
    assert kept(folder) is not None
    assert CliRunner().invoke(app, ["export-flight", str(folder), "--csv", "--mcap"]).exit_code == 0
    table = load_table(folder / "flight.npy")
    with (folder / "px4_vehicle_local_position.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["now"]]
    now, north = (np.array([float(row[name]) for row in rows]) for name in ("now", "north"))
    fresh = table[table["fresh"] == 1]
    assert north == pytest.approx(np.interp(now, fresh["now"], fresh["north"]), abs=0.03)  # 3 m/s * 10 ms
    with (folder / "flight.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages(["/px4/actuator_motors"]):
            assert schema is not None and channel.topic == "/px4/actuator_motors"
            assert json.loads(schema.data)["properties"]["motor_0"]["unit"] == "1"
            assert json.loads(message.data)["motor_0"] == 0.5
            break
        else:
            pytest.fail("no message")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no ULog"),
        (b"not a log at all", "no ULog"),
        (None, "cannot be read"),
        (ULogFile([each.topic for each in LOGGED], 0, {}).data, "vehicle_angular_velocity"),
    ],
)
def test_what_is_no_log_of_a_flight_is_said_in_one_line(
    folder: Path, tmp_path: Path, content: bytes | None, said: str
) -> None:
    file = tmp_path / "x.ulg"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ConfigError, match=said) as caught:
        joined(file, load_table(folder / "flight.npy"))
    assert "\n" not in str(caught.value)


def test_a_kept_log_that_is_spoilt_is_none_at_all(tmp_path: Path) -> None:
    """Cut, or with bytes that another disk wrote, wherever: read or not there, nothing raised."""
    series = LogSeries(np.arange(50.0), {"p": np.sin(np.arange(50.0))})
    file = keep(tmp_path, VehicleLog("x.ulg", Alignment(0.0, 1.0, 5.0), {BODY_RATES: series}))
    whole, rng = file.read_bytes(), random.Random(1)
    assert kept(tmp_path) is not None
    for end in range(0, len(whole), 50):
        file.write_bytes(whole[:end])
        assert kept(tmp_path) is None
    for _ in range(300):
        spoilt = bytearray(whole)
        for _ in range(2):
            spoilt[rng.randrange(len(whole))] = rng.randrange(256)
        file.write_bytes(spoilt)
        kept(tmp_path)
    file.unlink()
    np.save(tmp_path / "one.npy", series.t)
    (tmp_path / "one.npy").rename(file)
    assert kept(tmp_path) is None


def test_a_log_cut_anywhere_is_read_to_its_cut_or_refused(folder: Path, tmp_path: Path) -> None:
    whole, table = (folder / "own.ulg").read_bytes(), load_table(folder / "flight.npy")
    for part in (0.2, 0.6, 0.9):
        file = tmp_path / "cut.ulg"
        file.write_bytes(whole[: int(part * len(whole))])
        try:
            assert joined(file, table).alignment.offset == pytest.approx(-SHIFT, abs=0.01)
        except ConfigError:
            assert part < 0.5
