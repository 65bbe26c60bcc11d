"""What is waited for before a flight."""

from __future__ import annotations

import pytest

from companion.flight.conduct import ControlAuthority, Finish, Limits
from companion.flight.preflight import Standing, missing
from companion.vehicle import KnownStatus


@pytest.mark.parametrize(
    ("pace", "said"),
    [
        (1.0, None), (0.95, None), (3.0, None), (None, "pace of the vehicle's clock is not known"),
        (0.8, "runs at 0.80 of real time, 0.94 is the least; the simulation is slower than real time"),
        (0.001, "microseconds of the vehicle's clock"), (1000.0, "microseconds of the vehicle's clock"),
    ],
)  # fmt: skip
def test_a_clock_that_cannot_be_flown_with_is_named(pace: float | None, said: str | None) -> None:
    standing = Standing(KnownStatus(), ControlAuthority.PILOT, Finish.HOLD, Limits(), True, 100.0, clock_pace=pace)
    found = missing(standing)
    assert found is None if said is None else found is not None and said in found
