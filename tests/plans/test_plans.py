"""Plans of ground stations: what is read, what is flown, what is refused; and against MAVSDK's importer."""

from __future__ import annotations

import json
import math
import random
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from companion.config.mission.mission import load_mission
from companion.config.plan.qgroundcontrol import plan_from
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.json_text import parse_json
from companion.config.vehicle import load_vehicle
from companion.fence import Circle, Polygon
from companion.frames import rotation_from_euler
from companion.geodesy import LocalFrame
from companion.law.feedback import Bounds
from companion.law.flight import Flying, curve_law, model_of
from companion.law.gains import Level, default_gains
from companion.law.speed_scale import SpeedScale
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.mission import GlobalOrigin, Mission, Origin
from companion.paths.curve import Curve
from companion.paths.polyline import polyline
from companion.places.origins import VehicleLocation, placed
from companion.plans.items import Plan
from companion.plans.route import route_of
from companion.plans.scan import grown
from companion.plans.waypoints import Waypoint
from companion.profiles import AutoSpeed, ConstantSpeed, ConstantYaw, LookAt, TangentYaw, YawProfile
from tests.support.plan_text import EAST, HOME, NORTH, item, plan, survey, text, waypoint, written


def read(*items: dict[str, Any], **more: Any) -> Plan:
    return plan_from(text(*items, **more), "field.plan")[0]


def flown(tmp_path: Path, *items: dict[str, Any], **more: Any) -> Mission:
    return load_mission(str(written(tmp_path / "field.plan", *items, **more)), Level.MOTORS)


