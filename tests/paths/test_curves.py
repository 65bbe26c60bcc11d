"""Every kind of curve: the formula it stands for, its derivatives, how its pieces join, where its nearest point is."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from companion.calculus.expression import parse as expression
from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.frames import Vec3
from companion.paths.curve import Curve, Shape
from companion.paths.formula import written
from companion.paths.lissajous import lissajous
from companion.paths.placement import Placement
from companion.paths.polyline import line, polyline
from companion.paths.round import circle, ellipse, helix
from companion.paths.spline import spline
from trials.measured import course

Array = NDArray[np.float64]
UP: Vec3 = (0.0, 0.0, 1.0)
POINTS: list[Vec3] = [(0, 0, 10), (14, 4, 12), (22, 16, 15), (10, 24, 13), (-4, 20, 11), (-8, 8, 10)]


def trefoil() -> Curve:
    texts = ("r*(sin(u) + 2*sin(2*u))", "r*(cos(u) - 2*cos(2*u))", "13 - 2*sin(3*u)")
    x, y, z = (expression(text, ("u", "r")) for text in texts)
    return Curve(Shape(written(x, y, z, {"r": 4.0}), 0.0, math.tau, True))


CURVES: dict[str, Curve] = {
    "circle": circle((1, 2, 3), 6.0, (0.2, 0.1, 1.0), UP),
    "ellipse": ellipse((1, 2, 3), 5.0, 9.0, (0.0, -0.33, 1.0), UP),
    "lissajous": lissajous((0, 0, 12), (6, 3, 1.5), (1, 2, 1), (0.5 * math.pi, 0.0, 0.0)),
    "line": line((0, 0, 10), (60, 67, 16)),
    "polyline, open": polyline(POINTS, closed=False, tolerance=0.8),
    "polyline, closed": polyline(POINTS, closed=True, tolerance=0.8),
    "spline, open": spline(POINTS, closed=False),
    "spline, closed": spline(POINTS, closed=True),
    "helix": helix((0, 0, 10), 7.0, 2.0, 5.0, UP),
    "expression": trefoil(),
}
every_kind = pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES.keys())
PLACED = Placement((5.0, -3.0, -2.0), 0.7, True)


def derivatives(curve: Curve, u: float) -> Array:
    return np.array(curve.at(u))


def inner(curve: Curve, count: int, seed: int = 1) -> list[float]:
    """Parameters away from the joints."""
    begin, end = curve.shape.begin, curve.shape.end
    rng = random.Random(seed)
    joints = np.array([begin, *curve.shape.breaks, end])
    wanted = (rng.uniform(begin, end) for _ in itertools.count())
    return list(itertools.islice((u for u in wanted if np.abs(joints - u).min() > 2e-2 * (end - begin) / 20), count))


@every_kind
def test_derivatives_are_those_of_the_point(curve: Curve) -> None:
    """Each derivative is the central difference of the one before, of sixth order in the step."""
    h = 1e-3 * (curve.shape.end - curve.shape.begin) / 20.0 * 2.0
    weights = {1: 45.0 / 60.0, 2: -9.0 / 60.0, 3: 1.0 / 60.0}
    for u in inner(curve, 25):
        here = derivatives(curve, u)
        for k in range(4):
            slope = (
                sum(
                    w * (derivatives(curve, u + i * h)[k] - derivatives(curve, u - i * h)[k])
                    for i, w in weights.items()
                )
                / h
            )
            size = np.abs(here[k + 1]).max() + np.abs(here[k]).max() / (curve.shape.end - curve.shape.begin)
            assert np.abs(slope - here[k + 1]).max() < 1e-7 * size + 1e-9, k


@pytest.mark.parametrize("order", range(5))
def test_round_curves_are_their_formulas(order: int) -> None:
    """Circle, helix and Lissajous curve, with every derivative written out."""
    turn = 0.5 * math.pi * order
    level, tower = circle((1, 2, 3), 6.0, (0, 0, 1), UP), helix((1, 2, 3), 7.0, 2.0, 5.0, UP)
    eight = lissajous((0, 0, 12), (6, 3, 1.5), (1, 2, 3), (0.3, 0.0, -0.2))
    for u in np.linspace(0.1, 6.1, 17):
        c, s = math.cos(u + turn), math.sin(u + turn)
        first = order == 0
        climb = [3.0 + 2.0 * u / math.tau, 2.0 / math.tau, 0.0, 0.0, 0.0][order]
        assert level.at(u)[order] == pytest.approx((6 * c + first, -6 * s + 2 * first, 3 * first), abs=1e-12)
        assert tower.at(u)[order] == pytest.approx((7 * c + first, -7 * s + 2 * first, climb), abs=1e-12)
        swing = [a * f**order * math.sin(f * u + p + turn) for a, f, p in ((6, 1, 0.3), (3, 2, 0.0), (1.5, 3, -0.2))]
        assert eight.at(u)[order] == pytest.approx((swing[0], swing[1], swing[2] + 12 * first), abs=1e-11)


@every_kind
def test_a_curve_over_its_arc_length_moves_at_one_metre_a_metre(curve: Curve) -> None:
    """|c'| = 1, and what follows from it by differentiating: c'.c'' = 0, c''.c'' + c'.c''' = 0, 3 c''.c''' + c'.c'''' = 0."""
    _, c1, c2, c3, c4 = curve.over_arc(np.linspace(0.0, curve.table.length, 301))

    def dot(a: Array, b: Array) -> Array:
        return np.sum(a * b, axis=0)

    size = 1.0 + np.abs(dot(c2, c3)).max() + np.abs(dot(c4, c4)).max() ** 0.5
    assert np.abs(dot(c1, c1) - 1.0).max() < 1e-12
    assert np.abs(dot(c1, c2)).max() < 1e-11 * size
    assert np.abs(dot(c2, c2) + dot(c1, c3)).max() < 1e-10 * size
    assert np.abs(3.0 * dot(c2, c3) + dot(c1, c4)).max() < 1e-9 * size


