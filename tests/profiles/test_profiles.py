"""Speed and heading over the distance: smooth, monotone between samples, wrapped; and the fastest speed that is found."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable

import numpy as np
import pytest

from companion.calculus.expression import parse as expression
from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.config.vehicle import load_vehicle
from companion.feasibility.demand import compute_demand
from companion.feasibility.headroom import ACCELERATION, END_SPEED
from companion.feasibility.limits import quantities
from companion.feasibility.report import check
from companion.feasibility.stations import stations_along
from companion.frames import wrap
from companion.mission import Mission
from companion.profiles import Four, SpeedExpression, SpeedProfile, YawExpression, speed_table, yaw_table

X500 = load_vehicle("x500")
TABLE = [(0.0, 2.0), (10.0, 5.0), (12.0, 5.0), (30.0, 1.0), (34.0, 3.0)]


def mission(path: str, speed: object, yaw: object = 0.0) -> Mission:
    text = f"mission: m\nframe: enu\npath: {path}\nspeed: {speed}\nyaw: {yaw}\n"
    return mission_from(parse(text, "m.yaml"), None)


CIRCLE = "{kind: circle, center: [0, 0, 12], radius: 6}"
EIGHT = "{kind: lissajous, center: [0, 0, 12], amplitude: [7, 4, 1], frequency: [1, 2, 1], phase_deg: [90, 0, 0]}"
LEGS = "{kind: polyline, points: [[0, 0, 10], [20, 0, 10], [20, 15, 14], [45, 15, 14]], corner_tolerance: 1}"


def differs(at: Callable[[float], Four], s: float, h: float = 1e-4) -> float:
    """How far each derivative is from the central difference of the one before."""
    before, here, after = at(s - h), at(s), at(s + h)
    return max(abs((b - a) / (2.0 * h) - c) for a, b, c in zip(before[:3], after[:3], here[1:], strict=True))


@pytest.mark.parametrize("period", [None, 40.0])
def test_a_table_passes_its_samples_and_stays_between_them(period: float | None) -> None:
    profile = speed_table(TABLE, period)
    for s, v in TABLE:
        assert profile.at(s)[0] == pytest.approx(v, abs=1e-12)
    ends = [*TABLE, (40.0, 2.0)] if period else TABLE
    for (s0, v0), (s1, v1) in itertools.pairwise(ends):
        values = [profile.at(float(s))[0] for s in np.linspace(s0, s1, 60)]
        steps = np.diff(values) * math.copysign(1.0, v1 - v0)
        assert (steps > -1e-12).all()


@pytest.mark.parametrize("period", [None, 40.0])
def test_a_table_has_three_continuous_derivatives(period: float | None) -> None:
    profile = speed_table(TABLE, period)
    rng = random.Random(1)
    for _ in range(60):
        s = rng.uniform(0.1, 33.9)
        if min(abs(s - knot) for knot, _ in TABLE) > 1e-3:
            assert differs(profile.at, s) < 1e-5
    joints = [s for s, _ in TABLE if 0.0 < s < 34.0] + ([0.0, 34.0, 40.0] if period else [])
    for s in joints:
        for a, b in zip(profile.at(s - 1e-9), profile.at(s + 1e-9), strict=True):
            assert a == pytest.approx(b, abs=1e-6)


def test_an_expression_is_differentiated() -> None:
    speed = SpeedExpression(expression("3 + sin(s/a)*exp(-s/20)", ("s", "a")), {"a": 4.0})
    yaw = YawExpression(expression("30*atan(s - 7)", ("s",)), {})
    for s in np.linspace(0.5, 20.0, 23):
        assert differs(speed.at, float(s)) < 1e-7
        assert differs(yaw.at, float(s)) < 1e-6
    assert yaw.at(7.0)[:2] == pytest.approx((0.0, math.radians(30.0)))


def test_a_heading_goes_the_short_way_round_and_round_again() -> None:
    degrees = [(0.0, 350.0), (10.0, 10.0), (20.0, 120.0), (30.0, 240.0)]
    profile = yaw_table([(s, math.radians(d)) for s, d in degrees], 40.0)
    for s, d in degrees:
        assert wrap(profile.at(s)[0] - math.radians(d)) == pytest.approx(0.0, abs=1e-12)
        assert profile.at(s + 40.0)[0] - profile.at(s)[0] == pytest.approx(math.tau)
        assert profile.at(s - 80.0)[0] - profile.at(s)[0] == pytest.approx(-2.0 * math.tau)
    assert all(profile.at(float(s))[1] >= -1e-12 for s in np.linspace(0.0, 80.0, 400))  # always to the right
    assert math.degrees(profile.at(5.0)[0]) == pytest.approx(360.0, abs=6.0)  # through north, not through south


def test_what_is_no_speed() -> None:
    for speed, said in (
        ("0", "never moves"),
        ("sin(s)", "expected at least 0.05 m/s everywhere"),
        ("cos(s/6)", "expected at least 0.05 m/s everywhere"),
        ("{table: [[0, 1], [10, -1]]}", "expected one direction"),
        ("{table: [[0, 0], [10, 1]]}", "expected at least 0.05 m/s"),
        ("{table: [[0, 1], [100, 1]]}", "lies beyond the path"),
        ("{table: [[9, 1], [3, 1]]}", "expected rising distances"),
        ("log(s - 5)", "is not defined"),
    ):
        with pytest.raises(ConfigError) as faults:
            mission(CIRCLE, speed)
        assert all(str(fault).startswith("m.yaml:4: speed") for fault in faults.value.faults)
        assert said in str(faults.value)


@pytest.mark.parametrize(
    ("yaw", "said"),
    [
        ("{look_at: [6, 0, 0]}", "no heading there"),
        ("log(s - 5)", "is not defined"),
        ("{table: [[0, 10], [99, 20]]}", "lies beyond the path"),
    ],
)
def test_what_is_no_heading(yaw: str, said: str) -> None:
    with pytest.raises(ConfigError) as faults:
        mission(CIRCLE, 2.0, yaw)
    assert said in str(faults.value)


@pytest.mark.parametrize(
    ("path", "yaw"),
    [(CIRCLE, "{look_at: [0, 1, 0]}"), (EIGHT, "20"), (LEGS, "tangent")],
    ids=["circle", "eight", "legs"],
)
def test_the_fastest_speed_keeps_its_margin_everywhere_and_uses_it_somewhere(path: str, yaw: str) -> None:
    """Looked at between the places it was found at; no faster than told, no harder along the path, slow at open ends."""
    given = mission(path, "{auto: {margin: 0.8, speed_max: 7}}", yaw)
    report = check(given, X500)
    assert report.auto and report.feasible
    speed = report.mission.speed
    assert isinstance(speed, SpeedProfile)
    s = np.random.default_rng(5).uniform(0.0, report.length, 4000)
    at = stations_along(report.mission, np.sort(s))
    asked = compute_demand(at, X500)
    used = max(float(np.max(q.used)) for q in quantities(asked, X500) if q.name != "speed_mps")
    along = float(np.max(np.abs(asked.along))) / ACCELERATION
    fast = float(np.max(asked.speed)) / 7.0
    assert used <= 0.8 * 1.01
    assert along <= 0.8 * 1.01
    assert fast <= 1.01
    assert max(used / 0.8, along / 0.8, fast) > 0.97
    for x in at.s[40:-40:40].tolist():
        assert differs(speed.at, x) < 1e-3
    if not report.mission.closed:
        assert speed.at(0.0)[0] == pytest.approx(END_SPEED, rel=0.1)
        assert speed.at(report.length)[0] == pytest.approx(END_SPEED, rel=0.1)


def test_the_fastest_speed_joins_itself_with_three_derivatives() -> None:
    report = check(mission(EIGHT, "auto"), X500)
    speed = report.mission.speed
    assert isinstance(speed, SpeedProfile)
    for joint in [*speed.profile.knots[1:-1:7], report.length]:
        for k, (a, b) in enumerate(zip(speed.at(joint - 1e-9), speed.at(joint + 1e-9), strict=True)):
            assert a == pytest.approx(b, abs=1e-5 * 10**k)


def test_the_fastest_speed_runs_backwards_when_told_to() -> None:
    there, back = (check(mission(CIRCLE, f"{{auto: {{reverse: {word}}}}}"), X500) for word in ("false", "true"))
    assert back.mission.alpha(3.0) < 0.0 < there.mission.alpha(3.0)
    assert back.duration == pytest.approx(there.duration, rel=0.01)
