"""Flights drawn from seeds until the time is over, each against the rules that hold whatever happens."""

from __future__ import annotations

import multiprocessing
import time
import traceback
from collections.abc import Iterator
from typing import NamedTuple

from companion.vehicle import OutputLevel
from trials.faults.case import Case
from trials.faults.flying import fly
from trials.faults.random_cases import TIME_OUT, drawn, simpler
from trials.faults.rules import broken

TRIES = 40
"""Flights that are spent on finding the simplest case that still breaks the same rule."""


class Result(NamedTuple):
    """A seed's flight: how long it was (s), how many messages were mutated, and what it broke; nothing where all is
    well."""

    seed: int
    flown: float
    mutated: int
    broken: tuple[str, ...]


def tried(seed: int) -> Result:
    """Fly a seed."""
    case, level = drawn(seed)
    return Result(seed, *_broken(case, level, seed))


def flights(first: int, seconds: float, jobs: int) -> Iterator[Result]:
    """Fly seed after seed for so many seconds of the clock, on so many processes."""
    ends = time.monotonic() + seconds

    def seeds() -> Iterator[int]:
        seed = first
        while time.monotonic() < ends:
            yield seed
            seed += 1

    if jobs == 1:
        yield from map(tried, seeds())
        return
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        waiting = []
        more = seeds()
        while True:
            while len(waiting) < 2 * jobs and (seed := next(more, None)) is not None:
                waiting.append(pool.apply_async(tried, (seed,)))
            if not waiting:
                return
            yield waiting.pop(0).get()


def simplest(seed: int, words: str) -> tuple[Case, OutputLevel]:
    """The simplest case that still breaks the rule that ``words`` begin with: what can go, one after another, goes."""
    case, level = drawn(seed)
    kind = _kind(words)
    tries = 0
    found = True
    while found and tries < TRIES:
        found = False
        for less in simpler(case):
            tries += 1
            if any(_kind(each) == kind for each in _broken(less, level, seed)[2]):
                case, found = less, True
                break
            if tries >= TRIES:
                break
    return case, level


def _broken(case: Case, level: OutputLevel, seed: int) -> tuple[float, int, tuple[str, ...]]:
    try:
        flight = fly(case, level, seed)
    except Exception:
        last = traceback.format_exc().strip().splitlines()
        return 0.0, 0, (f"an exception: {last[-1]} ({' '.join(last[-3].split())})",)
    return flight.done_at or TIME_OUT, flight.mutated, tuple(broken(flight))


def _kind(words: str) -> str:
    """What kind of rule: its words without the numbers."""
    return "".join(letter for letter in words.split(":")[0] if not letter.isdigit() and letter != ".")
