"""A minute of flight in lockstep with full streams: seconds of one core, plant and daemon together.

Budgets: 2 s at rates output, 6 s at motors (250 Hz). The flight alone is timed inside the process that flies it, with
the plant's part of it; the process as a whole has the interpreter's start, the imports and the summary besides.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

TIMED = """
import json, sys, time
import companion.library.simulation as simulate
from companion.cli import main
from sim_bridge.bridge import Bridge

spent = {"flight": 0.0, "plant": 0.0}

def timed(part, function):
    def inside(*args, **options):
        begun = time.thread_time()
        try:
            return function(*args, **options)
        finally:
            spent[part] += time.thread_time() - begun
    return inside

simulate.fly = timed("flight", simulate.fly)
for name in ("step", "receive", "datagrams"):
    setattr(Bridge, name, timed("plant", getattr(Bridge, name)))
try:
    main()
finally:
    print(json.dumps(spent), file=sys.stderr)
"""


def flown(mission: str, output: str, directory: Path) -> tuple[float, float, float, float]:
    """(rate Hz, core seconds of the process, of the flight, of the plant in it) of a minute."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-c", TIMED, "sim", mission, "--output", output, "--duration", "60",
         "--record", str(directory / "flight"), "--json"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    core = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    spent = json.loads(done.stderr.splitlines()[-1])
    return json.loads(done.stdout)["loop"]["rate_hz"], core, spent["flight"], spent["plant"]


def main() -> None:
    """Print the table."""
    print("mission      output   rate Hz   process s   flight s   of it the plant s      (of one core, 60 s flown)")
    for mission, output in (("circle_r5", "rates"), ("circle_r5", "motors"), ("circle_r10", "motors")):
        with tempfile.TemporaryDirectory() as directory:
            rate, core, flight, plant = flown(mission, output, Path(directory))
        print(f"{mission:12} {output:8} {rate:7.0f}  {core:9.2f}  {flight:9.2f}  {plant:9.2f}", flush=True)


if __name__ == "__main__":
    main()
