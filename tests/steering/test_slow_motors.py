"""Motors slower than the vehicle file says: the thrust does not swing with them."""

from __future__ import annotations

import pytest

from companion.daemon.conductor import Conductor
from companion.flight.phases import Phase
from companion.world import Deviations
from sim_bridge.plant import Truth
from trials.measured import course, machine, measure_flight, world


def test_the_thrust_does_not_swing_with_motors_that_are_slower_than_told() -> None:
    """60 ms instead of 25. Reckoned with as told, the thrust swung at 6 Hz, for 70 % of the time as fast as it may."""
    where = world("sih_noisy", truth=Deviations(motor_lag=0.06))
    told = machine("sih", motor_lag=0.025)
    slopes: list[float] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        steered = conductor.last.outcome.steered if conductor.last is not None else None
        if steered is not None and conductor.memory is not None and conductor.memory.phase is Phase.FOLLOW:
            slopes.append(steered.zeta_dot / told.weight)

    done = measure_flight(course("circle_r5", 3.0), told, where, seed=1, duration=12.0, settle=6.0, watch=watch)
    assert done.reason is None
    late = slopes[len(slopes) // 2 :]
    assert (sum(slope * slope for slope in late) / len(late)) ** 0.5 < 1.2


@pytest.mark.parametrize("told", [0.0, 0.1])
def test_a_lag_that_is_far_off_is_found_all_the_same(told: float) -> None:
    """0 is what a vehicle file says that says nothing of it."""
    done = measure_flight(
        course("circle_r5", 3.0), machine("sih", motor_lag=told), world("sih_noisy"), seed=2, duration=12.0, settle=8.0
    )
    assert done.reason is None
    assert done.believed is not None and done.believed.path < 0.05