def faults(tmp_path: Path, content: str, name: str = "field.plan") -> list[str]:
    (tmp_path / name).write_text(content, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_mission(str(tmp_path / name), Level.MOTORS)
    return [str(fault).removeprefix(f"{tmp_path}/") for fault in caught.value.faults]


def heights(waypoints: tuple[Waypoint, ...]) -> list[float]:
    return [w.place.altitude for w in waypoints]


SQUARE = (
    waypoint(0, 0, 12, command=22), waypoint(40, 0, 12), waypoint(40, 30, 15), waypoint(0, 30, 15),
)  # fmt: skip


def test_a_square_is_flown_where_it_was_drawn(tmp_path: Path) -> None:
    mission = flown(tmp_path, *SQUARE)
    assert mission.name == "field"
    assert mission.origin == GlobalOrigin(HOME[0], HOME[1], 0.0, above_home=True)
    assert mission.speed == AutoSpeed(speed_max=5.0)
    assert mission.yaw == TangentYaw()
    assert not mission.closed
    assert mission.notes == ()
    # in the frame of a vehicle whose estimator started 2 km away, each waypoint is where PX4 would put it
    own = LocalFrame(HOME[0] + 1500 * NORTH, HOME[1] - 1300 * EAST, 450.0)
    there = placed(mission, Origin.LOCAL, VehicleLocation((0.0, 0.0, 0.0), frame=own, home=HOME))
    for given in SQUARE:
        latitude, longitude, height = given["params"][4:7]
        expected = own.to_local(latitude, longitude, HOME[2] + height)
        _, distance = there.table.locate(expected)
        assert distance < 1.01  # a corner is passed within a metre
    assert there.table.at(0.0)[0] == pytest.approx(own.to_local(*SQUARE[0]["params"][4:6], HOME[2] + 12), abs=1e-3)


def test_heights_above_the_sea_and_above_home() -> None:
    amsl = route_of(read(waypoint(0, 0, 500, frame=0), waypoint(9, 0, 510, frame=0)))
    assert [w.place.amsl for w in amsl.waypoints] == [True, True]


def test_heights_of_both_kinds_meet_at_the_planned_home(tmp_path: Path) -> None:
    mission = flown(tmp_path, waypoint(0, 0, 12), waypoint(30, 0, HOME[2] + 20, frame=0))
    assert mission.table.at(mission.table.length)[0] == pytest.approx((30.0, 0.0, -20.0), abs=0.05)
    assert mission.notes == ("its heights above home count from 488.0 m above sea level, those above the sea are kept",)
    only = flown(tmp_path, waypoint(0, 0, 500, frame=0), waypoint(30, 0, 510, frame=0))
    assert only.origin == GlobalOrigin(*HOME)
    assert only.table.at(0.0)[0][2] == pytest.approx(-12.0)


def test_speeds_are_caps_from_where_they_are_said(tmp_path: Path) -> None:
    mission = flown(tmp_path, SQUARE[0], SQUARE[1], item(178, 1, 2.5, -1), SQUARE[2], item(178, 1, -2), SQUARE[3])
    assert isinstance(mission.speed, AutoSpeed)
    (first, second, third) = mission.speed.caps
    assert first == (0.0, 5.0)
    assert second == (pytest.approx(39.4, abs=0.5), 2.5)
    assert third == (pytest.approx(69.0, abs=0.8), 5.0)


def test_headings_of_legs_and_places_to_face(tmp_path: Path) -> None:
    north = flown(tmp_path, *(waypoint(i * 20, i % 2 * 20, 10, yaw=0.0) for i in range(4)))
    assert north.yaw == ConstantYaw(0.0)
    roi = item(195, 0, 0, 0, 0, HOME[0] + 10 * NORTH, HOME[1] + 10 * EAST, 0, frame=3)
    facing = flown(tmp_path, roi, *SQUARE)
    assert isinstance(facing.yaw, LookAt)
    assert facing.look_at == pytest.approx((10.0, 10.0, 0.0), abs=0.05)
    mixed = flown(
        tmp_path,
        SQUARE[0],
        SQUARE[1],
        waypoint(40, 40, 12, yaw=180),
        roi,
        waypoint(0, 40, 12),
        item(197),
        waypoint(0, 0, 12),
    )
    assert isinstance(mixed.yaw, YawProfile)
    assert math.degrees(mixed.beta(15.0)) == pytest.approx(0.0, abs=0.1)  # along the first leg
    assert abs(math.degrees(mixed.beta(60.0))) % 360.0 == pytest.approx(180.0, abs=0.1)  # as the waypoint says
    x, y, _ = mixed.table.at(100.0)[0]
    towards = math.atan2(10.0 - y, 10.0 - x)
    assert math.remainder(mixed.beta(100.0) - towards, math.tau) == pytest.approx(0.0, abs=0.02)
    assert math.degrees(math.remainder(mixed.beta(145.0), math.tau)) == pytest.approx(-90.0, abs=0.1)


def test_a_survey_is_read_as_it_was_written_out(tmp_path: Path) -> None:
    lanes = [waypoint(60 * (j // 2 % 2 == j % 2), 20 * (j // 2), 25) for j in range(8)]
    lanes.insert(1, item(206, 25, 0, 1))
    mission = flown(tmp_path, waypoint(0, 0, 25, command=22), survey(*lanes), item(20))
    assert mission.table.length == pytest.approx(4 * 60 + 3 * 20 + 60, abs=15.0)
    assert len(mission.notes) == 1
    assert {(action.command, action.number) for action in mission.actions} == {(203, 3)}
    assert len(mission.actions) == 1 + math.floor((mission.table.length - mission.actions[0].s) / 25.0 + 0.25)
    corridor = read(survey(*lanes, kind="CorridorScan"))
    assert [i.command for i in corridor.items].count(16) == 8


def test_a_structure_scan_is_written_out_as_qgroundcontrol_would() -> None:
    corners = [[HOME[0] + n * NORTH, HOME[1] + e * EAST] for n, e in ((0, 0), (0, 20), (10, 20), (10, 0))]
    scan = {
        "type": "ComplexItem", "complexItemType": "StructureScan", "version": 3, "polygon": corners,
        "EntranceAltitude": 30, "ScanBottomAlt": 4, "StructureHeight": 16, "Layers": 2, "StartFromTop": True,
        "GimbalPitch": 0, "CameraCalc": {"DistanceToSurface": 5, "AdjustedFootprintFrontal": 6, "version": 2},
    }  # fmt: skip
    way = route_of(read(scan))
    assert heights(way.waypoints) == [30.0, *[13.0] * 5, *[7.0] * 5, 30.0]
    home = LocalFrame(*HOME)
    lap = [w.place.seen_from(home)[:2] for w in way.waypoints[1:6]]
    assert lap[0] == pytest.approx((-5.0, -5.0), abs=0.05)
    assert lap[2] == pytest.approx((15.0, 25.0), abs=0.05)
    assert lap[4] == lap[0]
    walls = [(c[0], c[1]) for c in corners]
    for corner, same in zip(grown(walls, 5.0), grown(walls[::-1], 5.0)[::-1], strict=True):
        assert corner == pytest.approx(same, abs=1e-8)  # whichever way round it was drawn


def test_jumps() -> None:
    a, b, c = waypoint(0, 0, 10), waypoint(20, 0, 11), waypoint(20, 20, 12)
    twice = route_of(read(a, b, c, item(177, 2, 2), waypoint(0, 40, 13)))
    assert heights(twice.waypoints) == [10.0, 11.0, 12.0, 11.0, 12.0, 11.0, 12.0, 13.0]
    for_ever = route_of(read(waypoint(-9, 0, 9, command=22), a, b, c, item(177, 2, -1)))
    assert for_ever.closed
    assert heights(for_ever.waypoints) == [10.0, 11.0, 12.0]
    assert "what comes before the loop" in for_ever.notes[0]


def test_landing_and_returning_end_the_path(tmp_path: Path) -> None:
    landing = flown(tmp_path, *SQUARE, waypoint(0, 60, 0, command=21), waypoint(99, 99, 50))
    assert landing.table.at(landing.table.length)[0] == pytest.approx((0.0, 60.0, -15.0), abs=0.1)  # above it
    assert "ends above the landing place" in landing.notes[0]
    returning = flown(tmp_path, *SQUARE, item(20))
    assert "returns home" in returning.notes[0]


@pytest.mark.parametrize(
    ("end", "name"),
    [(waypoint(0, 60, 0, command=21), "the landing"), (item(20), "the return"),
     (waypoint(0, 60, 15, command=17), "the loiter without an end"), (item(177, 2, -1), "the loop without an end")],
)  # fmt: skip
def test_what_a_plan_flies_after_the_end_of_the_path_is_told(tmp_path: Path, end: dict[str, Any], name: str) -> None:
    """Deliveries land, wait and fly back: who flies such a plan must know that the rest of it is not flown."""
    back = (
        item(93, 5),
        waypoint(0, 60, 15, command=22),
        item(206, 25, 0, 1),
        waypoint(0, 0, 15),
        waypoint(0, 0, 0, command=21),
    )
    mission = flown(tmp_path, *SQUARE, end, *back, item(20))
    lines = (tmp_path / "field.plan").read_text().splitlines()
    begin = [i for i, line in enumerate(lines) if '"SimpleItem"' in line]
    note = mission.notes[-1]
    found = re.fullmatch(
        rf"NOT FLOWN: items 7 to 10, after {name} \(line (\d+) on\); they need a plan of their own", note
    )
    assert found and begin[5] < int(found[1]) - 1 <= begin[6]


def test_what_comes_after_the_end_of_the_path_and_flies_nowhere() -> None:
    landing, gripper = waypoint(0, 60, 0, command=21), item(211, 1, 0)
    assert route_of(read(*SQUARE, landing, gripper)).notes[-1] == (
        "NOT CARRIED OUT: item 6, after the landing; do it yourself"
    )
    assert (
        "NOT FLOWN: item 7, after the landing; it needs a plan of its own"
        in route_of(read(*SQUARE, landing, item(93, 5), waypoint(0, 0, 9))).notes
    )
    for rest in ([], [item(20)], [item(93, 5), item(178, 1, 3)]):
        assert "NOT" not in " ".join(route_of(read(*SQUARE, landing, *rest)).notes)
    plan_of = read(*SQUARE, landing, waypoint(0, 0, 9), waypoint(9, 0, 9), waypoint(9, 9, 9))
    twice = [given._replace(number=given.number - 4) if given.number > 7 else given for given in plan_of.items]
    said = "NOT FLOWN: 3 items from item 6 on, after the landing; they need a plan of their own"
    assert said in route_of(replace(plan_of, items=tuple(twice))).notes
    # a jump that has brought the path round an item before leaves nothing out
    assert "NOT" not in " ".join(route_of(read(*SQUARE, item(177, 2, 1), landing)).notes)


def test_a_turn_on_the_spot_and_doubled_waypoints(tmp_path: Path) -> None:
    there_and_back = flown(tmp_path, waypoint(0, 0, 10), waypoint(50, 0, 10), waypoint(50, 0, 10), waypoint(0, 0, 10))
    assert there_and_back.table.length == pytest.approx(100.0, abs=3.0)
    furthest = max(there_and_back.table.at(0.1 * i)[0][0] for i in range(1000))
    assert furthest == pytest.approx(50.0, abs=1.0)
    up_and_down = flown(tmp_path, waypoint(0, 0, 10), waypoint(0, 0, 30), waypoint(20, 0, 30))
    assert math.isfinite(up_and_down.beta(5.0))


def test_the_fence_of_a_plan(tmp_path: Path) -> None:
    corners = [[HOME[0] + n * NORTH, HOME[1] + e * EAST] for n, e in ((-50, -50), (-50, 90), (90, 90), (90, -50))]
    circle = {"circle": {"center": list(HOME[:2]), "radius": 7.0}, "inclusion": False, "version": 1}
    polygon = {"polygon": corners, "inclusion": True, "version": 1}
    mission = flown(tmp_path, *SQUARE, polygons=[polygon], circles=[circle])
    assert mission.fence is not None
    square, disc = mission.fence.areas
    assert isinstance(square, Polygon) and square.inside
    assert disc == Circle((0.0, 0.0), 7.0, inside=False)
    assert mission.fence.margin((0.0, 60.0, -10.0)) == pytest.approx(30.0, abs=0.05)
    assert mission.fence.margin((0.0, 2.0, -10.0)) == pytest.approx(-5.0)


@pytest.mark.parametrize(
    ("change", "key", "said"),
    [
        (lambda p: p.update(fileType="Mission"), "fileType", "expected a .plan"),
        (lambda p: p.update(version=2), "version", "version 2 is not known; expected 1"),
        (lambda p: p["mission"].update(version=1), "mission.version", "expected 2"),
        (lambda p: p.pop("mission"), "mission", "missing"),
        (lambda p: p["mission"].update(items=[]), "mission.items", "two waypoints (three in a loop), found none"),
        (lambda p: p["mission"].update(items=p["mission"]["items"][:1]), "mission.items", "found one"),
        (lambda p: p["mission"].update(items=7), "mission.items", "7 is not a list"),
        (lambda p: p["mission"].update(plannedHomePosition=[1, "2"]), "mission.plannedHomePosition", "2 numbers"),
        (lambda p: p["mission"].update(hoverSpeed=-3), "mission.hoverSpeed", "no speed"),
        (lambda p: p["mission"]["items"][1].update(type="Thing"), "mission.items[1].type", "'Thing' is not known"),
        (lambda p: p["mission"]["items"][1].pop("command"), "mission.items[1].command", "missing"),
        (lambda p: p["mission"]["items"][1].update(params=[1, 2]), "mission.items[1].params", "seven numbers"),
        (lambda p: p["mission"]["items"][1]["params"].__setitem__(4, "north"), "mission.items[1].params[4]", "'north' is not"),
        (lambda p: p["mission"]["items"][1]["params"].__setitem__(4, 95.0), "mission.items[1]", "no place on the earth"),
        (lambda p: p["mission"]["items"][1]["params"].__setitem__(6, None), "mission.items[1]", "no altitude"),
        (lambda p: p["mission"]["items"][1].update(frame=10), "mission.items[1]", "over the terrain"),
        (lambda p: p["mission"]["items"][1].update(frame=1), "mission.items[1]", "frame 1"),
        (lambda p: p["mission"]["items"][1].update(command=84), "mission.items[1]", "VTOL"),
        (lambda p: p["mission"]["items"][1].update(command=94), "mission.items[1]", "command 94"),
        (lambda p: p["mission"]["items"].append({"type": "ComplexItem", "complexItemType": "fwLandingPattern"}), "mission.items[4].complexItemType", "fixed wing"),
        (lambda p: p["mission"]["items"].append({"type": "ComplexItem", "complexItemType": "survey"}), "mission.items[4].TransectStyleComplexItem", "save it again"),
        (lambda p: p["mission"]["items"].append(item(177, 40, 1)), "mission.items[4]", "not in the plan"),
        (lambda p: p["mission"]["items"].append(item(178, 1, -7)), "mission.items[4]", "speed of -7"),
        (lambda p: p["geoFence"].update(polygons=[{"polygon": [[1, 2]]}]), "geoFence.polygons[0].polygon", "three corners"),
        (lambda p: p["geoFence"].update(circles=[{"circle": {"center": [1, 2], "radius": -1}}]), "geoFence.circles[0].circle.radius", "more than 0"),
        (lambda p: p["rallyPoints"].update(points=[[1, 2]]), "rallyPoints.points[0]", "3 numbers"),
    ],
)  # fmt: skip
def test_faults_of_a_plan_have_their_line(tmp_path: Path, change: Any, key: str, said: str) -> None:
    data = plan(*(json.loads(json.dumps(given)) for given in SQUARE))
    change(data)
    content = json.dumps(data, indent=2)
    found = faults(tmp_path, content)
    match = [fault for fault in found if f": {key}: " in fault and said in fault]
    assert match, found
    line = content.splitlines()[int(match[0].split(":")[1]) - 1]
    word = key.split(".")[-1]
    assert word.endswith("]") or f'"{word}"' in line or "missing" in match[0] or "save it again" in match[0]


def test_broken_json_has_its_line(tmp_path: Path) -> None:
    content = text(*SQUARE)
    at = content.index('"frame"')
    broken = content[:at] + "frame" + content[at + 7 :]
    (fault,) = faults(tmp_path, broken)
    line = content[:at].count("\n") + 1
    assert fault.startswith(f"field.plan:{line}: ")
    assert "not valid JSON" in fault
    assert "given twice, first on line 2" in faults(tmp_path, '{\n"a": 1,\n"a": 2}')[0]
    assert parse_json('{"a": [1, 2.5, "x", null, true]}', "f").data == {"a": [1, 2.5, "x", None, True]}


def test_waypoint_files(tmp_path: Path) -> None:
    lines = ["QGC WPL 110", f"0\t1\t0\t16\t0\t0\t0\t0\t{HOME[0]}\t{HOME[1]}\t{HOME[2]}\t1"]
    for i, given in enumerate(SQUARE, 1):
        numbers = [0 if p is None else p for p in given["params"]]
        numbers[3] = "nan"
        lines.append("\t".join(map(str, [i, 0, 3, given["command"], *numbers, 1])))
    content = "\n".join(lines) + "\n"
    (tmp_path / "field.waypoints").write_text(content)
    mission = load_mission(str(tmp_path / "field.waypoints"), Level.MOTORS)
    assert mission.origin == GlobalOrigin(HOME[0], HOME[1], 0.0, True)
    assert mission.table.length == pytest.approx(flown(tmp_path, *SQUARE).table.length)
    assert "taken for home" in mission.notes[0]
    plain = plan_from(content.replace("110", "120"), "f.waypoints")[0]
    assert (len(plain.items), plain.home) == (5, None)
    assert "expected 12" in faults(tmp_path, content.replace("\t1\n", "\n"), "field.waypoints")[0]
    (bad,) = faults(tmp_path, content.replace("\t12\t", "\tup\t", 1), "field.waypoints")
    assert bad.startswith("field.waypoints:3: expected numbers")
    assert 'first line "QGC WPL 110"' in faults(tmp_path, "1\t2\t3", "field.waypoints")[0]


def zigzag(count: int) -> Curve:
    return polyline([(i * 3.0, 6.0 * ((i + 1) // 2 % 2), -25.0) for i in range(count)], False, 1.0)


def calls_of_a_step(count: int) -> list[int]:
    """How many functions a step of the law calls at some places of a path of ``count`` waypoints."""
    curve = zigzag(count)
    model = model_of(load_vehicle("x500"))
    law = curve_law(
        curve, ConstantSpeed(3.0), TangentYaw(), Level.MOTORS, model, default_gains(Level.MOTORS), Bounds(), 1.0
    )
    found = []
    for share in (0.0, 0.3, 0.7):
        waves = math.floor(share * count / 4)
        s = curve.arc(waves * 2.0 * (math.hypot(3.0, 6.0) + 3.0) + 3.3)  # half along a lane, whichever it is
        x, y, z = curve.table.at(s)[0]
        flying = Flying((x + 0.1, y + 0.1, z), (2.0, 1.0, 0.1), rotation_from_euler(0.1, 0.1, -0.1), 19.0, s=s)
        law(flying, SpeedScale())  # what is made once is made
        calls = 0

        def count_call(frame: Any, event: str, argument: Any) -> None:
            nonlocal calls
            calls += event in ("call", "c_call")

        sys.setprofile(count_call)
        law(flying, SpeedScale())
        sys.setprofile(None)
        found.append(calls)
    return found


def test_a_step_of_the_law_costs_no_more_on_a_long_plan() -> None:
    """In calls, which do not depend on what else the machine does; bench/plan_size.py has the time."""
    assert max(calls_of_a_step(1000)) <= 1.2 * max(calls_of_a_step(10))


def importer() -> Any:
    """MAVSDK's own reader of plans, on a vehicle that is one heartbeat."""
    from mavsdk import Configuration, Mavsdk
    from mavsdk.logging import log_subscribe
    from mavsdk.plugins.mission_raw import MissionRaw

    log_subscribe(lambda *a: True)
    sdk = Mavsdk(Configuration.create_manual(1, 191, True))
    sdk.add_any_connection("raw://")
    sdk.pass_received_raw_bytes(Encoder(1, 1).message(message("HEARTBEAT"), type=2, autopilot=12, system_status=3))
    system = sdk.first_autopilot(5.0)
    assert system is not None
    return sdk, MissionRaw(system)


def same(a: float, b: float) -> bool:
    return (math.isnan(a) and math.isnan(b)) or a == pytest.approx(b, rel=1e-6, abs=1e-9)


def random_plan(rng: random.Random) -> str:
    items: list[dict[str, Any]] = [waypoint(0, 0, 10, command=22)]
    for _ in range(rng.randrange(2, 12)):
        point = waypoint(rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(5, 90), yaw=rng.choice([None, 45.0]),
                         hold=rng.choice([0, 3]), frame=rng.choice([0, 3]))  # fmt: skip
        command = item(rng.choice([178, 206, 2000, 115]), rng.choice([0, 1]), rng.uniform(1, 9))
        items.append(rng.choice([point, point, command, survey(point, item(206, 25, 0, 1), waypoint(1, 2, 30))]))
    corners = [[HOME[0] + rng.uniform(0, 1e-3), HOME[1] + rng.uniform(0, 1e-3)] for _ in range(4)]
    circle = {"circle": {"center": corners[0], "radius": 40.0}, "inclusion": True, "version": 1}
    polygon = {"polygon": corners, "inclusion": rng.random() < 0.5, "version": 1}
    return text(*json.loads(json.dumps(items)), polygons=[polygon], circles=[circle], rally=[[*corners[1], 20.0]])


def test_plans_are_read_as_mavsdk_reads_them() -> None:
    sdk, reader = importer()
    rng = random.Random(7)
    try:
        for _ in range(30):
            content = random_plan(rng)
            theirs = reader.import_qgroundcontrol_mission_from_string(content)
            ours = plan_from(content, "field.plan")[0]
            assert len(ours.items) == len(theirs.mission_items)
            for mine, other in zip(ours.items, theirs.mission_items, strict=True):
                assert (mine.command, mine.frame) == (other.command, other.frame)
                params = [other.param1, other.param2, other.param3, other.param4]
                assert all(map(same, mine.params[:4], params))
                scale = 1.0 if mine.frame == 2 else 1e7
                assert (round(mine.params[4] * scale), round(mine.params[5] * scale)) == (other.x, other.y)
                assert same(mine.params[6], other.z)
            fence = [
                ((5001 if area.inside else 5002) if area.radius is None else (5003 if area.inside else 5004),
                 round(corner[0] * 1e7), round(corner[1] * 1e7), area.radius or len(area.corners))
                for area in ours.fence for corner in area.corners
            ]  # fmt: skip
            assert fence == [(f.command, f.x, f.y, f.param1) for f in theirs.geofence_items]
            assert [round(place.latitude * 1e7) for place in ours.rally] == [r.x for r in theirs.rally_items]
    finally:
        sdk.destroy()


def test_a_mission_may_say_more_than_its_plan(tmp_path: Path) -> None:
    written(tmp_path / "field.plan", *SQUARE)
    mission = tmp_path / "m.yaml"
    mission.write_text(
        "mission: m\nframe: enu\norigin: takeoff\npath: {kind: plan, file: field.plan, smooth: true}\nspeed: 3.0\nyaw: 90\n"
    )
    found = load_mission(str(mission), Level.MOTORS)
    assert found.origin is Origin.TAKEOFF
    assert found.alpha(1.0) == 3.0
    assert found.yaw == ConstantYaw(math.radians(90.0))
    assert found.table.locate((40.0, 30.0, -15.0))[1] < 0.05  # a spline goes through
    mission.write_text(
        "mission: m\nframe: enu\norigin: [47, 8, 400]\nrotate_deg: 5\npath: {kind: plan, file: field.plan}\nspeed: plan\n"
    )
    with pytest.raises(ConfigError) as caught:
        load_mission(str(mission), Level.MOTORS)
    assert [fault.key for fault in caught.value.faults] == ["origin", "rotate_deg"]
    mission.write_text("mission: m\nframe: enu\npath: {kind: plan, file: none.plan}\nspeed: plan\n")
    with pytest.raises(ConfigError, match="no such file"):
        load_mission(str(mission), Level.MOTORS)
    mission.write_text("mission: m\nframe: ned\npath: {kind: circle, center: [0, 0, -5], radius: 3}\nspeed: plan\n")
    with pytest.raises(ConfigError, match="the path is no plan"):
        load_mission(str(mission), Level.MOTORS)


@pytest.mark.parametrize("turn", [40, 100, 125, 150, 179, 180])
def test_corners_of_any_sharpness_can_be_flown(tmp_path: Path, turn: float) -> None:
    along, across = 40.0 * math.cos(math.radians(turn)), 40.0 * math.sin(math.radians(turn))
    mission = flown(tmp_path, waypoint(-40, 0, 10), waypoint(0, 0, 10), waypoint(along, across, 10))
    bends = [math.hypot(*mission.table.at(0.02 * i)[2]) for i in range(4000)]
    assert 1.0 / max(bends) > 0.35
    assert mission.table.locate((0.0, 0.0, -10.0))[1] < 1.01
