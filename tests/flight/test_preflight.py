"""What is waited for before a flight."""

from __future__ import annotations

import pytest

from companion.flight.conduct import ControlAuthority, Finish, Limits
from companion.flight.preflight import PreflightInputs, missing
from companion.vehicle import KnownStatus, Landed, Mode


@pytest.mark.parametrize(
    ("rate", "said"),
    [
        (1.0, None), (0.95, None), (3.0, None), (None, "rate of the vehicle's clock is not known"),
        (0.8, "runs at 0.80 of real time, 0.94 is the least; the simulation is slower than real time"),
        (0.001, "microseconds of the vehicle's clock"), (1000.0, "microseconds of the vehicle's clock"),
    ],
)  # fmt: skip
def test_a_clock_that_cannot_be_flown_with_is_named(rate: float | None, said: str | None) -> None:
    inputs = PreflightInputs(KnownStatus(), ControlAuthority.PILOT, Finish.HOLD, Limits(), True, 100.0, clock_rate=rate)
    found = missing(inputs)
    assert found is None if said is None else found is not None and said in found


def test_a_mode_in_which_px4_does_not_arm_is_named() -> None:
    stands = KnownStatus(armed=False, mode=Mode.LAND, landed=Landed.ON_GROUND, ready=True)
    inputs = PreflightInputs(stands, ControlAuthority.COMPANION, Finish.HOLD, Limits(), True, 100.0)
    assert missing(inputs) == "the vehicle is in Land, in which it does not arm; select Hold or Position"
    assert missing(inputs._replace(status=stands._replace(mode=Mode.POSITION))) is None
    assert missing(inputs._replace(status=stands._replace(armed=True))) is None  # it lands; see NOT_OURS
