"""The deck of fault flights, flown and printed as the table of docs/faults.md.

    python -m bench.faults [JOBS]             the whole deck at every level; as many jobs as there are cores
    python -m bench.faults [JOBS] --rates     only at rates, in a third of the time
    python -m bench.faults --case WORDS       only the cases with these words in their name, and what is wrong with each

Exit 1 where a flight is not as it must be.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from trials.faults.case import LEVELS
from trials.faults.deck import DECK
from trials.faults.table import Row, cases_named, page, rows

PAGE = Path(__file__).resolve().parent.parent / "docs" / "faults.md"


def main() -> None:
    """Fly, write the page, tell what is not right."""
    cases = cases_named(sys.argv[sys.argv.index("--case") + 1]) if "--case" in sys.argv else DECK
    jobs = int(sys.argv[1]) if sys.argv[1:2] and sys.argv[1].isdigit() else os.cpu_count() or 1
    found: list[Row] = []
    for row in rows(cases, LEVELS[:1] if "--rates" in sys.argv else LEVELS, jobs):
        found.append(row)
        if row.wrong or "--case" in sys.argv:
            print(f"{row.name}, {row.level.value}: {'; '.join(row.wrong) or row.ended}", flush=True)
    wrong = sum(bool(row.wrong) for row in found)
    print(f"{len(found)} flights, {wrong} not as they must be")
    if cases is DECK:
        PAGE.write_text(page(found), encoding="utf-8")
    raise SystemExit(bool(wrong))


if __name__ == "__main__":
    main()
