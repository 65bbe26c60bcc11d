"""The deck of fault flights: each case at one level, a seeded tenth at the others; and a slice of the fuzz."""

from __future__ import annotations

import pytest

from companion.vehicle import OutputLevel
from trials.faults.case import Case
from trials.faults.deck import DECK
from trials.faults.flying import fly
from trials.faults.fuzz import tried
from trials.faults.verdict import wrong

LONG = 90.0
"""s of the plant: what may take longer is flown by ``python -m bench.faults`` only."""
NOT_FLOWN = frozenset(
    {
        "attitude frozen but for 1e-6 of noise, joining",
        "attitude frozen but for 1e-3 of noise",
        "the operator's land in hand back",
        "the operator's land in take over, the downlink cut 1.1 s before",
        "the operator's land in join, the downlink cut 1.1 s before",
        "the operator's land in follow, the downlink cut 1.1 s before",
        "the operator's return in follow, the downlink cut 1.1 s before",
        "the operator's land in hand back, the downlink cut 1.1 s before",
        "the operator lands in abort, the downlink cut",
        "the downlink cut in join for 0.8 s, the operator returns",
    }
)
"""Cases whose end was not looked at since they were last changed: ``python -m bench.faults`` flies them too."""
FLOWN = [case for case in DECK if case.time_out <= LONG and case.name not in NOT_FLOWN]
AT_OTHER_LEVELS = (
    ("bytes gathered for 20 ms", OutputLevel.ATTITUDE),
    ("up to 60 ms of jitter each way", OutputLevel.ATTITUDE),
    ("ODOMETRY twice, 15 ms later", OutputLevel.MOTORS),
    ("the uplink cut for 0.15 s", OutputLevel.MOTORS),
)
OTHERS = [(next(case for case in DECK if case.name == name), level) for name, level in AT_OTHER_LEVELS]
FUZZED = range(1, 9)


def test_the_deck_has_what_it_needs() -> None:
    assert len(DECK) >= 60
    assert len({case.name for case in DECK}) == len(DECK)


@pytest.mark.parametrize("case", FLOWN, ids=lambda case: case.name)
def test_a_fault_ends_as_it_must(case: Case) -> None:
    assert wrong(fly(case, case.levels[0])) == []


@pytest.mark.parametrize(("case", "level"), OTHERS, ids=lambda part: getattr(part, "name", ""))
def test_and_at_another_level(case: Case, level: OutputLevel) -> None:
    assert wrong(fly(case, level)) == []


@pytest.mark.parametrize("seed", FUZZED)
def test_no_rule_is_broken_whatever_happens(seed: int) -> None:
    assert tried(seed).broken == ()
