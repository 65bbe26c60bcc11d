"""Latitude and longitude in mission files, and fences."""

from __future__ import annotations

import pytest

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.fence import Circle, Polygon
from companion.geodesy import LocalFrame
from companion.law.gains import Level
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.origins import VehicleLocation, placed

HOME = (47.397742, 8.545594, 489.4)
ZURICH = LocalFrame(*HOME)

POINTS = """\
mission: m
frame: {frame}
path:
  kind: spline
  points:
    - {{lat: 47.397742, lon: 8.545594, above_home: 10}}
    - {{lat: 47.398000, lon: 8.545700, above_home: 12}}
    - {{lat: 47.398100, lon: 8.546200, above_home: 15}}
speed: 3.0
yaw: {{look_at: {{lat: 47.3985, lon: 8.5455, above_home: 0}}}}
"""


def read(text: str) -> Mission:
    return mission_from(parse(text, "m.yaml"), Level.MOTORS)


def faults(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        read(text)
    return [str(fault) for fault in caught.value.faults]


@pytest.mark.parametrize("frame", ["ned", "enu"])
@pytest.mark.parametrize("turn", ["", "rotate_deg: 30\n"])
def test_places_are_where_px4_would_put_them(frame: str, turn: str) -> None:
    mission = read(POINTS.format(frame=frame) + turn)
    assert mission.origin == GlobalOrigin(47.397742, 8.545594, 0.0, above_home=True)
    own = LocalFrame(47.39, 8.55, 480.0)
    there = placed(mission, Origin.LOCAL, VehicleLocation((0.0, 0.0, 0.0), frame=own, home=HOME))
    for latitude, longitude, height in ((47.397742, 8.545594, 10.0), (47.398, 8.5457, 12.0), (47.3981, 8.5462, 15.0)):
        assert there.table.locate(own.to_local(latitude, longitude, HOME[2] + height))[1] < 1e-3
    assert there.look_at is not None
    faced = own.to_local(47.3985, 8.5455, HOME[2])
    assert there.placement.to_local(there.look_at) == pytest.approx(faced, abs=1e-3)


def test_heights_above_the_sea() -> None:
    text = POINTS.format(frame="ned").replace("above_home: 1", "amsl: 50").replace("above_home: 0", "amsl: 489")
    mission = read(text.replace("frame: ned", "frame: ned\norigin: [47.3977, 8.5455, 489]"))
    assert mission.origin == GlobalOrigin(47.3977, 8.5455, 489)
    assert mission.table.at(0.0)[0][2] == pytest.approx(489.0 - 500.0)
    (fault,) = faults(text)
    assert "heights above sea level need origin" in fault
    (mixed,) = faults(text.replace("frame: ned", "frame: ned\norigin: {lat: 47.3977, lon: 8.5455, above_home: 0}"))[:1]
    assert mixed == "m.yaml:7: path.points[0]: its height counts from elsewhere than the origin's; expected above_home"


def test_an_origin_above_home() -> None:
    text = "mission: m\nframe: ned\norigin: {lat: 47.4, lon: 8.5, above_home: 3}\npath: {kind: circle, center: [0, 0, -9], radius: 5}\nspeed: 2\n"
    assert read(text).origin == GlobalOrigin(47.4, 8.5, 3, above_home=True)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("lat: 47.398000", "lat: 97.4", "m.yaml:7: path.points[1].lat: 97.4 is no latitude; expected a number from -89 to 89"),
        ("lat: 47.398000", "lat: north", "m.yaml:7: path.points[1].lat: 'north' is no latitude"),
        ("lat: 47.398000, ", "", "m.yaml:7: path.points[1].lat: missing"),
        ("above_home: 12", "amsl: 500", "m.yaml:7: path.points[1]: its height counts from elsewhere than the origin's"),
        (", above_home: 12", "", "m.yaml:7: path.points[1]: no height; expected one of above_home and amsl"),
        ("above_home: 12", "alt: 12", "m.yaml:7: path.points[1].alt: unknown key"),
        ("frame: ned", "frame: ned\norigin: takeoff", "m.yaml:3: origin: the file gives places in latitude and longitude"),
        ("frame: ned", "frame: ned\norigin: [91, 8, 400]", "m.yaml:3: origin.lat: 91 is no latitude"),
    ],
)  # fmt: skip
def test_faults_of_places(old: str, new: str, said: str) -> None:
    found = faults(POINTS.format(frame="ned").replace(old, new))
    assert any(fault.startswith(said) for fault in found), found


def test_a_fence() -> None:
    text = """\
mission: m
frame: enu
path: {kind: circle, center: [0, 0, 9], radius: 5}
speed: 2
fence:
  - inside: [[-20, -10], [20, -10], [20, 40], [-20, 40]]
  - outside: {center: [10, 0], radius: 2}
"""
    mission = read(text)
    assert mission.fence is not None
    assert [type(area) for area in mission.fence.areas] == [Polygon, Circle]
    assert mission.fence_n is not None
    assert mission.fence_n.margin((39.0, 0.0, -9.0)) == pytest.approx(1.0)  # y of the mission is north
    assert mission.fence_n.margin((0.0, 10.0, -9.0)) == pytest.approx(-2.0)
    (fault,) = faults(text.replace("  - outside: {", "  - inside: [[0, 0], [1, 1], [2, 0]]\n    outside: {"))
    assert "expected one of inside and outside" in fault
    assert "at least 3" in faults(text.replace("[[-20, -10], [20, -10], [20, 40], [-20, 40]]", "[[0, 0], [1, 1]]"))[0]
    assert "did you mean inside" in faults(text.replace("inside", "insid"))[0]


def test_a_fence_on_the_earth() -> None:
    text = """\
mission: m
frame: ned
origin: [47.397742, 8.545594, 489.4]
path: {kind: circle, center: [0, 0, -9], radius: 5}
speed: 2
fence:
  - inside: {center: {lat: 47.397742, lon: 8.545594}, radius: 30}
"""
    mission = read(text)
    assert mission.fence is not None and mission.fence.margin((0.0, 0.0, 0.0)) == pytest.approx(30.0)
    assert "no height in a fence" in faults(text.replace("lon: 8.545594}", "lon: 8.545594, amsl: 3}"))[0]
