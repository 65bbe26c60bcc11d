"""Where a vehicle may be: signed distances to polygons and circles."""

from __future__ import annotations

import math
import random

import pytest

from companion.fence import Circle, Fence, Polygon
from companion.paths.placement import Placement

SQUARE = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
NOTCHED = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (5.0, 4.0), (0.0, 10.0))


@pytest.mark.parametrize(
    ("x", "y", "margin"),
    [(5, 5, 5), (5, 1, 1), (5, -1, -1), (12, 5, -2), (13, 14, -5), (0, 0, 0), (10, 5, 0), (-3, -4, -5)],
)
def test_a_square(x: float, y: float, margin: float) -> None:
    assert Polygon(SQUARE).margin(x, y) == pytest.approx(margin)
    assert Polygon(SQUARE, inside=False).margin(x, y) == pytest.approx(-margin)
    assert Polygon(SQUARE[::-1]).margin(x, y) == pytest.approx(margin)


def test_a_polygon_with_a_notch() -> None:
    assert Polygon(NOTCHED).margin(5.0, 9.0) < 0.0  # in the notch
    assert Polygon(NOTCHED).margin(1.0, 7.0) > 0.0


def test_a_polygon_against_its_edges_sampled_finely() -> None:
    rng = random.Random(3)
    edges = [
        (a[0] + t / 400 * (b[0] - a[0]), a[1] + t / 400 * (b[1] - a[1]))
        for a, b in zip(NOTCHED, (*NOTCHED[1:], NOTCHED[0]), strict=True)
        for t in range(400)
    ]
    for _ in range(100):
        x, y = rng.uniform(-5.0, 15.0), rng.uniform(-5.0, 15.0)
        nearest = min(math.hypot(x - u, y - v) for u, v in edges)
        assert abs(Polygon(NOTCHED).margin(x, y)) == pytest.approx(nearest, abs=0.03)


def test_a_circle() -> None:
    assert Circle((1.0, 2.0), 5.0).margin(4.0, 6.0) == pytest.approx(0.0)
    assert Circle((1.0, 2.0), 5.0).margin(1.0, 2.0) == 5.0
    assert Circle((1.0, 2.0), 5.0, inside=False).margin(1.0, 12.0) == 5.0


def test_every_area_counts() -> None:
    fence = Fence((Polygon(SQUARE), Circle((8.0, 8.0), 1.0, inside=False)))
    assert fence.nearest((5.0, 2.0, -9.0)) == (2.0, fence.areas[0])
    margin, area = fence.nearest((8.0, 8.5, 0.0))
    assert (margin, area) == (-0.5, fence.areas[1])
    assert "1 m to stay out of" in area.words if area is not None else False
    assert Fence(()).margin((0.0, 0.0, 0.0)) == math.inf


def test_a_fence_moves_with_its_mission() -> None:
    placement = Placement((3.0, 4.0, -2.0), turn=math.radians(30.0), enu=True)
    fence = Fence((Polygon(NOTCHED), Circle((2.0, 1.0), 3.0, inside=False)))
    moved = fence.moved(placement.to_local)
    rng = random.Random(1)
    for _ in range(50):
        p = (rng.uniform(-5.0, 15.0), rng.uniform(-5.0, 15.0), rng.uniform(0.0, 20.0))
        assert moved.margin(placement.to_local(p)) == pytest.approx(fence.margin(p), abs=1e-9)
