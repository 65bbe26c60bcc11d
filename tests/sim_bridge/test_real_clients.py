"""Clients written against PX4 fly the plant over UDP, as processes that know nothing of it.

The plant runs several times as fast as the clock; nothing here depends on how fast the machine is.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest

pytestmark = pytest.mark.xdist_group("real time")

SPEED = "8"
FOR_ALL_OF_IT = 300.0


@pytest.fixture
def plant() -> Iterator[int]:
    """A vehicle on the ground, just switched on; the port it talks to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
    command = [sys.executable, "-m", "sim_bridge", "--vehicle", "sih", "--ground-station", "none", "--speed", SPEED]
    process = subprocess.Popen(
        [*command, "--connect", f"udpout://127.0.0.1:{port}"], stderr=subprocess.DEVNULL, text=True
    )  # fmt: skip
    yield port
    process.terminate()
    process.wait(20.0)


def findings(client: str, url: str) -> dict[str, Any]:
    """What a client found, in its order."""
    command = [sys.executable, "-m", f"tests.sim_bridge.clients.{client}", url]
    done = subprocess.run(command, capture_output=True, text=True, timeout=FOR_ALL_OF_IT, check=False)
    found: dict[str, Any] = {}
    for line in done.stdout.splitlines():
        if line.startswith("{"):
            found |= json.loads(line)
    assert done.returncode == 0, (found, done.stderr[-2000:])
    return found


def test_mavsdk_flies_it(plant: int) -> None:
    found = findings("with_mavsdk", f"udpin://127.0.0.1:{plant}")
    assert found.pop("parameters") > 800
    assert found.pop("battery") > 90.0
    assert found == {
        "connected": "0", "discovered": True, "armed too early": "COMMAND_DENIED", "healthy": True, "may arm": True,
        "identity": 1,
        "set": [6.0, 5], "unknown parameter": "DOES_NOT_EXIST", "home known": True, "fence back": 5, "mission back": 2,
        "took off": True, "in air": True, "went there": True, "heading": True, "no setpoint": "NO_SETPOINT_SET",
        "offboard": True, "position": True, "velocity": True, "velocity of the body": True,
        "position and velocity": True, "acceleration": True, "global position": True, "attitude": True, "rates": True,
        "hold": True, "mission finished": True, "mission progress": 2, "where it ends": True, "landing": True,
        "disarmed": True, "cleared": 0,
    }  # fmt: skip


def test_pymavlink_flies_it(plant: int) -> None:
    found = findings("with_pymavlink", f"udpin:127.0.0.1:{plant}")
    assert found == {
        "heartbeat": 12, "all parameters": True, "set": True, "ready": True, "version": 0, "faster": 0, "nonsense": 3,
        "cleared": 0, "uploaded": 0, "mode": True, "armed": True, "reached": True, "mode after": True, "returns": True,
        "disarmed": True, "landed": True, "armed text": True, "loiter": True, "arm": 0, "take off": 0,
        "took off": True, "no stream": 1, "offboard": 0, "there": True, "lost": True, "failsafe": True, "land": 0,
        "down": True,
    }  # fmt: skip
