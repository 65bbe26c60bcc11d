"""MAVProxy 1.8.75 flies the plant, headless: parameters, mission, arming, take-off, return; prints what it found.

MAVProxy brings 1.2 GB with it, so it gets an environment of its own, made on the first run in the folder named by
--environment (default .venv-mavproxy) and kept. Not among the tests for its size.
"""

from __future__ import annotations

import argparse
import contextlib
import queue
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

PACKAGES = ("MAVProxy==1.8.75", "setuptools", "future")
PATIENCE = 120.0
MODULES = "param,mode,arm,wp,cmdlong,link,log"
PLAN = """QGC WPL 110
0\t1\t3\t22\t0\t0\t0\tnan\t47.397742\t8.545594\t8\t1
1\t0\t3\t16\t0\t2\t0\tnan\t47.397842\t8.545594\t8\t1
2\t0\t3\t16\t0\t2\t0\tnan\t47.397842\t8.545744\t8\t1
"""


def environment(folder: Path) -> Path:
    """The interpreter of MAVProxy's environment, which is made if it is not there."""
    python = folder / "bin" / "python"
    if not (folder / "bin" / "mavproxy.py").exists():
        print(f"installing {PACKAGES[0]} into {folder} (1.2 GB)")
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", *PACKAGES], check=True)
    return python


class Console:
    """A MAVProxy told what to do on its standard input, and what it prints."""

    def __init__(self, python: Path, master: str, folder: str) -> None:
        command = [
            str(python), str(python.with_name("mavproxy.py")), f"--master={master}", f"--state-basedir={folder}",
            f"--default-modules={MODULES}", "--streamrate=-1", "--aircraft=plant",
        ]  # fmt: skip
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder,
            bufsize=1,
        )  # fmt: skip
        self._lines: queue.Queue[str] = queue.Queue()
        self.said = ""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        while character := self.process.stdout.read(1):
            self._lines.put(character)

    def do(self, line: str) -> None:
        """Type a line."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def sees(self, pattern: str, again: str | None = None) -> bool:
        """Whether it prints something from now on; ``again``: what to type every five seconds until then."""
        end, type_at, since = time.monotonic() + PATIENCE, time.monotonic() + 5.0, len(self.said)
        while time.monotonic() < end:
            with contextlib.suppress(queue.Empty):
                self.said += self._lines.get(timeout=0.2)
                while True:
                    self.said += self._lines.get_nowait()
            if re.search(pattern, self.said[since:]):
                return True
            if again is not None and time.monotonic() >= type_at:
                self.do(again)
                type_at = time.monotonic() + 5.0
        return False


def fly(console: Console, plan: str) -> dict[str, bool]:
    """Everything one does with MAVProxy and PX4, its broken ``mode NAME`` aside."""
    found = {"connected": console.sees(r"Detected vehicle|online system 1")}
    found["parameters"] = console.sees(r"Received \d+ parameters", "param fetch")
    console.do("param set RTL_RETURN_ALT 12")
    time.sleep(1.0)
    console.do("param show RTL_RETURN_ALT")
    found["parameter set"] = console.sees(r"RTL_RETURN_ALT\s+12\.0")
    console.do(f"wp load {plan}")
    found["mission sent"] = console.sees(r"Sent all 3|Loaded 3 waypoints|waypoint ack|Mission Ack|ACCEPTED")
    time.sleep(2.0)
    console.do("wp list")
    found["mission back"] = console.sees(r"Requesting 3 waypoints|22 3 |Saved 3 waypoints")
    console.do("long DO_SET_MODE 1 4 4 0 0 0 0")
    found["mission mode"] = console.sees(r"mode|MISSION|AUTO|DO_SET_MODE")
    console.do("arm throttle")
    found["armed"] = console.sees(r"ARMED|Armed by external command")
    found["took off"] = console.sees(r"Takeoff detected")
    found["flown"] = console.sees(r"Mission finished, loitering")
    console.do("long DO_SET_MODE 1 4 5 0 0 0 0")
    found["returned"] = console.sees(r"Disarmed by landing")
    console.do("wp clear")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--environment", type=Path, default=Path(".venv-mavproxy"))
    python = environment(parser.parse_args().environment.absolute())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    plant = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge", "--vehicle", "sih", "--ground-station", "none", "--speed", "2",
         "--connect", f"udpout://127.0.0.1:{port}"],
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan.txt"
        plan.write_text(PLAN, encoding="ascii")
        console = Console(python, f"udpin:127.0.0.1:{port}", folder)
        try:
            found = fly(console, str(plan))
        finally:
            console.process.terminate()
            plant.terminate()
            plant.wait()
    for what, is_so in found.items():
        print(f"{what:16} {'yes' if is_so else 'NO'}")
    if not all(found.values()):
        print(console.said[-3000:])
    return 0 if all(found.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
