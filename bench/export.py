"""How long a flight's folder takes to MCAP and to CSV, and whether mcap's own reader takes what was written.

python -m bench.export [SECONDS | FOLDER]    a flight of so many seconds (300), or one that is there

Targets: five minutes of flight in at most 5 s each, everything counted: reading the folder, and the libraries too. The
reader checks every CRC, that every message has what its schema says, and that every number of ours has a unit.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mcap.reader import make_reader

import companion

TARGET = 5.0
"""s (the issue's)."""


def exported(folder: Path, kind: str, to: Path) -> tuple[float, float]:
    """s of the command, and of a core."""
    begun, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    words = ["companion", "export-flight", str(folder), kind, "--to", str(to)]
    subprocess.run([sys.executable, "-m", *words], check=True, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - begun, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def validated(file: Path) -> tuple[int, int]:
    """How many messages the library's reader finds, and how many numbers that have a unit. AssertionError: a message
    is not as its schema says, or a number of ours has no unit."""
    messages, with_unit = 0, dict[str, int]()
    properties: dict[int, dict[str, dict[str, object]]] = {}
    with file.open("rb") as opened:
        for schema, _, message in make_reader(opened, validate_crcs=True).iter_messages():
            assert schema is not None and schema.encoding == "jsonschema"
            if schema.id not in properties:
                properties[schema.id] = json.loads(schema.data)["properties"]
            known = properties[schema.id]
            assert set(json.loads(message.data)) == set(known), schema.name
            messages += 1
            if schema.name.startswith("companion.") and schema.name not in with_unit:
                numbers = [key for key in known if key != "timestamp"]
                assert all(known[key]["unit"] for key in numbers), schema.name
                with_unit[schema.name] = len(numbers)
    return messages, sum(with_unit.values())


def main() -> None:
    """Fly, export, read again; print a line of each."""
    asked = sys.argv[1] if len(sys.argv) > 1 else "300"
    with tempfile.TemporaryDirectory() as name:
        to, folder = Path(name), Path(asked)
        if not folder.is_dir():
            folder = to / "flown"
            companion.simulate("circle_r5", world="outdoor", output="rates", duration=float(asked), record=folder)
        for kind in ("--csv", "--mcap"):
            took, core = exported(folder, kind, to)
            held = "held" if took <= TARGET else "MISSED"
            print(f"{kind}: {took:.2f} s, of a core {core:.2f}, target {TARGET:g}: {held}", flush=True)
        messages, numbers = validated(to / "flight.mcap")
        size = (to / "flight.mcap").stat().st_size
        print(f"flight.mcap: {messages} messages, {1e-6 * size:.1f} MB; {numbers} numbers of ours, each with its unit")


if __name__ == "__main__":
    main()
