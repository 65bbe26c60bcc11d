"""A minute of flight in lockstep: seconds of one core, plant and daemon together. Budget 6 s at motors, 250 Hz."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def main() -> None:
    """Print the table."""
    print("mission      rate Hz   wall s   core s   (of 60 s flown, start of the interpreter included)")
    for mission in ("circle_r5", "circle_r10"):
        with tempfile.TemporaryDirectory() as directory:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            begun = time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-m", "companion", "sim", mission, "--output", "motors", "--duration", "60",
                 "--record", str(Path(directory) / "flight"), "--json"],
                capture_output=True, text=True, check=True,
            )  # fmt: skip
            wall = time.perf_counter() - begun
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            core = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            rate = json.loads(done.stdout)["loop"]["rate_hz"]
            print(f"{mission:12} {rate:7.0f}  {wall:7.2f}  {core:7.2f}")


if __name__ == "__main__":
    main()
