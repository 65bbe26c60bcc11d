"""However a flight is asked to end, the vehicle is handed back first; and the exit code says so."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from companion.record.table import read_table

pytestmark = pytest.mark.xdist_group("real time")

FLY = [sys.executable, "-m", "companion", "sim", "circle_r5", "--output", "motors", "--no-report"]
FLY += ["--record", "flight", "--json"]


def ended(
    directory: Path, arguments: list[str], number: signal.Signals, seen: str, *, group: bool = False
) -> tuple[int, str, str]:
    """Send a signal once ``seen`` is on stderr; the exit code, stdout and what came on stderr."""
    process = subprocess.Popen(
        [*FLY, *arguments], cwd=directory, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stderr is not None
    said = ""
    while seen not in said:
        line = process.stderr.readline()
        assert line, f"ended too soon: {said}"
        said += line
    (os.killpg if group else os.kill)(process.pid, number)
    out, err = process.communicate(timeout=60.0)
    return process.returncode, out, said + err


@pytest.mark.parametrize(
    ("number", "group"), [(signal.SIGINT, True), (signal.SIGTERM, False)], ids=["ctrl-c at a terminal", "terminate"]
)
def test_in_real_time(number: signal.Signals, group: bool, tmp_path: Path) -> None:
    code, out, said = ended(tmp_path, ["--udp", "--duration", "60"], number, "path error", group=group)
    assert code == 130, said
    figures = json.loads(out)
    assert figures["outcome"] == "aborted"
    assert re.fullmatch(
        r"stopped by the user: the vehicle is in Hold, armed, 10\.\d m above home and 5 m from it; it stays there until "
        "somebody takes it: by remote control or from a ground station",
        figures["reason"],
    )
    assert [phase["phase"] for phase in figures["phases"]][-2:] == ["hand back", "done"]
    assert "mode HOLD" in said  # the plant's own word


def test_a_stop_in_lockstep(tmp_path: Path) -> None:
    code, out, said = ended(tmp_path, ["--duration", "3000"], signal.SIGTERM, "-> follow")
    assert code == 130, said
    assert json.loads(out)["reason"].startswith("stopped by the user: the vehicle is in Hold")
    assert "hand back -> done: the vehicle is in Hold" in said
    assert "Traceback" not in said


def test_a_terminal_that_is_gone_changes_nothing(tmp_path: Path) -> None:
    """SIGHUP, Ctrl-Z, and a stderr that nobody reads any more: flown to the end, and stdout still has it."""
    process = subprocess.Popen(
        [*FLY, "--udp", "--duration", "2", "--settle", "1"], cwd=tmp_path, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stderr is not None and process.stdout is not None
    while "-> settle" not in (line := process.stderr.readline()):
        assert line
    process.stderr.close()
    for number in (signal.SIGHUP, signal.SIGTSTP, signal.SIGTTOU):
        process.send_signal(number)
    figures = json.loads(process.stdout.read())
    assert process.wait(30.0) == 0
    assert figures["outcome"] == "completed"
    notes = (tmp_path / "flight" / "notes.txt").read_text(encoding="utf-8")
    assert "follow -> hand back" in notes  # what nobody could read is in the folder


@pytest.mark.parametrize("first", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_it_at_once(first: signal.Signals, tmp_path: Path) -> None:
    """With the vehicle gone silent in the climb, what the first signal asks for takes its time."""
    process = subprocess.Popen(
        [*FLY, "--udp", "--from-ground"], cwd=tmp_path, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stderr is not None
    while "-> take off" not in (line := process.stderr.readline()):
        assert line
    plant = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="ascii").split()
    for number in plant:
        os.kill(int(number), signal.SIGSTOP)
    process.send_signal(first)
    while "-> disarm" not in (line := process.stderr.readline()):
        assert line
    process.send_signal(signal.SIGTERM)
    code = process.wait(10.0)
    _, said = process.communicate(timeout=10.0)  # the plant is gone too: nobody holds the pipes
    assert code == 130
    assert "a second signal: the companion ends at once and hands nothing back; the vehicle " in said
    assert "disarm ->" not in said  # it did not wait for the vehicle
    assert len(read_table(tmp_path / "flight" / "flight.npy").rows) > 10


def test_started_without_any_of_the_three_streams(tmp_path: Path) -> None:
    """A closed stdout, stderr and stdin: no file of the record gets their numbers, and the exit code is the flight's."""
    words = [*FLY[:-3], "--duration", "1", "--record", "flight"]
    shell = " ".join(["exec", *words, "<&-", ">&-", "2>&-"])
    assert subprocess.run(["sh", "-c", shell], cwd=tmp_path, timeout=60.0, check=False).returncode == 0
    assert json.loads((tmp_path / "flight" / "summary.json").read_text())["outcome"] == "completed"
    assert not read_table(tmp_path / "flight" / "flight.npy").cut


def test_a_result_that_nobody_reads(tmp_path: Path) -> None:
    """``companion sim ... | true``: no complaint, and the exit code is the flight's."""
    read, write = os.pipe()
    os.close(read)
    flown = subprocess.run(
        [*FLY, "--duration", "1"],
        cwd=tmp_path,
        stdout=write,
        stderr=subprocess.PIPE,
        text=True,
        timeout=60.0,
        check=False,
    )
    os.close(write)
    assert flown.returncode == 0
    assert "Error" not in flown.stderr and "Exception" not in flown.stderr


def test_a_name_in_an_alphabet_that_the_locale_lacks(tmp_path: Path) -> None:
    flown = subprocess.run(
        [*FLY[:-3], "--duration", "1", "--record", "Flüge 飛"], cwd=tmp_path, capture_output=True, timeout=60.0, check=False,
        env={**os.environ, "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"},
    )  # fmt: skip
    assert flown.returncode == 0, flown.stderr
    assert b"flight folder: Fl" in flown.stdout
