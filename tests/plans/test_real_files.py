"""What other people's plans have in them, read as they meant it or refused with the reason."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from companion.config.mission.mission import load_mission
from companion.config.plan.qgroundcontrol import plan_from
from companion.config.plan.room import RADIUS_LEAST
from companion.config.plan.source import is_plan
from companion.config.syntax.faults import ConfigError
from companion.config.vehicle import load_vehicle
from companion.feasibility.geometry import RADIUS_MIN
from companion.feasibility.report import check
from companion.frames import Vec3
from companion.geodesy import LocalFrame
from companion.mission import Mission
from companion.plans.items import FenceArea
from tests.support.plan_text import EAST, HOME, NORTH, plan, waypoint, written

WPL = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t47.0\t8.0\t400\t1\n"
SQUARE = (waypoint(0, 0, 10), waypoint(40, 0, 10), waypoint(40, 40, 10))


def read(tmp_path: Path, *items: dict[str, Any], **more: Any) -> Mission:
    return load_mission(str(written(tmp_path / "field.plan", *items, **more)), None)


def strays(mission: Mission, *places: Vec3) -> float:
    """m, the farthest that the path passes one of the places (north, east, up)."""
    return max(mission.table.locate((north, east, -up))[1] for north, east, up in places)


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_waypoints_are_told_by_their_first_line(tmp_path: Path, mark: str) -> None:
    file = tmp_path / "waypoints.txt"
    file.write_text(f"{mark}{WPL}1\t0\t3\t16\t0 0\t0\t0\t47.0\t8.0\t10\t1\n2 0 3 16 0 0 0 0 47.0004 8.0 10.0 1\n")
    assert is_plan(str(file))
    assert load_mission(str(file), None).table.length == pytest.approx(44.5, abs=0.1)
    assert not is_plan("circle")


def test_a_first_line_on_the_ground_is_home(tmp_path: Path) -> None:
    file = tmp_path / "w.txt"
    first = WPL.replace("\t0\t16", "\t3\t16").replace("\t400", "\t0")
    file.write_text(first + "1 0 3 16 0 0 0 0 47.0 8.0 10 1\n2 0 3 16 0 0 0 0 47.0004 8.0 10 1\n")
    mission = load_mission(str(file), None)
    assert mission.home == (47.0, 8.0, None)
    assert mission.table.length == pytest.approx(44.5, abs=0.1)


def test_two_corners_nearer_than_the_tolerance(tmp_path: Path) -> None:
    mission = read(tmp_path, waypoint(0, 0, 10), waypoint(40, 0, 10), waypoint(40, 0.5, 10), waypoint(0, 0.5, 10))
    assert check(mission, load_vehicle("x500")).feasible
    assert strays(mission, (0, 0, 10), (40, 0, 10), (40, 0.5, 10), (0, 0.5, 10)) < 1.0


def test_a_recorded_track(tmp_path: Path) -> None:
    """Steps of 0.16 m along an S of 20 m, as a GPS receiver writes them down, some of them beside the way."""
    track = [(0.16 * i, 3.0 * math.sin(0.03 * i) + 0.08 * (i % 3 - 1), 10.0) for i in range(125)]
    mission = read(tmp_path, *(waypoint(*place) for place in track))
    assert check(mission, load_vehicle("x500")).feasible
    assert strays(mission, *track) < 1.0


def test_a_short_leg_between_two_sharp_corners(tmp_path: Path) -> None:
    corners = ((0, 0, 10), (18, 0, 10), (18, 1.1, 10), (14, 2.2, 10))
    mission = read(tmp_path, *(waypoint(*corner) for corner in corners))
    assert check(mission, load_vehicle("x500")).feasible
    assert strays(mission, *corners) < 1.0


@pytest.mark.parametrize("turns", [(180, 180, 180), (164, -178, 178, 176), (-170, 175, -165, 160, 179)])
def test_hairpins_at_the_ends_of_legs_of_five_metres(tmp_path: Path, turns: tuple[float, ...]) -> None:
    """To and fro on short legs, as somebody taps them on a screen: each turn leaves room for the next."""
    north, east, heading, corners = 0.0, 0.0, 0.3, [(0.0, 0.0, 10.0)]
    for turn in (0.0, *turns):
        heading += math.radians(turn)
        north, east = north + 5.0 * math.cos(heading), east + 5.0 * math.sin(heading)
        corners.append((north, east, 10.0))
    mission = read(tmp_path, *(waypoint(*corner) for corner in corners))
    assert check(mission, load_vehicle("x500")).feasible
    assert strays(mission, *corners) < 0.1


def test_a_first_line_of_zeros_is_an_unknown_home(tmp_path: Path) -> None:
    file = tmp_path / "w.waypoints"
    rows = "1 0 3 22 0 0 0 0 0 0 10 1\n2 0 3 16 0 0 0 0 47.0 8.0 10 1\n3 0 3 16 0 0 0 0 47.0004 8.0 10 1\n"
    file.write_text("QGC WPL 110\n0 1 0 0 0 0 0 0 0 0 0 1\n" + rows)
    assert load_mission(str(file), None).table.length == pytest.approx(44.5, abs=0.1)


def changed(change: Any) -> str:
    data = plan(*SQUARE)
    change(data)
    return json.dumps(data, indent=2)


@pytest.mark.parametrize(
    "change",
    [
        lambda p: p.update(geoFence={"polygons": []}),
        lambda p: p.update(geoFence={}),
        lambda p: p.update(geoFence={"circles": [], "polygons": [], "version": 7}),
        lambda p: p.pop("version"),
    ],
)
def test_what_says_nothing_is_no_fault(change: Any) -> None:
    read, _ = plan_from(changed(change), "p.plan")
    assert (len(read.items), read.fence) == (3, ())


def test_a_fence_without_a_version_is_kept() -> None:
    corners = [[HOME[0], HOME[1]], [HOME[0] + 9 * NORTH, HOME[1]], [HOME[0], HOME[1] + 9 * EAST]]
    read, _ = plan_from(changed(lambda p: p.update(geoFence={"polygons": [{"polygon": corners}]})), "p.plan")
    assert read.fence == (FenceArea(tuple(map(tuple, corners)), None, True),)  # type: ignore[arg-type]


def test_across_the_180th_meridian(tmp_path: Path) -> None:
    file = tmp_path / "w.waypoints"
    rows = [f"{i} 0 3 16 0 0 0 0 -17.0 {longitude} 10 1" for i, longitude in enumerate((179.9998, 180.0002), 1)]
    file.write_text("QGC WPL 110\n0 1 0 16 0 0 0 0 -17.0 179.9998 5 1\n" + "\n".join(rows) + "\n")
    assert load_mission(str(file), None).table.length == pytest.approx(42.5, abs=0.1)


@pytest.mark.parametrize(
    ("far", "said"),
    [
        ([(60_000.0, 0.0)], "item 2: it lies 60 km from where the path begins"),
        ([(20_000.0, 0.0), (0.0, 0.0)] * 3, "item 7: the path is 120 km long here"),
    ],
)
def test_too_far_is_said_by_the_item(tmp_path: Path, far: list[tuple[float, float]], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        read(tmp_path, waypoint(0, 0, 10), *(waypoint(*place, 10) for place in far))


def test_fences_among_the_items(tmp_path: Path) -> None:
    corners = [(5001, 3, -50, -50), (5001, 3, 90, -50), (5001, 3, 0, 90)]
    fence = [*corners, (5004, 7, 20, 20), (5000, 0, 0, 0), (5100, 0, 9, 9)]
    frame = LocalFrame(47.0, 8.0, 400.0)
    path = [(16, 0, 0, 0), (16, 0, 40, 0)]
    rows = []
    for i, (command, first, north, east) in enumerate([*path, *fence], 1):
        latitude, longitude, _ = frame.to_global((north, east, 0.0))
        rows.append(f"{i}\t0\t3\t{command}\t{first}\t0\t0\t0\t{latitude:.8f}\t{longitude:.8f}\t10\t1")
    file = tmp_path / "w.waypoints"
    file.write_text(WPL + "\n".join(rows) + "\n")
    mission = load_mission(str(file), None)
    assert mission.fence is not None
    assert mission.fence.margin((0.0, 20.0, -10.0)) > 0.0
    assert mission.fence.margin((20.0, 14.0, -10.0)) < 0.0
    assert mission.fence.margin((80.0, 60.0, -10.0)) < 0.0
    file.write_text(WPL + "\n".join(rows[2:6]) + "\n")
    with pytest.raises(ConfigError, match="holds a fence, and no waypoints"):
        load_mission(str(file), None)
    file.write_text(WPL + "\n".join([*rows[:2], *rows[3:5]]) + "\n")
    with pytest.raises(ConfigError, match=r"w\.waypoints:5: .*: item 4: a polygon of 3 corners, 2 are there"):
        load_mission(str(file), None)


@pytest.mark.parametrize(("name", "first"), [("field.poly", ""), ("field.fen", "47.5 8.5\n")])
def test_a_polygon_is_no_path_and_how_to_have_it_as_a_fence_is_said(tmp_path: Path, name: str, first: str) -> None:
    file = tmp_path / name
    file.write_text(f"#saved by Mission Planner\n{first}47.0 8.0\n47.001 8.0\n47.001 8.001\n47.0 8.0\n")
    with pytest.raises(ConfigError) as caught:
        load_mission(str(file), None)
    said = str(caught.value)
    assert "a polygon of 3 corners and no path" in said
    fence = said[said.index("fence: ") :]
    mission = tmp_path / "m.yaml"
    place = "{lat: 47.0005, lon: 8.0003, above_home: 10}"
    mission.write_text(
        f"mission: m\nframe: enu\norigin: {{lat: 47.0, lon: 8.0, above_home: 0}}\n"
        f"path: {{kind: circle, center: {place}, radius: 5}}\nspeed: 2\n{fence}\n"
    )
    kept = load_mission(str(mission), None).fence
    assert kept is not None
    assert kept.margin((20.0, 50.0, 10.0)) > 0.0


def test_an_older_file_of_qgroundcontrol_is_refused_as_what_it_is(tmp_path: Path) -> None:
    file = tmp_path / "old.mission"
    file.write_text(json.dumps({"MAV_AUTOPILOT": 12, "items": [], "version": "1.0"}))
    with pytest.raises(ConfigError, match=r'fileType: is not "Plan"; expected a \.plan'):
        load_mission(str(file), None)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("QGC WPL 110\n# home\n0 1 0 16 0 0 0 0 47 8 0 1\n1 0 0 16 0 0 0 0 47 8 5 1\n2 0 0 16 0 0 0 0 47.001 8 5 1\n",
         "3: home line: heights above sea level, and it is not known how high home"),
        ("QGC WPL 120\n0 1 0 16 0 0 0 0 47 8 5 1\n1 0 0 16 0 0 0 0 47.001 8 5 1\n",
         "1: heights above sea level, and it is not known how high home"),
        (f"{WPL}1 0 3 16 0 0 0 0 47 8 5 1\n", "1: a path needs two waypoints"),
    ],
)  # fmt: skip
def test_a_fault_of_a_waypoint_file_names_what_the_file_has(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "w.waypoints"
    file.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_mission(str(file), None)
    assert str(caught.value).startswith(f"{file}:{said}")
    assert "mission." not in str(caught.value)


@pytest.mark.parametrize("short", [1.03, 1.4, 1.8, 2.1])
@pytest.mark.parametrize("turn", [70.0, 90.0, -100.0])
def test_a_short_leg_before_the_end_leaves_room_to_turn(tmp_path: Path, short: float, turn: float) -> None:
    """The last waypoints and the landing a step apart, across the way: the turn is made beyond the waypoint."""
    to = math.radians(turn)
    places = [(short + more) for more in (0.0, 0.75)]
    corners = [
        (0.0, 0.0, 10.0),
        (60.0, 0.0, 10.0),
        *((60.0 + d * math.cos(to), d * math.sin(to), 10.0) for d in places),
    ]
    for tried in (corners, corners[::-1]):
        mission = read(tmp_path, *(waypoint(*corner) for corner in tried))
        assert check(mission, load_vehicle("x500")).feasible
        assert strays(mission, *tried) < 1.0
        assert not mission.notes


@pytest.mark.parametrize("turn", [60.0, 90.0, 105.0])
@pytest.mark.parametrize("sides", [(1, 1), (1, -1)])
def test_a_short_leg_in_the_middle_leaves_room_to_turn(tmp_path: Path, turn: float, sides: tuple[int, int]) -> None:
    heading, corners = 0.0, [(0.0, 0.0, 10.0)]
    for length, side in ((40.0, sides[0]), (1.9, sides[1]), (40.0, 0)):
        north, east, up = corners[-1]
        corners.append((north + length * math.cos(heading), east + length * math.sin(heading), up))
        heading += math.radians(side * turn)
    mission = read(tmp_path, *(waypoint(*corner) for corner in corners))
    assert check(mission, load_vehicle("x500")).feasible
    assert strays(mission, *corners) < 1.0


def test_waypoints_that_leave_no_room_are_named(tmp_path: Path) -> None:
    """A turn of 118 degrees needs legs of 5 m: nothing within the tolerance helps where they have two."""
    heading, corners = 0.0, [(0.0, 0.0, 10.0)]
    for length, turn in ((40.0, 118.0), (2.0, 118.0), (2.0, 118.0), (2.0, 0.0)):
        north, east, up = corners[-1]
        corners.append((north + length * math.cos(heading), east + length * math.sin(heading), up))
        heading += math.radians(turn)
    mission = read(tmp_path, *(waypoint(*corner) for corner in corners))
    assert not check(mission, load_vehicle("x500")).feasible
    assert "too near to each other for the turn there" in mission.notes[-1] and "move them apart" in mission.notes[-1]
    assert RADIUS_LEAST == RADIUS_MIN
