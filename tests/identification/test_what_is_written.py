"""Which findings go into a vehicle file, and what the file says of the others."""

from __future__ import annotations

import pytest

from companion.identification.description import Description, Source
from companion.identification.from_log import SPEED_WANTED, Findings, better_log, with_findings
from companion.identification.parameters import describe_parameters
from companion.identification.rate_fit import Found


@pytest.fixture
def base(found: Findings) -> Description:
    """What PX4's parameters in the log say."""
    return describe_parameters(found.log.parameters, name="mine")


def kept_line(text: str) -> str:
    """What the file says of what it did not take; empty where it took everything."""
    return next((line for line in text.splitlines() if "left as it was" in line), "")


def test_drag_of_a_slow_flight_stays_as_it_was(base: Description, found: Findings) -> None:
    """The advice and the file go by the same speed."""
    sure = found.forces._replace(drag=Found(0.3, 0.01))
    for speed, taken in ((0.5, False), (SPEED_WANTED, True)):
        flight = found._replace(forces=sure._replace(speed=speed))
        file = with_findings(base, flight, ())
        assert any("tell little of drag" in line for line in better_log(flight)) is not taken
        assert file.data["drag_per_s"] == (0.3 if taken else base.data["drag_per_s"])
        assert (file.entries["drag_per_s"].source is Source.LOG) is taken
        assert ("drag_per_s (0.3 +- 0.01; 0.5 m/s RMS, 2.5 tell it)" in kept_line(file.text)) is not taken
