"""The deck of fault flights: each case at one level, a seeded tenth at the others; and a slice of the fuzz."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from companion.daemon import preparing
from companion.flight.phases import PHASES, Phase
from companion.vehicle import OutputLevel
from trials.faults import table
from trials.faults.case import Case
from trials.faults.deck import DECK
from trials.faults.deck.seen import SEEN
from trials.faults.flying import fly
from trials.faults.fuzz import tried
from trials.faults.table import flown_over_udp
from trials.faults.verdict import wrong

OTHERS = [
    (case, level)
    for case in DECK
    for level in case.levels[1:]
    if random.Random(f"other levels {case.name} {level.value}").random() < 0.1
]
"""A seeded tenth at the other levels: one case more or less changes none of the rest."""
SOON = 20.0
"""s."""
UNANSWERED = "COMMAND_ACK never heard"
"""What is asked for in vain takes 40 s until the flight begins all the same: it has the whole time."""
FUZZED = range(1, 6)


@pytest.fixture(autouse=True)
def soon(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a flight lacks is waited for 20 s here, in a third of the time; ``python -m bench.faults`` waits it out."""
    if UNANSWERED in request.node.name:
        return
    monkeypatch.setitem(PHASES, Phase.PREFLIGHT, replace(PHASES[Phase.PREFLIGHT], time_out=SOON))
    monkeypatch.setattr(preparing, "GIVEN_UP_AFTER", SOON)


def test_the_deck_has_what_it_needs() -> None:
    assert len(DECK) >= 60
    assert len({case.name for case in DECK}) == len(DECK)
    assert {name for names in SEEN.values() for name in names} <= {case.name for case in DECK}


def test_a_vehicle_s_process_that_dies_is_a_row_and_no_end_to_the_flights_after_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def die(*_: object) -> None:
        raise EOFError

    monkeypatch.setattr(table, "fly_over_udp", die)
    row = flown_over_udp(DECK[0], OutputLevel.RATES)
    assert row.udp and row.ended == "an exception" and row.wrong == ("EOFError",)


@pytest.mark.parametrize("case", DECK, ids=lambda case: case.name)
def test_a_fault_ends_as_it_must(case: Case) -> None:
    assert wrong(fly(case, case.levels[0])) == []


@pytest.mark.parametrize(("case", "level"), OTHERS, ids=lambda part: getattr(part, "name", ""))
def test_and_at_another_level(case: Case, level: OutputLevel) -> None:
    assert wrong(fly(case, level)) == []


@pytest.mark.parametrize("seed", FUZZED)
def test_no_rule_is_broken_whatever_happens(seed: int) -> None:
    assert tried(seed).broken == ()
