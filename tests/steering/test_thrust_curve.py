"""Thrust that is not proportional to its command: found within its doubt, and taken out of what is sent."""

from __future__ import annotations

import pytest

from trials.thrust_curve import LOOKED_AT, flown


@pytest.mark.parametrize(("mission", "speed", "curve"), [("circle_r5", 5.0, 0.0), ("figure8", 3.0, 0.3)])
def test_a_curve_is_found_within_its_doubt_in_ten_seconds(mission: str, speed: float, curve: float) -> None:
    done = flown(mission, speed, curve, seed=1, duration=16.0)
    slope, std = done.found[LOOKED_AT.index(10.0)]
    assert std < 0.09
    assert abs(slope - done.true) < 2.0 * std
    assert curve == 0.0 or slope > 0.08
    assert done.flight.reason is None and done.flight.believed is not None
    assert done.flight.believed.path < 0.03


def test_a_steep_curve_does_not_take_the_yaw_torque() -> None:
    """0.6 at 7 m/s: not looked for, the heading was off by 12 deg."""
    done = flown("circle_r5", 7.0, 0.6, seed=1, duration=25.0)
    assert done.flight.reason is None and done.flight.believed is not None
    assert done.flight.believed.yaw < 0.15
    assert done.flight.believed.path < 0.03
