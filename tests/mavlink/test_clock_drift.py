"""How late a state is: drift of the clocks is followed, a delay that grows is not taken for it."""

from __future__ import annotations

import itertools

import pytest

from companion.mavlink.clock import STOOD_FOR, VehicleClock

STEP = 0.02
"""s between two states."""


def flown(pace: float, down: float, growth: float, seconds: float, clock: VehicleClock | None = None) -> list[float]:
    """What is said to be late, state by state. ``rate``: s of the vehicle's clock a second; ``down``: s of the way down,
    ``growth``: s more of it a second."""
    clock = clock or VehicleClock()
    clock.may_restart = False
    late = []
    for i in range(int(seconds / STEP)):
        sent = i * STEP
        now = sent + down + growth * sent
        if i % 12 == 0:
            clock.synchronise(sent - 0.01, 100.0 + pace * sent, now)
        late.append(clock.late(100.0 + pace * sent, now))
    return late


@pytest.mark.parametrize("pace", [0.95, 0.99, 1.0, 1.01])
def test_clocks_that_drift_apart_are_no_delay(pace: float) -> None:
    assert max(flown(pace, 0.02, 0.0, 60.0)) < 0.03


@pytest.mark.parametrize("growth", [0.01, 0.05, 0.1])
@pytest.mark.parametrize("pace", [0.97, 1.0])
def test_a_delay_that_grows_is_not_taken_for_drift(growth: float, pace: float) -> None:
    seconds = 20.0
    late = flown(pace, 0.02, growth, seconds)
    assert late[-1] == pytest.approx(growth * seconds, abs=0.03 + 0.02 * growth * seconds)
    assert all(b >= a - 0.02 for a, b in itertools.pairwise(late))


def test_drift_is_believed_up_to_a_bound() -> None:
    """A clock that falls behind by a fifth is none that a vehicle has: what it sends counts as late."""
    assert flown(0.8, 0.02, 0.0, 10.0)[-1] > 1.0


def test_a_vehicle_that_was_started_anew_is_taken_again_while_nothing_flies() -> None:
    for may, restarts in ((True, 1), (False, 0)):
        clock = VehicleClock()
        for i in range(100):
            clock.late(500.0 + i * STEP, i * STEP)
        clock.may_restart = may
        late = [clock.late(1.0 + i * STEP, 2.0 + i * STEP) for i in range(int(2.0 * STOOD_FOR / STEP))]
        assert late[0] > 400.0
        assert clock.restarts == restarts
        assert (late[-1] < 0.01) is may
