"""Whether memory stays flat: python -m bench.soak [simulated hours, default 0.1] [real minutes, default 1]

Flies circle_r5 at rates, recorded, once as ``companion sim`` (lockstep, plant and daemon in one process) and once as
``companion sim --udp`` (the daemon's process alone is looked at), and samples the process's anonymous memory as the
flight goes on. The whole of it is ``python -m bench.soak 10 30`` (hours of a core, 8 GB of disk while it lasts).

Target: 2 MB or less between the end of the warm-up and the end of the flight. A shorter run also says what its slope
would come to in ten hours or thirty minutes; a slope out of few samples is an estimate and not a proof.
"""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

GROWTH_MAX = 2.0
"""MB after the warm-up (issue 11)."""
PROGRESS = re.compile(r"follow\s+(\d+\.\d) s")
WHOLE = {"lockstep": 36_000.0, "real time": 1_800.0}
WARM_UP = {"lockstep": 120.0, "real time": 30.0}
"""s of following: caches and the allocator's pools are filled by then (the samples below show it)."""


def anonymous(pid: int) -> float:
    """MB of memory that is the process's own, not a file's."""
    text = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return int(re.findall(r"RssAnon:\s+(\d+) kB", text)[0]) / 1024.0


def children(pid: int) -> list[int]:
    """The processes it started: the plant."""
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()]


def soak(kind: str, seconds: float) -> bool:
    """Fly, sample, judge."""
    with tempfile.TemporaryDirectory(dir=".") as folder:
        words = [sys.executable, "-m", "companion", "sim", "circle_r5", "--output", "rates", "--no-report"]
        words += ["--record", f"{folder}/flight", "--duration", f"{seconds + 60.0:g}"]
        words += ["--udp"] if kind == "real time" else []
        process = subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        samples = sampled(process, seconds)
        sizes = {file.name: file.stat().st_size / 1e6 for file in Path(folder, "flight").iterdir()}
    return judged(kind, seconds, np.array(samples), sizes)


def sampled(process: subprocess.Popen[str], seconds: float) -> list[tuple[float, float]]:
    """(s of following, MB) until ``seconds``; then the process is killed, as its record must stand."""
    assert process.stderr is not None
    samples, begun = [], time.monotonic()
    try:
        for line in process.stderr:
            found = PROGRESS.search(line)
            if found is None:
                continue
            samples.append((float(found[1]), anonymous(process.pid)))
            if samples[-1][0] >= seconds:
                break
        print(f"flown in {time.monotonic() - begun:.0f} s")
    finally:
        for pid in [*children(process.pid), process.pid] if process.poll() is None else []:
            subprocess.run(["kill", f"-{signal.SIGKILL.value}", str(pid)], check=False)
        process.wait()
    return samples


def judged(kind: str, seconds: float, samples: np.ndarray, sizes: dict[str, float]) -> bool:
    """Print what came of it."""
    steady = samples[samples[:, 0] >= min(WARM_UP[kind], 0.5 * seconds)]
    if len(steady) < 3 or samples[-1, 0] < seconds:
        print(f"{kind}: MISSED: the flight ended after {samples[-1, 0] if len(samples) else 0.0:.0f} s")
        return False
    growth = float(np.max(steady[:, 1]) - steady[0, 1])
    slope = float(np.polyfit(steady[:, 0], steady[:, 1], 1)[0])
    print(f"{kind}: {samples[-1, 0]:.0f} s of following, {len(samples)} samples; MB of memory at")
    for at in np.linspace(0, len(samples) - 1, min(8, len(samples))).astype(int):
        print(f"  {samples[at, 0]:8.0f} s  {samples[at, 1]:8.2f}")
    print("  record, MB: " + ", ".join(f"{name} {size:.1f}" for name, size in sorted(sizes.items())))
    whole = slope * WHOLE[kind]
    held = growth <= GROWTH_MAX
    print(
        f"  grown by {growth:.2f} MB after {steady[0, 0]:.0f} s (target {GROWTH_MAX:g}); slope "
        f"{3600.0 * slope:+.2f} MB an hour, {whole:+.2f} MB in {WHOLE[kind]:.0f} s: {'held' if held else 'MISSED'}"
    )
    return held


def main() -> None:
    """Both, and the exit code."""
    hours = float(sys.argv[1]) if len(sys.argv) > 1 else 0.1
    minutes = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
    held = [
        soak(kind, seconds)
        for kind, seconds in (("lockstep", 3600.0 * hours), ("real time", 60.0 * minutes))
        if seconds > 0.0
    ]
    sys.exit(0 if all(held) else 1)


if __name__ == "__main__":
    main()
