"""A million spoilt datagrams of a real XRCE session: the agent never raises.

python -m bench.fuzz_xrce [datagrams] [seed]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from trials.damaged_xrce import fuzz

COUNT = 1_000_000
SESSION = Path(__file__).resolve().parent.parent / "tests" / "data" / "xrce_session.hex"


def main() -> None:
    """Print how many samples were read on the way."""
    lines = SESSION.read_text(encoding="ascii").splitlines()
    client = [bytes.fromhex(data) for _, way, data in map(str.split, lines) if way == "<"]
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 2026
    begun = time.perf_counter()
    samples = fuzz(client, count, seed=seed)
    print(f"{count} datagrams in {time.perf_counter() - begun:.0f} s: nothing raised, {samples} samples read")


if __name__ == "__main__":
    main()
