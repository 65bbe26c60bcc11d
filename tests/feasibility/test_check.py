"""`companion check`: exact values where they are known, places named, and what the command prints."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import pytest

from companion.cli.check import check as look
from companion.cli.commands import main
from companion.cli.flying import objection
from companion.cli.output import Output
from companion.config.mission.mission import load_mission, mission_from
from companion.config.syntax.document import parse
from companion.config.syntax.file_lookup import names
from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.feasibility.demand import without_yaw
from companion.feasibility.limits import use_without_yaw
from companion.feasibility.report import NAMES, Report, check
from companion.feasibility.words import headline, in_words
from companion.fence import Fence, Polygon
from companion.law.gains import Level
from companion.library.checking import air_of, as_it_is
from companion.mission import Mission
from companion.profiles import ConstantSpeed
from companion.vehicle import Vehicle
from companion.world.machine import Deviations

X500 = load_vehicle("x500")
GOOD = """\
mission: circle
frame: {frame}
path: {{kind: circle, center: [0, 0, {z}], radius: {r}}}
speed: {speed}
yaw: {yaw}
"""


def circle(
    speed: object = 4.0, r: float = 6.0, yaw: object = 0.0, z: float = 12.0, frame: str = "enu", more: str = ""
) -> Mission:
    text = GOOD.format(speed=speed, r=r, yaw=yaw, z=z, frame=frame) + more
    return mission_from(parse(text, "test.yaml"), None)


def level_turn(vehicle: Vehicle, v: float, r: float) -> tuple[float, float]:
    """(thrust N, tilt rad) of a level turn: gravity, the centripetal force, and the drag that is overcome."""
    side = math.hypot(v * v / r, vehicle.drag * v)
    return vehicle.mass * math.hypot(vehicle.gravity, side), math.atan2(side, vehicle.gravity)


def worst(report: Report, name: str) -> float:
    return next(limit.worst for limit in (*report.limits, *report.others) if limit.name == name)


def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: str) -> tuple[int, str, str]:
    monkeypatch.setattr("sys.argv", ["companion", "check", *words])
    with pytest.raises(SystemExit) as left:
        main()
    out, err = capsys.readouterr()
    return int(left.value.code or 0), out, err


def test_a_level_turn_is_exact() -> None:
    report = check(circle(), X500)
    thrust, tilt = level_turn(X500, 4.0, 6.0)
    assert worst(report, "thrust_n") == pytest.approx(thrust, rel=1e-9)
    assert worst(report, "tilt_deg") == pytest.approx(math.degrees(tilt), rel=1e-9)
    assert worst(report, "path_radius_m") == pytest.approx(6.0, rel=1e-6)
    assert report.length == pytest.approx(12.0 * math.pi, rel=1e-9)
    assert report.duration == pytest.approx(3.0 * math.pi, rel=1e-9)
    assert report.max_vdot == pytest.approx(16.0 / 6.0, rel=1e-9)


def test_the_papers_cases() -> None:
    """Steady states of section V: 5.2418 and 66.4428 deg, 19.7024 and 49.0912 N; Remark 4.3 holds for the first only."""
    one, two = (check(load_mission(f"paper_case{i}", None), load_vehicle("paper")) for i in (1, 2))
    assert worst(one, "tilt_deg") == pytest.approx(math.degrees(math.atan(0.9 / 9.81)), abs=1e-7)
    assert worst(two, "tilt_deg") == pytest.approx(math.degrees(math.atan(22.5 / 9.81)), abs=1e-7)
    assert worst(one, "thrust_n") == pytest.approx(19.7024, abs=1e-4)
    assert worst(two, "thrust_n") == pytest.approx(49.0912, abs=1e-4)
    assert (one.max_vdot, two.max_vdot) == (pytest.approx(0.9), pytest.approx(22.5))
    assert one.proposition_4_2
    assert not two.proposition_4_2
    assert one.feasible and two.feasible  # sufficient, not necessary


def test_the_largest_factor_on_the_speed() -> None:
    """Where tilt decides it is known: 45 degrees where v^2/r and the drag together are g."""
    report = check(circle(speed=3.0, r=10.0), X500)
    v, low, high = 0.0, 0.0, 30.0
    for _ in range(60):
        v = 0.5 * (low + high)
        low, high = (v, high) if math.hypot(v * v / 10.0, X500.drag * v) < X500.gravity else (low, v)
    assert report.at_most.name == "tilt_deg"
    assert report.speed_scale_max == pytest.approx(v / 3.0, rel=1e-5)


@pytest.mark.parametrize(
    ("speed", "yaw"),
    [
        ("3 + sin(s/6)", "tangent"),
        ("-2.5 - cos(s/3)", "{look_at: [1, 2, 0]}"),
        ("{table: [[0, 2], [20, 4]]}", "40*sin(s/6)"),
    ],
)
def test_the_largest_factor_is_that_of_the_whole_profile(speed: str, yaw: str) -> None:
    """The same mission with its speed multiplied by the factor is just feasible."""
    report = check(circle(speed, yaw=yaw), X500)
    scale = report.speed_scale_max
    for factor, feasible in ((0.999, True), (1.001, False)):
        if speed.startswith("{"):
            scaled = f"{{table: [[0, {2 * scale * factor}], [20, {4 * scale * factor}]]}}"
        else:
            scaled = f"{scale * factor}*({speed})"
        assert check(circle(scaled, yaw=yaw), X500).feasible is feasible


@pytest.mark.parametrize(
    ("mission", "name", "said"),
    [
        (circle(speed=9.0), "tilt_deg", "It would tilt by"),
        (circle(speed=13.0, r=500.0), "speed_mps", "m/s"),
        (circle(speed=5.0, r=2.0, yaw="tangent"), "yaw_rate_dps", "heading rate"),
        (circle(r=0.2, speed=0.2), "path_radius_m", "bends to a radius of 0.20 m"),
        (circle(z=-3.0), "ground_clearance_m", "below the ground (z points up in frame: enu)"),
        (circle(z=3.0, frame="ned"), "ground_clearance_m", "below the ground (z points down in frame: ned)"),
        (circle(yaw="10*s"), "yaw_jump_deg", "the heading jumps by 17."),
        (circle(speed="3 + s/20"), "speed_jump_percent", "the speed jumps by"),
    ],
    ids=lambda value: value if isinstance(value, str) and "_" in value else "",
)
def test_what_cannot_be_flown_is_said_with_its_place(mission: Mission, name: str, said: str) -> None:
    report = check(mission, X500)
    broken = {limit.name: limit for limit in report.deciding if not limit.ok}
    assert name in broken
    assert not report.feasible
    text = in_words(report)
    assert "cannot be flown like this" in text.splitlines()[0]
    assert f"{broken[name].at_s:.1f} m" in text
    if report.tightest.name == name:
        assert said in text.splitlines()[0]


def test_a_limit_of_the_path_leaves_no_speed() -> None:
    report = check(circle(yaw="10*s"), X500)
    assert report.speed_scale_max == 0.0
    assert "at no speed" in in_words(report)


def test_a_vehicle_that_watches_its_tilt_is_kept_under_its_detector() -> None:
    """SIH allows 50 degrees and its failure detector ends the flight at 60: 50 is just inside."""
    limits = {limit.name: limit for limit in check(circle(), load_vehicle("sih")).limits}
    assert limits["tilt_deg"].limit == pytest.approx(50.0)


def test_a_speed_that_is_found() -> None:
    report = check(circle(speed="auto"), X500)
    assert report.auto and report.feasible
    assert report.speed_scale_max > 1.0
    assert "the fastest this vehicle can keep" in in_words(report)
    assert check(circle(speed="auto", r=0.2), X500).feasible is False


@pytest.mark.parametrize("name", names("missions"))
def test_shipped_missions_can_be_flown(name: str) -> None:
    mission = load_mission(name, None)
    assert check(mission, load_vehicle(mission.vehicle or "x500")).feasible


def test_the_document(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    code, out, err = run(capsys, monkeypatch, "circle", "--json")
    document: dict[str, Any] = json.loads(out)
    assert code == 0
    assert "can be flown" in err
    assert document["schema"] == "companion.check/1"
    assert [limit["name"] for limit in document["limits"]] == list(NAMES)
    for limit in document["limits"]:
        assert {"name", "worst", "limit", "at_s", "ok"} <= set(limit)
    assert document["feasible"] is True
    assert document["length_m"] == pytest.approx(37.70, abs=0.01)
    assert document["duration_s"] == pytest.approx(9.42, abs=0.01)
    assert document["paper"] == {"max_vdot": pytest.approx(2.667, abs=1e-3), "g": 9.80665, "proposition_4_2": True}


def test_exit_codes_and_words(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fast = tmp_path / "fast.yaml"
    fast.write_text(GOOD.format(speed=9.0, r=6.0, yaw=0.0, z=12.0, frame="enu"))
    code, out, _ = run(capsys, monkeypatch, str(fast))
    assert code == 1
    assert "cannot be flown like this" in out
    code, out, _ = run(capsys, monkeypatch, str(fast), "--json")
    assert code == 1
    assert json.loads(out)["feasible"] is False
    bad = tmp_path / "bad.yaml"
    bad.write_text(fast.read_text().replace("radius: 6.0", "radius: -1"))
    code, out, err = run(capsys, monkeypatch, str(bad))
    assert (code, out) == (2, "")
    assert f"{bad}:3: path.radius" in err
    assert run(capsys, monkeypatch, "circle", "--plot", str(tmp_path / "a.txt"))[0] == 2
    assert run(capsys, monkeypatch, "circle", "--plot", str(tmp_path / "none" / "a.png"))[0] == 2


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_a_picture(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, suffix: str
) -> None:
    plot = tmp_path / f"circle.{suffix}"
    assert run(capsys, monkeypatch, "circle", "--plot", str(plot))[0] == 0
    assert plot.stat().st_size > 5000


def test_a_fence_is_kept_with_room() -> None:
    mission = circle(r=6.0)
    for half, feasible in ((6.6, True), (6.4, False), (5.0, False)):
        square = Polygon(((-half, -half), (half, -half), (half, half), (-half, half)))
        report = check(dataclasses.replace(mission, fence=Fence((square,))), X500)
        assert report.feasible is feasible
        assert worst(report, "fence_m") == pytest.approx(half - 6.0, abs=1e-4)
        assert ("leaves the fence by 1.0 m" in in_words(report)) is (half == 5.0)


def test_fly_refuses_what_cannot_be_flown_before_anything_is_opened(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fast = tmp_path / "fast.yaml"
    fast.write_text(GOOD.format(speed=9.0, r=6.0, yaw=0.0, z=12.0, frame="enu"))
    words = ["companion", "fly", str(fast), "--connect", "udpin://127.0.0.1:9", "--record", str(tmp_path / "flight")]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as left:
        main()
    out, _ = capsys.readouterr()
    assert left.value.code == 1
    assert "not flown: circle on x500: cannot be flown like this. " in out
    assert "--accept-infeasible" in out
    assert not (tmp_path / "flight").exists()


def test_fly_leaves_what_no_flight_can_tell_from_the_limit() -> None:
    """PX4's simulated quadrotor leans by 50.9 degrees round 5 m at 7 m/s, and 50 are its limit: flown, with a warning;
    what is really too fast, or too low, is not."""
    sih = load_vehicle("sih")
    near = check(circle(speed=7.0, r=5.0), sih)
    assert not near.feasible and near.may_be_flown
    assert not check(circle(speed=7.5, r=5.0), sih).may_be_flown
    assert not check(circle(speed=3.0, r=5.0, z=0.2), sih).may_be_flown


def test_fly_lets_the_heading_give_way_but_not_the_path() -> None:
    """The figure-eight of PX4's simulated quadrotor at 3 m/s: its motors cannot hold the nose north in the tightest
    places, and fly the path all the same. At 3.3 m/s it would have to turn faster than it may, at 4.5 m/s tilt too far.
    """
    sih, mission = load_vehicle("sih"), load_mission("figure8", Level.RATES)
    found = {v: check(dataclasses.replace(mission, speed=ConstantSpeed(v)), sih) for v in (2.5, 3.0, 3.3, 4.5)}
    assert [found[v].feasible for v in found] == [True, False, False, False]
    assert [found[v].may_be_flown for v in found] == [True, True, False, False]
    assert [found[v].heading_gives_way for v in found] == [False, True, True, False]
    assert "the path can, and the heading gives way. Motor 2 would have to pull downwards, 33.3 m" in headline(
        found[3.0]
    )
    north = found[3.0]
    assert use_without_yaw(north.asked, sih) < 0.5
    assert without_yaw(north.asked, sih).sum(0) == pytest.approx(
        north.asked.motors.sum(0)
    )  # yaw takes from two what two get


def test_the_place_over_the_real_ground_is_looked_at_before_arming() -> None:
    assert objection(circle(), X500, 0.0) is None
    said = objection(circle(), X500, -12.5)
    assert said is not None and "below the ground" in said


def test_what_no_vehicle_mends_is_not_offered_to_be_flown_all_the_same(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A path under the ground: who knows that the ground falls away may fly it, but nobody is invited to."""
    low = tmp_path / "low.yaml"
    low.write_text(GOOD.format(speed=2.0, r=6.0, yaw=0.0, z=-1.0, frame="enu"))
    words = ["companion", "fly", str(low), "--connect", "udpin://127.0.0.1:9", "--record", str(tmp_path / "flight")]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as left:
        main()
    out, _ = capsys.readouterr()
    assert left.value.code == 1 and "below the ground" in out and "--accept-infeasible" not in out


