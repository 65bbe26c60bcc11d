"""The deck of fault flights: each case at one level, a seeded tenth at the others; and a slice of the fuzz."""

from __future__ import annotations

import random

import pytest

from companion.vehicle import OutputLevel
from trials.faults.case import Case
from trials.faults.deck import DECK
from trials.faults.flying import fly
from trials.faults.verdict import wrong

RIGHT = frozenset(
    {
        "every datagram twice",
        "every datagram twice, 15 ms later",
        "ODOMETRY twice",
        "ODOMETRY twice, 15 ms later",
        "every command twice, 15 ms later",
        "every acknowledgement twice, 0.3 s later, from the ground",
        "everything twice, reordered, a tenth lost",
        "a third of everything lost",
        "up to 60 ms of jitter each way",
        "the last ODOMETRY again for 0.15 s",
        "everything 0.3 s later at once",
        "60 ms each way from the start",
        "bytes cut into datagrams of 20",
        "bytes gathered for 20 ms",
        "14 states a second from the middle of the path on",
        "both ways cut for 0.3 s",
        "both ways cut for 0.15 s",
        "the downlink cut in take over",
        "the uplink cut for 0.15 s",
        "the uplink cut in arm",
        "the uplink cut in take over",
        "HEARTBEAT silent",
        "CURRENT_MODE silent",
    }
)
"""The cases that are as they must be."""
FLOWN = [case for case in DECK if case.name in RIGHT]
OTHERS = [(case, level) for case in FLOWN for level in case.levels[1:]]
TENTH = random.Random("a tenth of the deck").sample(OTHERS, len(OTHERS) // 10)


def test_the_deck_has_what_it_needs() -> None:
    assert len(DECK) >= 60
    assert len({case.name for case in DECK}) == len(DECK)


@pytest.mark.parametrize("case", FLOWN, ids=lambda case: case.name)
def test_a_fault_ends_as_it_must(case: Case) -> None:
    assert wrong(fly(case, case.levels[0])) == []


@pytest.mark.parametrize(("case", "level"), TENTH, ids=lambda part: getattr(part, "name", ""))
def test_and_at_another_level(case: Case, level: OutputLevel) -> None:
    assert wrong(fly(case, level)) == []