@every_kind
def test_four_derivatives_join_at_every_joint(curve: Curve) -> None:
    """C^4 in arc length at the waypoints, the corners' ends, and where the path closes."""
    begin, end = curve.shape.begin, curve.shape.end
    step = 1e-9 * (end - begin)
    joints = [(u - step, u + step) for u in curve.shape.breaks]
    if curve.closed:
        joints.append((end - step, begin + step))
    scale = curve.table.length / 20.0
    for before, after in joints:
        u = np.array([before, after])
        across = curve.over_arc(np.array([curve.arc(float(x)) for x in u]))
        for k in range(5):
            bend = scale ** max(k - 1, 0) * np.abs(across[k, :, 1] - across[k, :, 0]).max()
            assert bend < 2e-5, (k, before)


@every_kind
def test_arc_length_is_the_integral_of_the_speed(curve: Curve) -> None:
    for a, b in itertools.pairwise(np.linspace(curve.shape.begin, curve.shape.end, 6)):
        breaks = [u for u in curve.shape.breaks if a < u < b]
        length, _ = quad(
            lambda u: float(np.linalg.norm(curve.at(u)[1])), a, b, points=breaks or None, limit=200, epsabs=1e-10
        )
        top = curve.table.length if b == curve.shape.end else curve.arc(b)
        assert top - curve.arc(a) == pytest.approx(length, abs=1e-7)
    for s in np.linspace(0.0, 0.999 * curve.table.length, 40):
        assert curve.arc(curve.parameter(float(s))) == pytest.approx(s, abs=1e-9)


@every_kind
def test_the_table_lies_on_the_curve_wherever_it_is_placed(curve: Curve) -> None:
    moved = curve.placed(PLACED)
    for s in np.linspace(0.0, 0.9999 * curve.table.length, 60):
        u = curve.parameter(float(s))
        assert curve.table.at(float(s))[0] == pytest.approx(curve.at(u)[0], abs=1e-6)
        assert moved.table.at(float(s))[0] == pytest.approx(PLACED.to_local(curve.at(u)[0]), abs=1e-6)
        for k in range(1, 5):
            assert moved.at(u)[k] == pytest.approx(PLACED.turned(curve.at(u)[k]), abs=1e-9, rel=1e-12)


