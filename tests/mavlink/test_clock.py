"""The vehicle's clock: how late a state is."""

from __future__ import annotations

import pytest

from companion.mavlink.clock import VehicleClock

PERIOD = 0.004


def test_what_passes_while_a_clock_may_stand_is_no_lateness() -> None:
    """A simulated vehicle whose clock stands until its first setpoint, on a computer that takes half a second for it."""
    clock = VehicleClock(may_stand=True)
    assert [clock.late(0.0, 10.0 + 0.1 * tick) for tick in range(6)] == [0.0] * 6
    assert clock.late(PERIOD, 10.5 + PERIOD) == pytest.approx(0.0, abs=1e-6)
    assert clock.late(2 * PERIOD, 10.5 + 2 * PERIOD + 0.15) == pytest.approx(0.15, abs=1e-3)


def test_once_it_ran_or_where_it_may_not_a_clock_that_stands_is_late() -> None:
    clock = VehicleClock(may_stand=True)
    for tick in range(3):
        clock.late(tick * PERIOD, 10.0 + tick * PERIOD)
    assert clock.late(2 * PERIOD, 10.4) == pytest.approx(0.4 - 2 * PERIOD, abs=1e-3)
    clock = VehicleClock()
    clock.late(0.0, 10.0)
    assert clock.late(0.0, 10.3) == pytest.approx(0.3, abs=1e-3)


@pytest.mark.parametrize(("clock_runs", "later", "told"), [(0.9, 0.0, 0.9), (1.0, 0.1, 1.0), (1.0, 0.0, 1.0)])
def test_a_clock_is_called_slow_only_where_timesync_proves_it(clock_runs: float, later: float, told: float) -> None:
    """``later``: s a second by which states come later and later, while the clock runs as it should."""
    clock = VehicleClock(may_restart=False)
    for tick in range(1500):
        now = 0.004 * tick
        clock.late(clock_runs * now, now + later * now)
        if tick % 62 == 0:
            clock.synchronise(now, clock_runs * (now + 0.001), now + 0.002)
    assert clock.rate == pytest.approx(told, abs=0.01)
