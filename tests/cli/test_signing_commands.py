"""``companion vehicle sign`` and ``--signing-key`` as processes over UDP."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.cli.commands import main
from tests.support.signing import KEY, OTHER, key_file

pytestmark = pytest.mark.xdist_group("real time")


def run(directory: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "companion", *words], cwd=directory, capture_output=True, text=True, timeout=90.0,
        check=False, env=os.environ | {"XDG_STATE_HOME": str(directory / "state")},
    )  # fmt: skip


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def connect(tmp_path: Path) -> Iterator[str]:
    """The address at which a vehicle on the ground speaks, without a key."""
    url = f"127.0.0.1:{free_port()}"
    plant = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge", "--connect", f"udpout://{url}", "--ground-station", "none"],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    yield f"udpin://{url}"
    plant.terminate()
    plant.wait(10.0)


def test_a_key_is_given_once_and_the_vehicle_is_seen_with_it_alone(connect: str, tmp_path: Path) -> None:
    key, other = str(key_file(tmp_path)), str(key_file(tmp_path, OTHER))
    first = run(tmp_path, "vehicle", "sign", "--connect", connect, "--signing-key", key)
    assert first.returncode == 0, first.stderr
    assert "has taken the key and signs" in first.stdout
    again = run(tmp_path, "vehicle", "sign", "--connect", connect, "--signing-key", key)
    assert (again.returncode, "signs with this key already" in again.stdout) == (0, True), again.stderr
    wrong = run(tmp_path, "vehicle", "sign", "--connect", connect, "--signing-key", other)
    assert wrong.returncode == 1
    assert "no key was taken: the vehicle signs with another key" in wrong.stdout
    fly = ["fly", "circle_r5", "--connect", connect, "--dry-run", "--duration", "2", "--no-report", "--record"]
    with_it = run(tmp_path, *fly, str(tmp_path / "a"), "--signing-key", key, "--json")
    assert with_it.returncode == 0, with_it.stderr + with_it.stdout
    assert (tmp_path / "a" / "link.tlog").stat().st_size > 10_000
    for file in tmp_path.rglob("*"):
        if file.is_file() and file.suffix != ".key":
            assert KEY not in file.read_bytes()
            assert KEY.hex().encode() not in file.read_bytes()
    for done in (first, again, wrong, with_it):
        assert KEY.hex() not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fly", "circle_r5"], "has mode 0644, expected 0600"),
        (["vehicle", "sign"], "has mode 0644, expected 0600"),
        (["preflight"], "preflight goes through MAVSDK, which cannot sign"),
    ],
)
def test_what_cannot_be_is_said_at_once_with_exit_code_2(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    key = key_file(tmp_path, mode=0o644)
    words += ["--connect", f"udpin://127.0.0.1:{free_port()}", "--signing-key", str(key)]
    code, output = asked(words, capsys, monkeypatch)
    assert (code, said in output) == (2, True), output
    assert KEY.hex() not in output


def test_a_key_goes_over_no_network_unless_that_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["vehicle", "sign", "--connect", f"udpin://0.0.0.0:{free_port()}", "--signing-key", str(key_file(tmp_path))]
    code, output = asked(words, capsys, monkeypatch)
    assert code == 2
    assert "the key would go in plain text over a network" in output
    assert "--trust-link" in output


def asked(words: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> tuple[int, str]:
    """A command in this process: its exit code and what it said."""
    monkeypatch.setattr("sys.argv", ["companion", *words])
    with pytest.raises(SystemExit) as left:
        main()
    out, err = capsys.readouterr()
    return int(left.value.code or 0), out + err
