"""How a speed falls to rest at an open end."""

from __future__ import annotations

import pytest

from companion.profiles import ConstantSpeed, SpeedProfile, speed_table
from companion.profiles.ends import ACCELERATION, StoppingSpeed


@pytest.mark.parametrize("alpha", [5.0, 1.0, 0.3])
def test_no_braking_too_early_nor_too_hard(alpha: float) -> None:
    """Nothing before three braking distances; the deceleration at most a; no standstill before the end."""
    stopping = StoppingSpeed(ConstantSpeed(-alpha), 100.0, 1.0)
    braking = max(alpha * alpha / (2.0 * ACCELERATION), 2.0 * alpha)
    assert stopping.at(100.0 - 3.0 * braking)[0] == pytest.approx(-alpha, rel=0.01)
    assert stopping.at(100.0) == pytest.approx((0.0, 1.2, 0.576, 0.62208))
    for i in range(1, 1000):
        v, slope, _, _ = stopping.at(100.0 - 0.03 * i)
        assert v < 0.0
        assert -0.01 < v * slope * -1.0 < 1.1 * ACCELERATION


def test_its_derivatives_are_those_of_the_profile_too() -> None:
    profile: SpeedProfile = speed_table([(0.0, 1.0), (5.0, 4.0), (9.0, 2.0)], None)
    stopping = StoppingSpeed(profile, 0.0, -1.0)
    h = 1e-4
    for s in (0.3, 1.7, 4.2, 8.0):
        for k in range(3):
            slope = (stopping.at(s + h)[k] - stopping.at(s - h)[k]) / (2.0 * h)
            assert stopping.at(s)[k + 1] == pytest.approx(slope, rel=1e-5, abs=1e-6)
