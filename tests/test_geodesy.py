"""PX4's map projection against known properties of the azimuthal equidistant projection on a sphere."""

from __future__ import annotations

import math
import random

import pytest

from companion.geodesy import EARTH_RADIUS, MapProjection

ZURICH = MapProjection(47.397742, 8.545594)


def test_there_and_back() -> None:
    rng = random.Random(3)
    for _ in range(500):
        projection = MapProjection(rng.uniform(-80.0, 80.0), rng.uniform(-180.0, 180.0))
        north, east = (rng.choice((1.0, 1e2, 1e4, 1e5)) * rng.uniform(-1.0, 1.0) for _ in range(2))
        assert projection.project(*projection.reproject(north, east)) == pytest.approx((north, east), abs=2e-6)


def test_the_reference_is_the_origin() -> None:
    assert ZURICH.project(47.397742, 8.545594) == (0.0, 0.0)
    assert ZURICH.reproject(0.0, 0.0) == (47.397742, 8.545594)


def test_the_meridian_is_true_to_scale() -> None:
    north, east = ZURICH.project(48.397742, 8.545594)
    assert north == pytest.approx(EARTH_RADIUS * math.radians(1.0))
    assert east == pytest.approx(0.0, abs=1e-9)


def test_distance_and_bearing_from_the_reference_are_true() -> None:
    """Against the haversine and the great circle's initial bearing, written down independently."""
    rng = random.Random(4)
    for _ in range(200):
        lat, lon = 47.397742 + rng.uniform(-2.0, 2.0), 8.545594 + rng.uniform(-3.0, 3.0)
        a, b, turn = math.radians(47.397742), math.radians(lat), math.radians(lon - 8.545594)
        haversine = math.sin((b - a) / 2.0) ** 2 + math.cos(a) * math.cos(b) * math.sin(turn / 2.0) ** 2
        bearing = math.atan2(
            math.sin(turn) * math.cos(b), math.cos(a) * math.sin(b) - math.sin(a) * math.cos(b) * math.cos(turn)
        )
        north, east = ZURICH.project(lat, lon)
        assert math.hypot(north, east) == pytest.approx(2.0 * EARTH_RADIUS * math.asin(math.sqrt(haversine)), rel=1e-9)
        assert math.atan2(east, north) == pytest.approx(bearing, abs=1e-9)


def test_small_steps_east_shrink_with_the_cosine_of_the_latitude() -> None:
    _, east = ZURICH.project(47.397742, 8.546594)
    assert east == pytest.approx(EARTH_RADIUS * math.cos(math.radians(47.397742)) * math.radians(0.001), rel=1e-8)


def test_across_the_date_line() -> None:
    projection = MapProjection(-17.0, 179.9999)
    north, east = projection.project(-17.0, -179.9999)
    assert east == pytest.approx(EARTH_RADIUS * math.cos(math.radians(17.0)) * math.radians(0.0002), rel=1e-6)
    assert projection.reproject(north, east) == pytest.approx((-17.0, -179.9999))
