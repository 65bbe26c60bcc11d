"""The commands of README that need a vehicle, run as they stand: only the port is a free one, and the flight short."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = {"companion": "companion", "sim-bridge": "sim_bridge"}
"""A program and the module that it runs."""


def script(port: int) -> str:
    """README's block that begins with sim-bridge."""
    blocks = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    (block,) = [block for block in blocks if block.startswith("sim-bridge")]
    block = block.replace("sim-bridge &", f"sim-bridge --connect udpout://127.0.0.1:{port} --ground-station none &")
    block = block.replace("14540", str(port)).replace("--duration 20", "--duration 2 --no-report")
    block = block.replace("kill %1", "kill $!")  # a script has no job control
    for program, module in COMMANDS.items():
        block = re.sub(rf"^{program} ", f"{sys.executable} -m {module} ", block, flags=re.MULTILINE)
    return "\n".join(
        line if line.startswith("kill") else f"{line.partition('#')[0]}\necho said: $?" for line in block.splitlines()
    )


@pytest.mark.xdist_group("real time")
def test_the_commands_of_readme_that_need_a_vehicle(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = os.environ | {
        "PYTHONPATH": str(ROOT),
        "XDG_RUNTIME_DIR": str(tmp_path),
        "XDG_STATE_HOME": str(tmp_path),
    }
    ran = subprocess.run(
        ["bash", "-c", script(port)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=150
    )
    codes = [int(line.partition(": ")[2]) for line in ran.stdout.splitlines() if line.startswith("said: ")]
    begun, preflight, flown, status = codes
    assert (begun, preflight, flown) == (0, 0, 0), ran.stdout + ran.stderr
    assert status in (0, 1) and re.search("Can be flown|Ready to fly", ran.stdout)
