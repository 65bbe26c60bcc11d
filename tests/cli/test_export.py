"""Missions as plans and tables: what QGroundControl would draw, what a spreadsheet would show."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.config.mission.mission import load_mission
from companion.config.plan.qgroundcontrol import plan_from
from companion.config.syntax.faults import ConfigError
from companion.geodesy import LocalFrame
from companion.library.simulation import at_home
from companion.mission import Mission
from companion.places.drawn import waypoint_arcs, waypoint_plan
from companion.places.listed import COLUMNS, rows_along
from companion.plans.route import route_of
from companion.plans.writing import plan_text
from companion.world import World
from tests.plans.test_plans import importer

HOME = LocalFrame(47.397742, 8.545594, 489.4)


def shipped(name: str) -> Mission:
    return at_home(load_mission(name, None), World())[0]


def stray(mission: Mission, plan_file: str) -> float:
    """m, the farthest that the path is from the legs of a plan, and the legs' waypoints from the path."""
    waypoints = [w.place.seen_from(HOME) for w in route_of(plan_from(plan_file, "p.plan")[0]).waypoints]
    a = np.array(waypoints)
    legs = np.diff(a, axis=0)
    farthest = 0.0
    for point in mission.table.samples(700)[1]:
        t = np.clip(np.sum((point - a[:-1]) * legs, axis=1) / np.sum(legs**2, axis=1), 0.0, 1.0)
        farthest = max(farthest, np.linalg.norm(a[:-1] + t[:, None] * legs - point, axis=1).min())
    return max(farthest, *(mission.table.locate(w)[1] for w in waypoints))


@pytest.mark.parametrize("name", ["circle", "figure8", "helix", "line", "lissajous", "circle_r5"])
@pytest.mark.parametrize("tolerance", [0.05, 0.5])
def test_the_drawn_legs_stay_by_the_path(name: str, tolerance: float) -> None:
    mission = shipped(name)
    assert stray(mission, plan_text(waypoint_plan(mission, HOME, tolerance))) < tolerance + 1e-3


def test_a_circle_takes_as_many_waypoints_as_its_sagitta_asks() -> None:
    mission = shipped("circle")  # r = 6 m
    needed = math.pi / math.acos(1.0 - 0.1 / 6.0)
    assert needed <= len(waypoint_arcs(mission, 0.1)) - 1 <= 2.2 * needed


def test_a_plan_read_again_is_the_same_plan() -> None:
    for name in ("circle", "line", "figure8"):
        plan = waypoint_plan(shipped(name), HOME, 0.2)
        again = plan_from(plan_text(plan), "p.plan")[0]
        assert str(again) == str(plan)  # nan is not itself


def test_speeds_directions_headings_and_laps() -> None:
    line = waypoint_plan(shipped("line"), HOME, 0.1)
    speeds = [item.params[1] for item in line.items if item.command == 178]
    assert line.speed == pytest.approx(2.0, abs=0.4)
    assert max(speeds) == pytest.approx(5.0, abs=0.1)
    backwards = shipped("lissajous")
    first = route_of(waypoint_plan(backwards, HOME, 0.1)).waypoints
    end = backwards.table.at(backwards.table.length - 0.5)[0]
    assert math.dist(first[1].place.seen_from(HOME), end) < math.dist(first[-2].place.seen_from(HOME), end)
    assert {w.heading for w in first} == {90.0}
    (jump,) = (item for item in waypoint_plan(shipped("circle"), HOME, 0.1).items if item.command == 177)
    assert jump.params[:2] == (1.0, 2.0)  # three laps
    (jump,) = (item for item in waypoint_plan(shipped("circle_r5"), HOME, 0.1).items if item.command == 177)
    assert jump.params[:2] == (1.0, -1.0)


def test_mavsdk_reads_what_is_written() -> None:
    sdk, reader = importer()
    try:
        for name in ("circle", "line", "helix"):
            mission = shipped(name)
            plan = waypoint_plan(mission, HOME, 0.2)
            theirs = reader.import_qgroundcontrol_mission_from_string(plan_text(plan)).mission_items
            assert [item.command for item in plan.items] == [item.command for item in theirs]
            for mine, other in zip(plan.items, theirs, strict=True):
                if mine.command == 16:
                    assert (round(mine.params[4] * 1e7), round(mine.params[5] * 1e7)) == (other.x, other.y)
                    assert mine.params[6] == pytest.approx(other.z)
    finally:
        sdk.destroy()


def test_the_table() -> None:
    mission = shipped("line")
    rows = [dict(zip(COLUMNS, row, strict=True)) for row in rows_along(mission, HOME, 0.5)]
    assert rows[0]["s_m"] == 0.0
    assert rows[-1]["s_m"] == mission.table.length
    for row in rows[::40]:
        there = HOME.to_local(row["latitude_deg"], row["longitude_deg"], row["altitude_amsl_m"])
        assert there == pytest.approx((row["north_m"], row["east_m"], row["down_m"]), abs=1e-6)
        assert (row["x_m"], row["y_m"], row["z_m"]) == pytest.approx((row["east_m"], row["north_m"], -row["down_m"]))
        assert row["speed_mps"] == mission.alpha(row["s_m"])
    assert rows[-1]["time_s"] == pytest.approx(rows[0]["s_m"] + sum(0.5 / r["speed_mps"] for r in rows), rel=0.02)
    turns = [row[-1] for row in rows_along(shipped("circle"), HOME, 1.0)]
    assert turns == pytest.approx([1.0 / 6.0] * len(turns), rel=1e-5)


def run(*arguments: str) -> tuple[int, str]:
    try:
        result = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    except ConfigError as error:
        return 2, str(error)
    return result.exit_code, result.output


def test_the_command(tmp_path: Path) -> None:
    plan, table = tmp_path / "p.plan", tmp_path / "t.csv"
    code, _ = run("export", "spline", "--plan", str(plan), "--csv", str(table), "--home", "52.5, 13.4, 34")
    assert code == 0
    assert json.loads(plan.read_text())["mission"]["plannedHomePosition"] == [52.5, 13.4, 34.0]
    found = list(csv.reader(io.StringIO(table.read_text())))
    assert found[0] == list(COLUMNS)
    assert len(found) > 100
    assert run("check", str(plan))[0] == 0
    code, said = run("export", "spline", "--plan", str(plan))
    assert (code, "exists already; --force" in said) == (2, True)
    assert run("export", "spline", "--plan", str(plan), "--force")[0] == 0
    code, said = run("export", "nothing", "--home", "52.5, 13.4", "--csv", "/none/t.csv")
    assert code == 2
    assert len(said.splitlines()) == 3
    assert "expected a file to write" in run("export", "line")[1]
