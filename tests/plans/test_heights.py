"""Heights above home and above the sea: each item of a plan keeps its own, and what is not known is asked for."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from companion.config.mission.mission import load_mission
from companion.config.syntax.faults import ConfigError
from companion.config.vehicle import load_vehicle
from companion.daemon.preparing import heights_agree
from companion.feasibility.report import check, ground_under
from companion.feasibility.words import in_words
from companion.geodesy import NO_HOME_GIVEN, GivenHome
from companion.library.simulation import at_home
from companion.mission import Mission, Origin
from companion.places.origins import NotKnownError, VehicleLocation
from companion.places.words import words_of_place
from companion.vehicle import CompanionError
from companion.world import Home, World
from tests.cli.test_export import run
from tests.support.plan_text import HOME, item, survey, waypoint, written

HERE = HOME[:2]


def read(tmp_path: Path, *items: dict[str, Any], given: GivenHome = NO_HOME_GIVEN, **more: Any) -> Mission:
    return load_mission(str(written(tmp_path / "field.plan", *items, **more)), None, given)


def take_off(height: float) -> dict[str, Any]:
    return waypoint(0, 0, height, command=22)


def above_sea(mission: Mission, home: float, place: tuple[float, float] = HERE) -> list[float]:
    """m, of the path's two ends, in a world whose home lies ``home`` m above the sea."""
    placed, world = at_home(mission, World(home=Home(*place, home)))
    assert world.home.altitude == home
    return [home - placed.table.at(s)[0][2] for s in (0.0, placed.table.length)]


def test_a_relative_take_off_leaves_heights_above_the_sea_alone(tmp_path: Path) -> None:
    """The planned home lies 20 m higher than the true one: the waypoints are flown where they are all the same."""
    items = (take_off(16), waypoint(30, 0, 504, frame=0), waypoint(30, 30, 512, frame=0))
    mission = read(tmp_path, *items, given=GivenHome(altitude=468.0))
    assert above_sea(mission, 468.0) == pytest.approx([484.0, 512.0])
    assert ground_under(mission) == 0.0
    assert above_sea(read(tmp_path, *items), 488.0) == pytest.approx([504.0, 512.0])


def test_a_vehicle_whose_home_lies_elsewhere_is_told_of(tmp_path: Path) -> None:
    mission = read(tmp_path, take_off(16), waypoint(30, 0, 504, frame=0))
    heights_agree(mission, VehicleLocation((0.0, 0.0, 0.0), home=(*HERE, 488.5)))
    with pytest.raises(CompanionError, match=r"--home 47\.3977420,8\.5455940,468\.0"):
        heights_agree(mission, VehicleLocation((0.0, 0.0, 0.0), home=(*HERE, 468.0)))
    with pytest.raises(NotKnownError, match="has not set one"):
        heights_agree(mission, VehicleLocation((0.0, 0.0, 0.0)))
    heights_agree(read(tmp_path, take_off(16), waypoint(30, 0, 20)), VehicleLocation((0.0, 0.0, 0.0)))


@pytest.mark.parametrize("home", [None, [0, 0, 0], [*HERE, 0], [*HERE, None], list(HERE)])
def test_an_unknown_home_is_asked_for_where_it_is_needed(tmp_path: Path, home: Any) -> None:
    relative = read(tmp_path, take_off(10), waypoint(30, 0, 20), plannedHomePosition=home)
    assert relative.table.length == pytest.approx(31.6, abs=0.1)
    high = (waypoint(0, 0, 500, frame=0), waypoint(30, 0, 510, frame=0))
    with pytest.raises(ConfigError, match="say it: --home LAT,LON,METRES"):
        read(tmp_path, *high, plannedHomePosition=home)
    mission = read(tmp_path, *high, plannedHomePosition=home, given=GivenHome(*HERE, 490.0))
    assert mission.table.at(0.0)[0] == pytest.approx((0.0, 0.0, -10.0))
    assert read(tmp_path, *high, plannedHomePosition=home, given=GivenHome(altitude=490.0)).home == (*HERE, 490.0)


def test_a_take_off_without_a_place(tmp_path: Path) -> None:
    nowhere = item(22, 0, 0, 0, None, None, None, 12, frame=3)
    known = read(tmp_path, nowhere, waypoint(30, 0, 12), waypoint(60, 0, 12))
    assert known.table.length == pytest.approx(60.0, abs=0.01)
    unknown = read(tmp_path, nowhere, waypoint(30, 0, 12), waypoint(60, 0, 12), plannedHomePosition=[0, 0, 0])
    assert unknown.table.length == pytest.approx(30.0, abs=0.01)
    (note,) = unknown.notes
    assert note.startswith("the take-off has no place; the path begins at the waypoint after it (item 1, line ")


