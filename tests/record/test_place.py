"""Where a flight is recorded: never over somebody else's files, and only what was made is removed."""

from __future__ import annotations

import errno
import json
import os
import socket
import sys
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from typer.testing import CliRunner

from companion.cli import flying
from companion.cli.commands import app
from companion.config.syntax.faults import ConfigError
from companion.record import folder, place
from companion.record.folder import Recorder, Source
from companion.record.learned import load_learned, state_file
from companion.record.place import new_directory

MISSION = Source("mission.yaml", "mission: x\n", ("field.plan", "{}"))
VEHICLE = Source("x500", "name: x500\n")


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def fly(record: Path, *words: str) -> tuple[int, str, str]:
    """``companion fly`` where there is no vehicle."""
    connect = f"udpin://127.0.0.1:{free_port()}"
    result = CliRunner().invoke(app, ["fly", "circle_r5", "--connect", connect, "--record", str(record), *words])
    return result.exit_code, result.stdout, result.stderr if result.exception is None else f"{result.exception}"


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flying, "WAIT_FOR_VEHICLE", 0.1)


def test_ones_own_mission_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("mission.yaml", "vehicle.yaml"):
        (tmp_path / name).write_text("mine")
    for record in (Path(), tmp_path):
        code, _, said = fly(record)
        assert code != 0
        assert "is not empty, and nothing in it is written over; expected a new or an empty folder" in said
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"mission.yaml": "mine", "vehicle.yaml": "mine"}


@pytest.mark.parametrize("command", [["sim", "circle_r5"], ["demo", "--fast"]])
def test_nor_by_the_simulator(command: list[str], tmp_path: Path) -> None:
    (tmp_path / "mission.yaml").write_text("mine")
    result = CliRunner().invoke(app, [*command, "--record", str(tmp_path)])
    assert isinstance(result.exception, ConfigError)  # exit code 2, by main
    assert [p.name for p in tmp_path.iterdir()] == ["mission.yaml"]


def test_no_vehicle_removes_what_was_made_and_nothing_else(tmp_path: Path) -> None:
    code, out, _ = fly(tmp_path / "a" / "b", "--json")
    assert code == 3
    assert '"outcome": "aborted"' in out and "no vehicle: listened to" in out
    assert list(tmp_path.iterdir()) == []
    mine = tmp_path / "mine"
    mine.mkdir()
    assert fly(mine)[0] == 3
    assert list(mine.iterdir()) == []  # it was there before: it stays


def test_what_came_in_meanwhile_stays(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "new" / "flight", MISSION, VEHICLE, 0.0)
    assert {p.name for p in recorder.directory.iterdir()} == {"mission.yaml", "vehicle.yaml", "field.plan", "link.tlog"}
    (recorder.directory / "notes of mine.txt").write_text("mine")
    recorder.discard()
    assert [p.name for p in recorder.directory.iterdir()] == ["notes of mine.txt"]


@pytest.mark.parametrize("name", ["file", "file/flight", "dangling", "/proc/flight", "x" * 300])
def test_places_that_cannot_be_one(name: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(ConfigError, match=r"--record: .*expected a new or an empty folder"):
        Recorder(tmp_path / name, MISSION, VEHICLE, 0.0)
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "file").read_text() == "mine"


def test_two_at_once_do_not_share_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = Recorder(tmp_path / "flight", MISSION, VEHICLE, 0.0)
    monkeypatch.setattr(place, "refuse_used", lambda directory: None)  # both looked before either wrote
    with pytest.raises(ConfigError, match="is being written by another companion"):
        Recorder(tmp_path / "flight", MISSION, VEHICLE, 0.0)
    assert (tmp_path / "flight" / "mission.yaml").read_text() == MISSION.text
    first.note(1.0, "still here")
    first.close()
    assert "still here" in (tmp_path / "flight" / "notes.txt").read_text()


def test_a_disk_that_is_full_from_the_start_is_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full = [True]
    really = folder.write_new

    def write(path: Path, text: str) -> None:
        if full[0]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        really(path, text)

    monkeypatch.setattr(folder, "write_new", write)
    recorder = Recorder(tmp_path / "flight", MISSION, VEHICLE, 0.0)
    assert "the record cannot be written (No space left on device); the flight goes on" in recorder.words.popleft()
    recorder.flush()
    assert not any("cannot be written" in words for words in recorder.words)  # said once
    full[0] = False
    recorder.flush()
    assert recorder.words[-1] == "the record is written again"
    assert (tmp_path / "flight" / "mission.yaml").read_text() == MISSION.text


def test_little_room_is_said_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = folder.shutil.disk_usage(tmp_path)
    monkeypatch.setattr(folder.shutil, "disk_usage", lambda path: usage._replace(free=25_000_000))
    recorder = Recorder(tmp_path / "flight", MISSION, VEHICLE, 0.0)
    (words,) = recorder.words
    assert words.startswith("warning: only 25 MB are free for the record, about 89 s of flight; the flight is flown")


def test_lines_are_data(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "flight", MISSION, VEHICLE, 1e9)
    recorder.note(2.0, "vehicle: \x1b[2Jé\nx\udcff")
    recorder.close()
    assert (tmp_path / "flight" / "notes.txt").read_bytes() == (
        b"1000000002.000 vehicle: \\x1b[2J\xc3\xa9\\nx\\udcff\n"
    )


def test_names_of_new_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first = new_directory("Über alles " + "x" * 400)
    assert len(first.name) < 100
    first.mkdir(parents=True)
    assert new_directory("Über alles " + "x" * 400) != first


def test_a_user_without_a_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nobody)
    assert state_file("x500") is None
    assert load_learned(None) is None


def test_a_change_at_any_instant_of_a_write_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another thread retunes between any two steps of the interpreter inside the writer: the next write has it."""
    monkeypatch.setattr(folder, "resolution", lambda *_: {"settings": []})
    recorder = Recorder(tmp_path / "flight", MISSION, VEHICLE, 0.0)
    recorder.begin(None, 0.0)  # type: ignore[arg-type]
    written: list[str] = []
    monkeypatch.setattr(folder, "write_whole", lambda path, text: written.append(text))
    steps = [0, 0]  # taken, and the one after which the other thread comes

    def trace(frame: FrameType, event: str, _: object) -> Any:
        if frame.f_code is not Recorder._write_resolved.__code__:
            return None
        frame.f_trace_opcodes = True
        steps[0] += event == "opcode"
        if event == "opcode" and steps[0] == steps[1]:
            recorder.add_settings({"tube": float(steps[1])}, 1.0)
        return trace

    while steps[0] >= steps[1]:
        steps[:] = [0, steps[1] + 1]
        recorder.add_settings({"tube": -1.0}, 0.0)
        before = sys.gettrace()
        sys.settrace(trace)
        recorder.flush()
        sys.settrace(before)
        recorder.flush()
        assert json.loads(written[-1]) == recorder._resolution, f"lost after step {steps[1]}"
    assert steps[1] > 10
    count = len(written)
    recorder.flush()
    assert len(written) == count  # and nothing is written twice
