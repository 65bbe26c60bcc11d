"""What systemd is told, and by whom: the control loop itself feeds the watchdog."""

from __future__ import annotations

import json
import math
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from companion.daemon.systemd import Service

pytestmark = pytest.mark.xdist_group("real time")


@pytest.fixture
def manager(tmp_path: Path) -> socket.socket:
    listening = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    listening.bind(str(tmp_path / "notify"))
    listening.settimeout(10.0)
    return listening


def test_without_a_manager_nothing_is_said() -> None:
    service = Service({})
    assert service.period == math.inf
    service.ready("x")
    service.alive(0.0)
    service.stopping()
    service.close()


def test_what_is_said(manager: socket.socket) -> None:
    service = Service({"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "2000000"})
    service.ready("listening")
    assert manager.recv(200) == b"READY=1\nSTATUS=listening"
    assert service.period == 1.0
    for now in (5.0, 5.5, 5.9, 6.1, 6.2):
        service.alive(now)
    service.status("follow")
    service.stopping()
    assert [manager.recv(200) for _ in range(4)] == [b"WATCHDOG=1", b"WATCHDOG=1", b"STATUS=follow", b"STOPPING=1"]
    service.close()
    service.status("late")


def test_another_process_watchdog_and_a_dead_manager(manager: socket.socket) -> None:
    where = manager.getsockname()
    other = {"NOTIFY_SOCKET": where, "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": str(os.getpid() + 1)}
    assert Service(other).period == math.inf
    assert Service({"NOTIFY_SOCKET": where, "WATCHDOG_USEC": "soon"}).period == math.inf
    service = Service({"NOTIFY_SOCKET": where})
    manager.close()
    service.ready("nobody listens")


def test_a_flight_under_systemd(manager: socket.socket, tmp_path: Path) -> None:
    """Ready when it listens, alive while it flies, its line as the status, stopping at the end."""
    environment = os.environ | {"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "600000"}
    command = ["sim", "circle_r5", "--output", "motors", "--udp", "--duration", "2", "--json"]
    flight = subprocess.Popen(
        [sys.executable, "-m", "companion", *command], cwd=tmp_path, env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    manager.settimeout(60.0)
    said = [manager.recv(400).decode()]
    while said[-1] != "STOPPING=1":
        said.append(manager.recv(400).decode())
    out, err = flight.communicate(timeout=60.0)
    assert flight.returncode == 0, err
    assert said[0].startswith("READY=1\nSTATUS=listening to UDP 127.0.0.1:")
    assert said.count("WATCHDOG=1") >= 3
    assert any(line.startswith("STATUS=follow") for line in said)
    assert json.loads(out)["outcome"] == "completed"
