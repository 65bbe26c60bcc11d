"""The margin under the failure detector: nothing where the tilt stays away from it, wider by what comes near."""

from __future__ import annotations

import math

import pytest

from companion.config.vehicle import load_vehicle
from companion.estimation.predictor import ForceModel
from companion.steering.shared import capability_of
from companion.steering.tilt_margin import GROWTH, MARGIN_MAX, NARROWING_TIME, NEAR_DETECTOR, update_tilt_margin

LIMITS = load_vehicle("x500").limits
assert LIMITS is not None
NEAR = LIMITS.failure_detector - NEAR_DETECTOR
DT = 0.008


def margin_after(margin: float, tilt: float, seconds: float) -> float:
    for _ in range(round(seconds / DT)):
        margin = update_tilt_margin(margin, tilt, LIMITS, DT)
    return margin


def test_no_margin_where_the_tilt_stays_away_or_nothing_is_known_of_the_vehicle() -> None:
    assert margin_after(0.0, NEAR - 0.001, 60.0) == 0.0
    assert update_tilt_margin(0.0, 1.5, None, DT) == 0.0


def test_it_grows_by_what_is_too_near_and_narrows_slowly() -> None:
    grown = margin_after(0.0, NEAR + math.radians(2.0), 1.0)
    assert grown == pytest.approx(GROWTH * math.radians(2.0), rel=0.03)
    assert margin_after(grown, 0.8, NARROWING_TIME) == pytest.approx(grown / math.e, rel=0.01)
    assert margin_after(0.0, 1.5, 120.0) == MARGIN_MAX


def test_a_take_off_does_not_narrow_it() -> None:
    """It once had: what was kept for the first steep lean was half gone where a flight came to its speed."""
    assert margin_after(0.05, 0.2, 60.0) == 0.05


def test_the_steepest_tilt_of_a_path_is_less_by_it() -> None:
    forces = ForceModel(1.0, 0.0, (0.0, 0.0, 0.0), 9.81)
    steepest = math.tan(math.radians(52.0))
    assert capability_of(forces, 20.0, steepest, 0.0).tan_tilt_max == steepest
    assert capability_of(forces, 20.0, steepest, math.radians(2.0)).tan_tilt_max == pytest.approx(
        math.tan(math.radians(50.0))
    )
    assert capability_of(forces, 20.0, math.inf, math.radians(2.0)).tan_tilt_max == pytest.approx(
        math.tan(math.radians(88.0))
    )