def test_wind_asks_for_the_tilt_that_carries_its_drag() -> None:
    """A slow circle in a steady wind: the tilt is that of the drag against the air, atan(c W / g)."""
    mission, wind = circle(speed=0.05, r=6.0), 8.0
    still, windy = check(mission, X500), check(mission, X500, wind_n=(wind, 0.0, 0.0))
    assert worst(still, "tilt_deg") < 0.2
    leaning = math.degrees(math.atan(X500.drag * wind / X500.gravity))
    assert worst(windy, "tilt_deg") == pytest.approx(leaning, abs=0.2)


def test_check_in_a_world_says_its_wind_and_takes_its_machine(capsys: pytest.CaptureFixture[str]) -> None:
    air = air_of(load_world("outdoor"), 10.0)
    assert math.hypot(*air.wind_n) == pytest.approx(7.0)  # 5 m/s and twice 1 m/s
    assert "from the south-west" in air.words
    heavy = as_it_is(X500, Deviations(mass=3.0, thrust_scale=0.9))
    assert heavy.mass == 3.0 and heavy.thrust_max == pytest.approx(0.9 * X500.thrust_max)
    assert look("circle_r5", None, Output.AUTO, "outdoor", as_json=False, plot=None) == 0
    assert "outdoor: wind 5.0 m/s from the south-west" in capsys.readouterr().out
    assert look("circle_r5", None, Output.MOTORS, None, as_json=False, plot=None) == 0