@every_kind
def test_the_nearest_point_is_the_nearest(curve: Curve) -> None:
    """Against a fine search, from a start some way off; and the global search from nowhere."""
    rng = random.Random(4)
    _, points = curve.table.samples(20_001)
    for _ in range(25):
        s = rng.uniform(0.0, curve.table.length)
        x, _, bend = curve.table.at(s)
        away = min(1.0, 0.3 / max(np.linalg.norm(bend), 1e-9))
        p: Vec3 = tuple(c + away * rng.uniform(-1, 1) / math.sqrt(3) for c in x)  # type: ignore[assignment]
        distances = np.linalg.norm(points - np.array(p), axis=1)
        u, there = curve.closest(p, curve.parameter(curve.table.within(s + rng.uniform(-1.0, 1.0))))
        assert math.dist(p, there[0]) <= distances.min() + 1e-6
        inside = curve.shape.begin < u < curve.shape.end
        if inside or curve.closed:
            off = (np.array(p) - there[0]) @ there[1] / np.linalg.norm(there[1])
            assert abs(off) < 1e-8
        found, distance = curve.table.locate(p)
        assert -1e-2 < distance - distances.min() < 1e-9
        assert math.dist(p, curve.table.at(found)[0]) == pytest.approx(distance, abs=1e-9)


def test_round_paths_run_clockwise_seen_from_above_in_every_frame() -> None:
    for text in (
        "{kind: circle, center: [0, 0, Z], radius: 5}",
        "{kind: circle, center: [0, 0, Z], radius: 5, normal: [0.3, 0.2, -1]}",
        "{kind: ellipse, center: [0, 0, Z], axes: [5, 8], normal: [0, 0.4, 1]}",
        "{kind: helix, center: [0, 0, Z], radius: 5, pitch: 1, turns: 2}",
    ):
        for frame, z in (("ned", "-10"), ("enu", "10")):
            file = f"mission: m\nframe: {frame}\npath: {text.replace('Z', z)}\nspeed: 2\n"
            curve = mission_from(parse(file, "m.yaml"), None).path
            assert isinstance(curve, Curve)
            c = curve.over_arc(np.linspace(0.0, 0.99 * curve.table.length, 40))
            turning = c[1, 0] * c[2, 1] - c[1, 1] * c[2, 0]  # heading's rate over distance: north, east
            assert (turning > 0.0).all(), (text, frame)


def test_a_helix_climbs_in_every_frame() -> None:
    for frame, z in (("ned", "-10"), ("enu", "10")):
        text = f"mission: m\nframe: {frame}\npath: {{kind: helix, center: [0, 0, {z}], radius: 5, pitch: 3, turns: 2}}\nspeed: 2\n"
        table = mission_from(parse(text, "m.yaml"), None).table
        assert (-table.at(0.0)[0][2], -table.at(table.length)[0][2]) == pytest.approx((10.0, 16.0))
        assert table.length == pytest.approx(2.0 * math.hypot(math.tau * 5.0, 3.0), rel=1e-9)


@pytest.mark.parametrize("tolerance", [0.05, 0.5, 2.0])
def test_corners_are_passed_within_their_tolerance(tolerance: float) -> None:
    """Exactly at the tolerance where the legs leave room, nearer where they do not; and straight between."""
    curve = polyline(POINTS, closed=True, tolerance=tolerance)
    legs = [math.dist(a, b) for a, b in zip(POINTS, [*POINTS[1:], POINTS[0]], strict=True)]
    for i, corner in enumerate(POINTS):
        _, distance = curve.table.locate(corner)
        assert distance <= tolerance + 1e-6
        a, b = (np.array(POINTS[j % 6], float) - corner for j in (i - 1, i + 1))
        turn = math.pi - math.acos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))
        reach = tolerance * 256.0 / 35.0 / 2.0 / math.sin(0.5 * turn)
        if reach < 0.49 * min(legs[i - 1], legs[i]):
            assert distance == pytest.approx(tolerance, abs=1e-5)
    for a, b in zip(POINTS, [*POINTS[1:], POINTS[0]], strict=True):
        middle: Vec3 = tuple(0.5 * (p + q) for p, q in zip(a, b, strict=True))  # type: ignore[assignment]
        assert curve.table.locate(middle)[1] < 1e-6


