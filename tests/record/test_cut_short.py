"""Files that end before their flight did: cut anywhere, full disks, holes that a power cut left. Read up to there."""

from __future__ import annotations

import errno
import math
import os
import random
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.config.syntax.faults import ConfigError
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.record import growing
from companion.record.files import write_new, write_whole
from companion.record.growing import GrowingFile
from companion.record.replay import load_flight, replay
from companion.record.report.evidence import read_evidence
from companion.record.report.page import page_text
from companion.record.table import Column, TableWriter, read_table
from companion.record.tlog import TlogWriter, records
from tests.support.flights import flight

COLUMNS = (Column("now", "d", "s"), Column("x", "f", "m"), Column("n", "b", "a count"))


class Disk:
    """A disk with so much room: pwrite takes what fits of a piece, and then has no space left on the device."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, room: int) -> None:
        self.room = room
        self._pwrite = os.pwrite
        monkeypatch.setattr(growing.os, "pwrite", self.pwrite)

    def pwrite(self, descriptor: int, data: bytes, at: int) -> int:
        fits = data[: max(0, self.room - at)]
        if not fits:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self._pwrite(descriptor, fits, at)


def written(path: Path, rows: int, columns: tuple[Column, ...] = COLUMNS) -> Path:
    writer = TableWriter(path, columns)
    for i in range(rows):
        writer.row((1.0 + 0.1 * i, float(i), i % 100))
    writer.close()
    return path


def test_a_full_disk_costs_nothing_once_there_is_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    disk = Disk(monkeypatch, room=10)
    file = GrowingFile(tmp_path / "file", limit=3)
    file.append(b"0123456")
    file.write()
    for piece in (b"789ab", b"cdefg", b"hij", b"lost"):
        file.append(piece)
    for _ in range(3):
        with pytest.raises(OSError, match="No space"):
            file.write()
    assert file.lost == 1
    assert file.waiting == 3
    assert (tmp_path / "file").read_bytes() == b"0123456789"
    disk.room = 1000
    file.append(b"kl")
    file.close()
    assert (tmp_path / "file").read_bytes() == b"0123456789abcdefghijkl"  # at the very byte where it stopped


def test_a_table_ends_where_a_row_was_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.record.table.ROWS_WAITING", 5)
    disk = Disk(monkeypatch, room=0)
    writer = TableWriter(tmp_path / "flight.npy", COLUMNS)
    for i in range(8):
        writer.row((float(i), 0.0, 0))
    with pytest.raises(OSError, match="No space"):
        writer.write()
    assert len(writer.table()) == 5
    disk.room = 10_000
    writer.write()
    writer.row((99.0, 0.0, 0))  # would leave a hole behind it
    writer.close()
    assert list(read_table(tmp_path / "flight.npy").rows["now"]) == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert writer.lost == 4


def test_numpy_reads_a_finished_table_and_one_that_grows(tmp_path: Path) -> None:
    writer = TableWriter(tmp_path / "flight.npy", COLUMNS)
    for i in range(10):
        writer.row((1.0 + i, 1e300 if i == 3 else 0.5, 1000 if i == 4 else -1))
        writer.write()
        if i == 5:
            writer.sync()
    growing_table = np.load(tmp_path / "flight.npy")
    assert len(growing_table) == 6  # what was synced is counted
    assert len(read_table(tmp_path / "flight.npy").rows) == 10  # what was written is found
    assert len(writer.table()) == 10
    writer.close()
    table = np.load(tmp_path / "flight.npy")
    assert len(table) == 10
    assert math.isinf(table["x"][3]) and table["n"][4] == 127  # brought to what their columns hold
    assert read_table(tmp_path / "flight.npy").cut is None


def test_a_table_cut_anywhere_is_read_up_to_the_cut(tmp_path: Path) -> None:
    whole = written(tmp_path / "whole.npy", 200).read_bytes()
    start = len(whole) - 200 * 13
    rng = random.Random(11)
    cuts = [0, 1, 9, start - 1, start, start + 12, start + 13, len(whole) - 1]
    for size in [*cuts, *(rng.randrange(len(whole)) for _ in range(100))]:
        path = tmp_path / "flight.npy"
        path.write_bytes(whole[:size])
        rows, cut = read_table(path, COLUMNS)
        assert len(rows) == max(0, size - start) // 13
        assert np.array_equal(rows["x"], np.arange(len(rows), dtype=np.float32))
        assert cut is not None and "flight.npy" in cut


def test_blocks_that_a_power_cut_left_empty_are_no_rows(tmp_path: Path) -> None:
    path = written(tmp_path / "flight.npy", 20)
    with path.open("ab") as file:
        file.write(
            TableWriter(path, COLUMNS)._packer.pack((3.1, 7.0, 1)) + bytes(13 * 5)
        )  # one row whole, then nothing
    rows, cut = read_table(path)
    assert len(rows) == 21 and rows["x"][-1] == 7.0
    assert cut == "flight.npy was cut short; 21 whole rows of it are read"


def test_what_is_no_table_is_told_from_one_that_was_cut(tmp_path: Path) -> None:
    (tmp_path / "flight.npy").write_bytes(b"hello")
    with pytest.raises(ValueError, match="magic"):
        read_table(tmp_path / "flight.npy", COLUMNS)


def test_a_log_cut_anywhere_is_read_up_to_the_cut(tmp_path: Path) -> None:
    encoder = Encoder(1, 191)
    heartbeat = message("HEARTBEAT")
    writer = TlogWriter(tmp_path / "link.tlog", epoch=1e9)
    for i in range(50):
        writer.add_frame(float(i), encoder.message(heartbeat, type=18))
    writer.close()
    whole = (tmp_path / "link.tlog").read_bytes()
    size = len(whole) // 50
    rng = random.Random(12)
    for end in [0, 1, 7, 8, size - 1, size, *(rng.randrange(len(whole)) for _ in range(40))]:
        times = [time for time, _ in records(whole[:end])]
        assert times == pytest.approx([1e9 + i for i in range(end // size)])
    holed = whole[: 10 * size] + bytes(3 * size) + whole[13 * size :]
    assert len(list(records(holed))) == 47


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short flight, recorded."""
    directory = tmp_path_factory.mktemp("flights") / "flight"
    flight(duration=2.0, record=directory)
    return directory


