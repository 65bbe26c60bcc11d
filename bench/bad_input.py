"""Two hundred spoilt mission files: each gets a message with its line or a check, soon, and never a traceback."""

from __future__ import annotations

import argparse
import collections
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from trials.mutated import SOON, cases, outcome


def main() -> None:
    """Print the table; exit code 1 where anything is not as it should be."""
    options = argparse.ArgumentParser()
    options.add_argument("--count", type=int, default=200)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--show", action="store_true", help="what is said of each")
    given = options.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    longest, wrong = (0.0, ""), 0
    for i, (what, mission, plan) in enumerate(cases(given.count, given.seed)):
        with tempfile.TemporaryDirectory() as folder:
            begun = time.process_time()
            word, said = outcome(mission, plan, Path(folder))
            took = time.process_time() - begun
        counts[word] += 1
        longest = max(longest, (took, f"{i}: {what}"))
        late = took > SOON
        wrong += late or word.isupper()
        if given.show or late or word.isupper():
            print(f"--- {i}: {what}: {word}{f', {took:.1f} s' if late else ''}\n{said.replace(folder + '/', '')}")
    print(", ".join(f"{count} {word}" for word, count in counts.most_common()))
    print(f"longest: {longest[0]:.2f} s of a core ({longest[1]}), at most {SOON:g}")
    raise SystemExit(wrong > 0)


if __name__ == "__main__":
    main()