def test_a_spline_passes_its_points() -> None:
    for closed in (False, True):
        curve = spline(POINTS, closed)
        for point in POINTS:
            assert curve.table.locate(point)[1] < 1e-6
    ends = spline(POINTS, False).over_arc(np.array([0.0, spline(POINTS, False).table.length]))
    assert pytest.approx(np.array([POINTS[0], POINTS[-1]], float), abs=1e-9) == ends[0].T


def test_the_nearest_point_keeps_its_branch_through_a_crossing() -> None:
    """A vehicle flies a figure-eight, half a metre off: at the crossing the other branch is nearer, and not taken."""
    curve = lissajous((0, 0, 12), (6, 3, 0), (1, 2, 1), (0.5 * math.pi, 0.0, 0.0))
    u, s = 0.0, 0.0
    for at in np.linspace(0.0, curve.table.length, 800):
        x, T, _ = curve.table.at(float(at))
        p = (x[0] - 0.5 * T[1], x[1] + 0.5 * T[0], x[2])
        u, there = curve.closest(p, u)
        s, distance = curve.table.nearest(p, s, 3.0)
        assert abs(curve.table.difference(curve.arc(u), float(at))) < 1e-3
        assert abs(curve.table.difference(s, float(at))) < 1e-3
        assert distance == pytest.approx(math.dist(p, there[0]), abs=1e-6)


def test_the_nearest_point_moves_no_farther_than_it_may() -> None:
    """A vehicle carried to the far side is not found there at once: the search is downhill and limited."""
    curve = CURVES["line"]
    far = curve.table.at(curve.table.length)[0]
    s, _ = curve.table.nearest(far, 10.0, 3.0)
    assert s == pytest.approx(13.0)
    assert curve.table.locate(far)[0] == pytest.approx(curve.table.length)


def test_open_ends_hold_the_nearest_point() -> None:
    curve = CURVES["line"]
    (x, y, z), T, _ = curve.table.at(curve.table.length)
    beyond = (x + 4.0 * T[0], y + 4.0 * T[1], z + 4.0 * T[2])
    u, there = curve.closest(beyond, curve.shape.end)
    assert u == curve.shape.end
    assert there[0] == pytest.approx((x, y, z))
    assert curve.table.nearest(beyond, curve.table.length, 3.0) == pytest.approx((curve.table.length, 4.0))


FAULTS = {
    "kind: expression, x: u, y: 0, z: 10, u: [0, 5], closed: true": "does not close: its ends are 5 m apart",
    "kind: expression, x: u, y: abs(u), z: 10, u: [-5, 5]": "has a corner at x",
    "kind: expression, x: u**3, y: 0, z: 10, u: [-2, 2]": "stops at x",
    "kind: expression, x: u**2, y: u**3, z: 10, u: [-2, 2]": "stops at x",
    "kind: expression, x: 1, y: 2, z: 3, u: [-2, 2]": "stops at x 1.00, y 2.00, z 3.00",
    "kind: expression, x: sqrt(u), y: u, z: 10, u: [-2, 2]": "is not defined, or not finite, at u = -2",
    "kind: expression, x: u, y: 1/(u - 1), z: 10, u: [0, 2]": "is not defined, or not finite, at u = 1",
    "kind: expression, x: u*(1 - u), y: u*(1 - u)*(1 - 2*u), z: 10, u: [0, 1], closed: true": "has a corner where it closes",
    'kind: expression, x: "cos(u) + 0.01*u*(2*pi - u)*sin(u)", y: sin(u), z: 10, u: [0, 6.283185307179586], closed: true': "has a sudden bend where it closes",
    'kind: expression, x: "5000*(cos(u) + 0.001*u*(2*pi - u)*sin(u))", y: 5000*sin(u), z: 10, u: [0, 6.283185307179586], closed: true': "has a sudden bend where it closes",
    'kind: expression, x: "5000*(cos(u) + 1e-7*u**4*(2*pi - u)**5)", y: 5000*sin(u), z: 10, u: [0, 6.283185307179586], closed: true': "has a bend whose change changes suddenly where it closes",
    "kind: lissajous, center: [0, 0, 5], amplitude: [3, 3, 0], frequency: [1, 1, 0]": "stops at x 3.00, y 3.00",
    "kind: lissajous, center: [0, 0, 5], amplitude: [0, 0, 0], frequency: [1, 1, 1]": "it is a point",
    "kind: line, from: [0, 0, 5], to: [0, 0, 5]": "points 1 and 2 are the same",
    "kind: polyline, points: [[0, 0, 5], [9, 0, 5], [0, 0, 5]], corner_tolerance: 1": "turns back on itself at point 2",
    "kind: polyline, points: [[0, 0, 5], [9, 0, 5], [9, 0, 5]], corner_tolerance: 1": "points 2 and 3 are the same",
    "kind: spline, points: [[0, 0, 5], [9, 0, 5], [9, 0, 5], [3, 4, 5]], closed: true": "points 2 and 3 are the same",
    "kind: spline, points: [[0, 0, 5], [9, 0, 5]], closed: true": "expected three points at least",
}