def test_a_flight_cut_anywhere_is_replayed_and_reported_up_to_the_cut(flown: Path, tmp_path: Path) -> None:
    rng = random.Random(13)
    whole = len(read_table(flown / "flight.npy").rows)
    for number in range(4):
        copy = Path(shutil.copytree(flown, tmp_path / str(number)))
        size = rng.randrange(2000, (copy / "flight.npy").stat().st_size)
        for name, end in (("flight.npy", size), ("link.tlog", size // 3), ("notes.txt", rng.randrange(200))):
            if (copy / name).is_file():
                os.truncate(copy / name, end)
        recorded = load_flight(copy)
        assert 0 < len(recorded.table) < whole
        assert recorded.cuts == (f"flight.npy was cut short; {len(recorded.table)} whole rows of it are read",)
        replayed = replay(recorded)
        assert replayed.difference is None and replayed.ticks == len(recorded.table)
        text = page_text(read_evidence(copy), [])
        assert "was cut short" in text and "the record ends in the middle of the flight" in text


def test_replay_says_what_was_cut(flown: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(flown, tmp_path / "flight"))
    os.truncate(copy / "flight.npy", 100)
    result = CliRunner().invoke(app, ["replay", str(copy)])
    assert result.exit_code == 0
    assert "flight.npy is cut within its header: no row of it is left" in result.stderr
    assert "0 ticks" in result.stdout


def test_a_record_that_ends_before_its_flight_says_so(flown: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(flown, tmp_path / "flight"))
    (copy / "resolved.json").unlink()
    with pytest.raises(ConfigError, match=r"the record ends before the flight began; link\.tlog has what was heard"):
        load_flight(copy)


def test_a_file_that_others_read_is_whole_or_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "summary.json"
    write_whole(file, "first")

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="No space"):
        write_whole(file, "second")
    with pytest.raises(OSError, match="No space"):
        write_new(tmp_path / "new", "text")
    assert file.read_text() == "first"
    assert list(tmp_path.iterdir()) == [file]