def test_no_place_at_all_is_said_by_its_number(tmp_path: Path) -> None:
    nowhere = item(16, 0, 0, 0, None, 0, 0, 12, frame=3)
    with pytest.raises(ConfigError, match="item 2: latitude 0, longitude 0, which stands for no place"):
        read(tmp_path, waypoint(0, 0, 12), nowhere, waypoint(60, 0, 12))


PLANS: dict[str, tuple[tuple[dict[str, Any], ...], dict[str, Any]]] = {
    "relative": ((take_off(10), waypoint(40, 0, 10), waypoint(40, 40, 14)), {"plannedHomePosition": [*HERE, 400.0]}),
    "unknown home": ((take_off(10), waypoint(40, 0, 10)), {"plannedHomePosition": [0, 0, 0]}),
    "both heights": ((take_off(16), waypoint(30, 0, 504, frame=0), waypoint(30, 30, 512, frame=0)), {}),
    "survey": ((take_off(10), survey(waypoint(0, 9, 10), waypoint(30, 9, 10), item(206, 5, 0, 1), waypoint(30, 16, 10))), {}),
    "loop": ((waypoint(0, 0, 9), waypoint(20, 0, 9), waypoint(20, 20, 9), item(177, 1, -1)), {}),
}  # fmt: skip


@pytest.mark.parametrize("name", PLANS)
def test_an_exported_plan_is_the_same_path(tmp_path: Path, name: str) -> None:
    items, more = PLANS[name]
    file, out = written(tmp_path / "field.plan", *items, **more), tmp_path / "out.plan"
    assert run("export", str(file), "--plan", str(out))[0] == 0
    first, again = load_mission(str(file), None), load_mission(str(out), None)
    assert (again.origin, again.home, again.speed) == (first.origin, first.home, first.speed)
    apart = np.linalg.norm(first.table.samples(500)[1] - again.table.samples(500)[1], axis=1)
    assert float(apart.max()) < 0.01


def test_an_export_keeps_the_planned_home(tmp_path: Path) -> None:
    items = (take_off(10), waypoint(6, 0, 10))
    file, plan, table = tmp_path / "field.plan", tmp_path / "o.plan", tmp_path / "o.csv"
    written(file, *items, plannedHomePosition=[*HERE, 400.0])
    assert run("export", str(file), "--plan", str(plan), "--csv", str(table))[0] == 0
    assert json.loads(plan.read_text())["mission"]["plannedHomePosition"][2] == 400.0
    assert float(next(csv.DictReader(table.open()))["altitude_amsl_m"]) == pytest.approx(410.0)
    written(file, *items, plannedHomePosition=[0, 0, 0])
    code, said = run("export", str(file), "--csv", str(tmp_path / "p.csv"))
    assert (code, "does not say how high its home lies" in said) == (2, True)
    high = written(tmp_path / "high.plan", waypoint(0, 0, 310, frame=0), waypoint(6, 0, 310, frame=0))
    assert "the path runs 12.0 m above" in run("check", str(high), "--home", f"{HOME[0]}, {HOME[1]}, 298")[1]


@pytest.mark.parametrize(
    ("height", "frame", "said"),
    [
        (0.0, 3, "on the ground, at the height of home"),
        (-5.0, 3, "5.0 m BELOW home"),
        (488.0, 0, "on the ground, at the height of the mission's origin"),
        (400.0, 0, "88.0 m BELOW the mission's origin"),
    ],
)
def test_a_plan_on_or_under_the_ground_is_told_of_without_a_frame(
    tmp_path: Path, height: float, frame: int, said: str
) -> None:
    """A plan has no axes: that z points down in frame: ned is no help to who drew it."""
    mission = read(tmp_path, *(waypoint(north, 0, height, frame=frame) for north in (0, 40)))
    (warning,) = words_of_place(mission, Origin.HOME).warnings
    assert f"the whole path is {said}" in warning
    report = check(mission, load_vehicle("x500"))
    text = in_words(report, words_of_place(mission, Origin.HOME).lines, (warning,))
    assert (not report.feasible and "above the ground" in text) or "below the ground" in text
    assert "frame: " not in text and "z points" not in text
    assert not re.search(r"-0(\.0*)?(?![.\d])", text), text
