"""Curves h1 = h2 = 0 followed into arc-length tables."""

from __future__ import annotations

import math
import random
import time

import pytest
from scipy.special import ellipe

from companion.calculus.expression import parse
from companion.frames import Vec3
from companion.paths.implicit import ImplicitPath
from companion.paths.placement import Placement
from companion.paths.tracing import PathError


def path(h1: str, h2: str, near: Vec3, placement: Placement | None = None, **constants: float) -> ImplicitPath:
    names = ("x", "y", "z", *constants)
    return ImplicitPath(parse(h1, names), parse(h2, names), near, constants, placement or Placement())


def test_the_papers_circle() -> None:
    table = path("x**2 + y**2 - r**2", "z - z0", (0, 10, -20), r=10.0, z0=-20.0).table
    assert table.closed
    assert table.length == pytest.approx(20.0 * math.pi, abs=1e-8)
    for s in (0.0, 1.0, 17.3, 60.0, 62.8):
        (x, y, z), (tx, ty, tz), _ = table.at(s)
        assert (math.hypot(x, y), z) == pytest.approx((10.0, -20.0), abs=1e-9)
        # mu = (y, -x, 0)/r: counter-clockwise seen from above
        assert (tx, ty, tz) == pytest.approx((y / 10.0, -x / 10.0, 0.0), abs=1e-7)
        assert (x, y) == pytest.approx((10.0 * math.sin(s / 10.0), 10.0 * math.cos(s / 10.0)), abs=1e-8)


def test_an_ellipse_has_the_length_of_its_integral() -> None:
    table = path("(x/8)**2 + (y/5)**2 - 1", "z + 5", (8, 0, -5)).table
    assert table.length == pytest.approx(4.0 * 8.0 * ellipe(1.0 - (5.0 / 8.0) ** 2), abs=1e-7)


def test_nearest_point_and_distance() -> None:
    table = path("hypot(x, y) - 10", "z + 20", (10, 0, -20)).table
    rng = random.Random(1)
    for _ in range(200):
        around, out, up = rng.uniform(0, math.tau), rng.uniform(-6, 6), rng.uniform(-5, 5)
        p = ((10 + out) * math.cos(around), (10 + out) * math.sin(around), -20.0 + up)
        s, distance = table.locate(p)
        assert distance == pytest.approx(math.hypot(out, up), abs=1e-7)
        assert abs(table.difference(s, table.within(-10.0 * around))) < 1e-6
        follow, again = table.nearest(p, table.within(s + rng.uniform(-2, 2)))
        assert again == pytest.approx(distance, abs=1e-7)
        assert abs(table.difference(follow, s)) < 1e-5


def test_the_search_keeps_its_reach() -> None:
    table = path("hypot(x, y) - 10", "z", (10, 0, 0)).table
    s, _ = table.nearest((0.0, 10.0, 0.0), 0.0, reach=2.0)
    assert abs(table.difference(s, 0.0)) <= 2.0 + 1e-9


def test_the_component_that_is_meant() -> None:
    two = "(x**2 + y**2 - 25)*(x**2 + y**2 - 100)"
    assert path(two, "z + 5", (5.5, 0, -5)).table.length == pytest.approx(10 * math.pi, abs=1e-7)
    assert path(two, "z + 5", (9.0, 0, -5)).table.length == pytest.approx(20 * math.pi, abs=1e-7)


def test_a_far_near_point_finds_the_curve() -> None:
    assert path("x**2 + y**2 - 100", "z + 20", (3, 4, 0)).table.length == pytest.approx(20 * math.pi, abs=1e-7)


def test_placement_moves_and_turns_the_curve() -> None:
    """ENU, turned a quarter clockwise and moved: the same ellipse elsewhere."""
    there = Placement(origin_n=(100.0, -50.0, -3.0), turn=math.pi / 2, enu=True)
    table = path("(x/8)**2 + (y/5)**2 - 1", "z - 7", (8, 0, 7), there).table
    # x is east; turned clockwise it points south; z = 7 up is 10 above the local origin
    point = table.at(0.0)[0]
    assert point == pytest.approx((100.0 - 8.0, -50.0, -10.0), abs=1e-9)
    for p in ((3.0, 4.0, 5.0), (-7.0, 0.1, 2.0)):
        assert there.to_mission(there.to_local(p)) == pytest.approx(p)


@pytest.mark.parametrize(
    ("h1", "h2", "near", "said"),
    [
        ("y - x**2", "z + 5", (0, 0, -5), "does not close"),
        ("x", "z + 5", (0, 0, -5), "does not close"),
        (
            "(x**2 + y**2)**2 - 100*(x**2 - y**2)",
            "z + 5",
            (10, 0, -5),
            "past north -?0.00, east -?0.00.*crosses itself",
        ),
        ("abs(x) + abs(y) - 5", "z + 5", (3, 2, -5), "past north 5.00.*corner"),
        ("x**2 + y**2 + 1", "z + 5", (5, 0, -5), "no point near"),
        ("x**2 + y**2 - 4", "x**2 + y**2 - 4", (2, 0, -5), "nowhere regular"),
        ("x**2 + y**2 - 4", "2*(x**2 + y**2) - 8 + 0*z", (2, 0, -5), "regular"),
        ("x**2 + y**2 + z**2 - 25", "z + 5", (1, 0, -4), "not regular"),
        ("sqrt(x) - 2", "z", (-5, 0, 0), "not defined"),
        ("1/x - 1/(y*0)", "z", (1, 1, 0), "nowhere regular"),
        ("3", "z", (1, 1, 0), "nowhere regular"),
    ],
)
def test_what_is_no_path_is_said(h1: str, h2: str, near: Vec3, said: str) -> None:
    begun = time.process_time()
    with pytest.raises(PathError, match=said):
        _ = path(h1, h2, near).table
    assert time.process_time() - begun < 20.0  # a verdict, not a search for ever


def test_samples_run_from_end_to_end() -> None:
    table = path("hypot(x, y) - 10", "z", (10, 0, 0)).table
    s, points = table.samples(101)
    assert (s[0], s[-1]) == (0.0, table.length)
    for value, point in zip(s[:-1], points[:-1], strict=True):
        assert tuple(point) == pytest.approx(table.at(float(value))[0], abs=1e-12)
    assert tuple(points[-1]) == pytest.approx(table.at(0.0)[0], abs=1e-7)