@pytest.mark.parametrize(("path", "said"), FAULTS.items(), ids=lambda text: text[:40])
def test_what_is_no_path(path: str, said: str) -> None:
    with pytest.raises(ConfigError) as faults:
        mission_from(parse(f"mission: m\nframe: enu\npath: {{{path}}}\nspeed: 2\n", "m.yaml"), None)
    assert [str(fault).split(": ")[0] for fault in faults.value.faults] == ["m.yaml:3"]
    assert said in str(faults.value)


@pytest.mark.parametrize("leg", [100.0, 2000.0, 5000.0, 12_000.0, 20_000.0])
@pytest.mark.parametrize("tolerance", [0.3, 1.0])
def test_a_triangle_of_any_size_closes(leg: float, tolerance: float) -> None:
    """Of a long path the parameter's last digits, 2e-12 m of 15 km, move the fourth derivative where a corner ends by as
    much as a thousandth of what a circle of that length has: no jump."""
    triangle = [(0.0, 0.0, -50.0), (leg, 0.0, -50.0), (0.5 * leg, leg, -50.0)]
    assert polyline(triangle, True, tolerance).table.length == pytest.approx(leg * (1.0 + math.sqrt(5.0)), abs=8.0)


def test_ten_thousand_waypoints_cost_a_tick_no_more_than_ten() -> None:
    """The work of one tick, counted in evaluations: it does not grow with the number of waypoints."""
    rng = random.Random(3)
    counts = {}
    for size in (10, 10_000):
        points = [(5.0 * i, rng.uniform(-1, 1), 10.0 + rng.uniform(-1, 1)) for i in range(size)]
        curve = spline(points, closed=False)
        assert curve.table.length > 5.0 * (size - 1)
        calls = 0
        piecewise = curve._local

        def counted(u: float, piecewise: Callable[[float], object] = piecewise) -> object:
            nonlocal calls
            calls += 1
            return piecewise(u)

        object.__setattr__(curve, "_local", counted)
        for i in range(100):
            s = 22.0 + 0.02 * i
            x, y, z = curve.table.at(s)[0]
            curve.closest((x, y + 0.3, z), curve.parameter(s - 0.02))
        counts[size] = calls
    assert abs(counts[10_000] - counts[10]) <= 0.1 * counts[10]


@pytest.mark.parametrize("kind", ["polyline", "spline", "line", "lissajous", "helix"])
def test_what_is_said_of_a_place_is_pythons_own_floats(kind: str) -> None:
    """numpy's spread from a path's knots to every command, and a choice made by one of their comparisons is no bool."""
    curve = course(kind).path
    assert isinstance(curve, Curve)
    point, tangent, curvature = curve.table.at(1.0)
    u = curve.parameter(1.0)
    _, derivatives = curve.closest(point, u)
    said = (u, curve.arc(u), *point, *tangent, *curvature, *(x for each in derivatives for x in each))
    assert {type(each) for each in said} == {float}
