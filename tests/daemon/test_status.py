"""`companion status`: what another terminal is told of a flight, of one that hangs, and of one that was killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from companion.cli.commands import main
from companion.cli.status import in_words
from companion.daemon import status_file
from companion.daemon.status_file import FlightStatus, StatusFile, read_statuses

pytestmark = pytest.mark.xdist_group("real time")

ABOUT = {"mission": "circle", "vehicle": "x500", "output": "rates", "link": "UDP 127.0.0.1:14540", "record": "/f"}


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A computer of its own."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("RUNTIME_DIRECTORY", raising=False)
    monkeypatch.setattr("companion.daemon.status_file.SHARED", ())
    return tmp_path


def asked(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: str) -> tuple[int, str]:
    monkeypatch.setattr("sys.argv", ["companion", "status", *words])
    with pytest.raises(SystemExit) as left:
        main()
    return int(left.value.code or 0), capsys.readouterr().out


def test_nobody_is_running(own: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert asked(capsys, monkeypatch) == (1, "no companion is running on this computer\n")
    assert asked(capsys, monkeypatch, "--json") == (1, "[]\n")


def test_what_is_said_is_told(own: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    notice = StatusFile(ABOUT)
    notice.write({"phase": "follow", "mode": "Offboard, armed", "progress": "follow  4.0 s", "notes": ["one", "two"]})
    code, out = asked(capsys, monkeypatch)
    assert code == 0
    assert out.splitlines() == [
        f"circle on x500 at rates, process {os.getpid()}: follow",
        "  link      UDP 127.0.0.1:14540",
        "  mode      Offboard, armed",
        "  progress  follow  4.0 s",
        "  record    /f",
        "  said      one",
        "            two",
    ]
    (status,) = json.loads(asked(capsys, monkeypatch, "--json")[1])
    assert status["running"] and status["schema"] == "companion.status/1" and status["age_s"] < 5.0
    notice.remove()
    assert asked(capsys, monkeypatch)[0] == 1
    assert not list((own / "companion").iterdir())


def test_one_that_was_killed_is_told_once(own: Path) -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    notice = StatusFile({**ABOUT, "pid": gone.pid})
    notice.write({"phase": "follow"})
    (status,) = read_statuses()
    assert not status.running
    assert "ended without a word 0 s ago; look at the vehicle" in in_words(status)
    assert read_statuses() == []


def test_one_that_hangs_and_rubbish(own: Path) -> None:
    StatusFile(ABOUT).write({"phase": "follow"})
    (own / "companion" / "7.json").write_text("{", encoding="utf-8")
    (own / "companion" / "8.json").write_text('{"pid": "x"}', encoding="utf-8")
    (status,) = read_statuses()
    assert "has said nothing for 60 s; it hangs" in in_words(FlightStatus(status.document, 60.0, True))


NOW = time.time()


@pytest.mark.parametrize(
    "content",
    [
        {"pid": 10**30, "written_at": NOW},
        {"pid": 0, "written_at": NOW},
        {"pid": -1, "written_at": NOW},
        {"pid": "7", "written_at": NOW},
        {"pid": 7, "written_at": float("nan")},
        {"pid": 7, "written_at": 1e300},
        [7],
    ],
)
def test_a_file_that_no_companion_wrote_is_not_told(own: Path, content: object) -> None:
    StatusFile(ABOUT).write({"phase": "follow"})
    (own / "companion" / "7.json").write_text(json.dumps(content), encoding="utf-8")
    assert len(read_statuses()) == 1


def test_a_link_or_a_pipe_among_them_is_left_alone(own: Path) -> None:
    StatusFile(ABOUT).write({"phase": "follow"})
    elsewhere = own / "elsewhere.json"
    elsewhere.write_text(json.dumps({"pid": 2**22, "written_at": NOW}), encoding="utf-8")
    (own / "companion" / "7.json").symlink_to(elsewhere)
    os.mkfifo(own / "companion" / "8.json")
    assert len(read_statuses()) == 1
    assert elsewhere.exists()


def test_what_another_companion_says_is_data(own: Path) -> None:
    about = {**ABOUT, "mission": "\x1b[2Jcircle", "record": ["\x07"]}
    StatusFile(about).write({"phase": "follow\nland", "notes": ["a\rb", 7, None], "mode": {"\x1b": 1}})
    (status,) = read_statuses()
    text = in_words(status)
    assert all(line.isprintable() for line in text.splitlines())
    assert "\\x1b[2Jcircle on x500" in text and "follow\\nland" in text
    assert "x" * 400 not in in_words(FlightStatus({**status.document, "notes": ["x" * 1000] * 1000}, 0.0, True))
    assert in_words(FlightStatus({**status.document, "notes": 7}, 0.0, True))


def test_a_system_without_a_temporary_directory_stops_no_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> str:
        raise FileNotFoundError("No usable temporary directory found")

    monkeypatch.setattr(tempfile, "gettempdir", nowhere)
    StatusFile(ABOUT, {}).remove()
    assert status_file._temporary_directory() == "/tmp"


def test_a_directory_that_cannot_be_written_to_stops_no_flight(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    notice = StatusFile(ABOUT, {"RUNTIME_DIRECTORY": str(tmp_path / "file")})
    notice.write({"phase": "follow"})
    notice.remove()


def test_a_flight_is_told_while_it_lasts_and_not_after(own: Path) -> None:
    flight = subprocess.Popen(
        [sys.executable, "-m", "companion", "sim", "circle_r5", "--udp", "--duration", "60"],
        cwd=own, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        until = time.monotonic() + 60.0
        while not any(s.document.get("progress") and s.document["phase"] == "follow" for s in read_statuses()):
            assert flight.poll() is None and time.monotonic() < until
            time.sleep(0.1)
        (status,) = read_statuses()
        assert status.document["mission"] == "circle-r5"
        assert status.document["mode"] == "Offboard, armed"
        assert "path error" in status.document["progress"]
        assert any("join -> follow" in note for note in status.document["notes"])
    finally:
        flight.send_signal(signal.SIGINT)
        flight.wait(30.0)
    assert read_statuses() == []
