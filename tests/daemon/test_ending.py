"""However a flight is asked to end, the vehicle is handed back first; and the exit code says so."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("real time")

FLY = [sys.executable, "-m", "companion", "sim", "circle_r5", "--output", "motors", "--record", "flight", "--json"]


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
    code, out, said = ended(tmp_path, ["--udp", "--duration", "60"], number, "-> follow", group=group)
    assert code == 130, said
    figures = json.loads(out)
    assert (figures["outcome"], figures["reason"]) == ("aborted", "stopped by the user")
    assert [phase["phase"] for phase in figures["phases"]][-2:] == ["hand back", "done"]
    assert "mode HOLD" in said  # the plant's own word


def test_a_closed_terminal_in_lockstep(tmp_path: Path) -> None:
    code, out, said = ended(tmp_path, ["--duration", "3000"], signal.SIGHUP, "-> follow")
    assert code == 130, said
    assert json.loads(out)["reason"] == "stopped by the user"
    assert "hand back -> done: the vehicle is in Hold" in said
    assert "Traceback" not in said
