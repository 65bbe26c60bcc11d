"""The deck of fault flights, flown and printed as the table of docs/faults.md.

    python -m bench.faults [JOBS]             the whole deck at every level; as many jobs as there are cores
    python -m bench.faults [JOBS] --rates     only at rates (or --attitude, --motors)
    python -m bench.faults --udp              of every kind that was seen one case, and some others, in real time
    python -m bench.faults --case WORDS       only the cases with these words in their name, and what is wrong with each
    python -m bench.faults --write            the page of what was flown so far, and nothing more flown

What was flown is kept in build/faults.jsonl and not flown again at the same commit: a run that was ended goes on where
it was, and levels may be flown one by one. Once every case was flown at each of its levels, the page is written.
Exit 1 where a flight is not as it must be.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

from trials.faults.case import LEVELS
from trials.faults.deck import DECK
from trials.faults.journal import Journal
from trials.faults.table import Row, cases_named, flights_of, flown_over_udp, over_udp, page, rows

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "faults.md"
JOURNAL = ROOT / "build" / "faults.jsonl"


def commit() -> str:
    """What is flown: the commit, or what differs from it too."""
    told = [subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout
            for words in (["rev-parse", "--short", "HEAD"], ["diff", "HEAD", "--", "*.py", "*.yaml"])]  # fmt: skip
    return told[0].strip() + (f" and changes {hash_of(told[1])}" if told[1] else "")


def hash_of(text: str) -> str:
    """A short name of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def main() -> None:
    """Fly, write the page, tell what is not right."""
    only = [level for level in LEVELS if f"--{level.value}" in sys.argv]
    jobs = int(sys.argv[1]) if sys.argv[1:2] and sys.argv[1].isdigit() else os.cpu_count() or 1
    if "--case" in sys.argv:
        cases = cases_named(sys.argv[sys.argv.index("--case") + 1])
        found = [told(row, always=True) for row in rows(flights_of(cases, only or LEVELS), jobs)]
        raise SystemExit(any(row.wrong for row in found))
    journal = Journal(JOURNAL, commit())
    if "--udp" in sys.argv:
        for flight in [flight for flight in over_udp() if not journal.has(flight, udp=True)]:
            journal.add(told(flown_over_udp(*flight)))
    elif "--write" not in sys.argv:
        for row in rows([flight for flight in flights_of(DECK, only or LEVELS) if not journal.has(flight)], jobs):
            journal.add(told(row))
    found = journal.rows
    wrong = sum(bool(row.wrong) for row in found)
    print(f"{len(found)} flights, {wrong} not as they must be")
    if "--write" in sys.argv or all(journal.has(flight) for flight in flights_of(DECK, LEVELS)):
        PAGE.write_text(page(found, journal.commit), encoding="utf-8")
    raise SystemExit(bool(wrong))


def told(row: Row, *, always: bool = False) -> Row:
    """The row, said where it is not right."""
    if row.wrong or always:
        print(f"{row.name}, {row.level.value}: {'; '.join(row.wrong) or row.ended}", flush=True)
    return row


if __name__ == "__main__":
    main()
