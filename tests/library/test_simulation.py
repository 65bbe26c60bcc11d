"""What the daemon is told for a simulated flight."""

from __future__ import annotations

import pytest

from companion.library.orders import read_sortie
from companion.library.output import Output
from companion.library.simulation import DEFAULT_DURATION, SimulatedFlight, orders_of
from companion.record.circumstances import SimulatedWorld
from companion.world import World


@pytest.mark.parametrize(
    ("mission", "duration"),
    [("circle_r5", DEFAULT_DURATION), ("line", DEFAULT_DURATION), ("survey", None)],
    ids=["round", "back and forth", "open"],
)
def test_a_flight_without_an_end_of_its_own_is_given_one(mission: str, duration: float | None) -> None:
    sortie = read_sortie(mission, None, Output.RATES, direct=True)
    flight = SimulatedFlight(sortie, SimulatedWorld(World(), "ideal", "", 0), from_ground=False, duration=None)
    assert orders_of(flight).duration == duration
