"""Where missions stand: home, take-off point, places on the earth, and the vehicle's local frame."""

from __future__ import annotations

import math
import random
import re

import pytest

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.geodesy import LocalFrame, MapProjection
from companion.law.gains import Level
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.origins import PlaceError, VehicleLocation, home_in, origin_in, placed
from companion.places.words import words_of_place

ZURICH = LocalFrame(47.397742, 8.545594, 489.4)
STANDING = VehicleLocation((12.0, -3.0, -0.2), on_ground=True)


def circle(origin: str = "", frame: str = "ned") -> Mission:
    height = -10 if frame == "ned" else 10
    text = f"mission: m\nframe: {frame}\n{origin}\npath: {{kind: circle, center: [0, 0, {height}], radius: 5}}\nspeed: 2.0\n"
    return mission_from(parse(text, "m.yaml"), Level.MOTORS)


def test_local_takeoff_and_home() -> None:
    assert origin_in(Origin.LOCAL, STANDING) == (0.0, 0.0, 0.0)
    assert origin_in(Origin.TAKEOFF, STANDING) == STANDING.p_n
    assert origin_in(Origin.HOME, VehicleLocation((0.0, 0.0, 0.0), home_n=(4.0, 5.0, 1.0))) == (4.0, 5.0, 1.0)


def test_home_as_a_place_on_the_earth_wins_over_its_old_coordinates() -> None:
    home = ZURICH.to_global((30.0, 40.0, 2.0))
    assert home_in(VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH, home=home)) == pytest.approx(
        (30.0, 40.0, 2.0), abs=1e-6
    )
    near = VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH, home=home, home_n=(30.0, 41.0, 2.0))
    assert home_in(near) == pytest.approx((30.0, 40.0, 2.0), abs=1e-6)
    with pytest.raises(PlaceError, match="given twice, 50 m apart"):
        home_in(VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH, home=home, home_n=(0.0, 0.0, 2.0)))


def test_a_place_on_the_earth_needs_the_vehicles_frame() -> None:
    origin = GlobalOrigin(*ZURICH.to_global((100.0, 200.0, -7.0)))
    where = VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH)
    assert origin_in(origin, where) == pytest.approx((100.0, 200.0, -7.0), abs=1e-6)
    with pytest.raises(PlaceError, match="GPS_GLOBAL_ORIGIN"):
        origin_in(origin, STANDING)


def test_an_altitude_above_home() -> None:
    home = ZURICH.to_global((30.0, 40.0, 2.0))
    latitude, longitude, _ = ZURICH.to_global((100.0, 200.0, 0.0))
    where = VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH, home=home)
    origin = GlobalOrigin(latitude, longitude, 15.0, above_home=True)
    assert origin_in(origin, where) == pytest.approx((100.0, 200.0, -13.0), abs=1e-6)  # 15 m above 2 m below


@pytest.mark.parametrize(
    ("origin", "where", "said"),
    [
        (Origin.TAKEOFF, VehicleLocation((0.0, 0.0, -5.0), on_ground=False), "needs a vehicle on the ground"),
        (Origin.TAKEOFF, VehicleLocation((0.0, 0.0, -5.0)), "needs a vehicle on the ground"),
        (Origin.HOME, STANDING, "home is not known"),
        (GlobalOrigin(48.5, 9.0, 300.0), VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH), "127 km from the vehicle"),
        (GlobalOrigin(47.4, 8.5, 9.0, True), VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH), "home is not known"),
    ],
)
def test_what_is_not_known_is_said(origin: Origin | GlobalOrigin, where: VehicleLocation, said: str) -> None:
    with pytest.raises(PlaceError, match=said):
        origin_in(origin, where)


def test_a_mission_moves_to_its_place() -> None:
    mission = placed(circle(), Origin.TAKEOFF, STANDING)
    assert mission.table.at(0.0)[0] == pytest.approx((17.0, -3.0, -10.2))
    assert placed(circle("origin: local"), Origin.TAKEOFF, STANDING).table.at(0.0)[0] == pytest.approx((5, 0, -10))


def test_a_mission_far_from_the_frames_origin_lies_where_px4_would_put_it() -> None:
    """Every point of a path that counts from a place 8 km away, against PX4's projection of that point itself."""
    rng = random.Random(5)
    for frame in ("ned", "enu"):
        own = LocalFrame(*ZURICH.to_global((5000.0, 6000.0, -3.0)))
        mission = circle(f"origin: [{own.latitude}, {own.longitude}, {own.altitude}]", frame)
        moved = placed(mission, Origin.LOCAL, VehicleLocation((0.0, 0.0, 0.0), frame=ZURICH))
        for _ in range(20):
            point = (rng.uniform(-500.0, 500.0), rng.uniform(-500.0, 500.0), rng.uniform(-50.0, 0.0))
            there = ZURICH.to_local(*own.to_global(point))
            given = point if frame == "ned" else (point[1], point[0], -point[2])
            assert moved.placement.to_local(given) == pytest.approx(there, abs=1e-3)


def test_true_north_leans_as_meridians_do() -> None:
    """The meridians converge by the sine of the latitude times the difference in longitude."""
    assert ZURICH.north_at(47.6, 8.545594) == pytest.approx(0.0, abs=1e-12)
    leaning = ZURICH.north_at(47.397742, 8.645594)
    assert leaning == pytest.approx(-math.sin(math.radians(47.397742)) * math.radians(0.1), rel=1e-3)
    projection = MapProjection(ZURICH.latitude, ZURICH.longitude)
    (n0, e0), (n1, e1) = projection.project(47.397742, 8.645594), projection.project(47.398742, 8.645594)
    assert leaning == pytest.approx(math.atan2(e1 - e0, n1 - n0), abs=1e-6)


def path(points: str, frame: str = "ned", origin: str = "") -> Mission:
    text = f"mission: m\nframe: {frame}\n{origin}\npath: {{kind: line, {points}}}\nspeed: 2.0\n"
    return mission_from(parse(text, "m.yaml"), Level.MOTORS)


def test_words_for_heights_and_places() -> None:
    words = words_of_place(path("from: [12, -3, -10], to: [60, -3, -14]"), Origin.TAKEOFF)
    assert words.lines == (
        "the path runs 10.0 to 14.0 m above the take-off point",
        "it begins 10.0 m up, 12 m north and 3 m west of that point",
        "it lies 12 to 60 m north, 3 m west of that point",
    )
    assert words.warnings == ()
    assert words_of_place(circle(), Origin.HOME).lines[0] == "the path runs 10.0 m above home"
    assert "where its estimator started" in words_of_place(circle("origin: local"), Origin.HOME).lines[0]


def test_words_for_a_path_under_the_ground() -> None:
    wrong = path("from: [0, 0, 10], to: [50, 0, 10]")
    words = words_of_place(wrong, Origin.TAKEOFF)
    assert words.lines[0] == "the path runs 10.0 m BELOW the take-off point"
    (warning,) = words.warnings
    assert "under the ground" in warning
    assert "10 m up is z = -10" in warning
    assert "z points up in frame: enu" in str(
        words_of_place(path("from: [0, 0, -9], to: [50, 0, -9]", "enu"), Origin.HOME)
    )
    (into,) = words_of_place(path("from: [0, 0, 5], to: [50, 0, -9]"), Origin.TAKEOFF).warnings
    assert "down to 5.0 m BELOW the take-off point" in into
    (low,) = words_of_place(path("from: [0, 0, -0.4], to: [50, 0, -9]"), Origin.TAKEOFF).warnings
    assert "comes down to 0.4 m" in low
    (high,) = words_of_place(path("from: [0, 0, -9], to: [50, 0, -150]"), Origin.TAKEOFF).warnings
    assert "150 m above" in high


@pytest.mark.parametrize(
    ("begin", "end", "said"),
    [
        ([-169.4, 0, -10], [-17_300, 410, -10], "it lies 169 m to 17.3 km south, 0 to 410 m east of that point"),
        ([12_100, 0, -10], [17_300, 0, -10], "it lies 12.1 to 17.3 km north, 0 m east of that point"),
        ([-0.0, -0.0, -10], [-6, -14_000, -10], "it lies 0 to 6 m south, 0 m to 14.0 km west of that point"),
        (
            [0.2, -3, -10],
            [-12_000, 11_000, -10],
            "it lies 0 m to 12.0 km south, 3 m west to 11.0 km east of that point",
        ),
    ],
)
def test_a_span_has_both_units_where_they_differ(begin: list[float], end: list[float], said: str) -> None:
    assert words_of_place(path(f"from: {begin}, to: {end}"), Origin.TAKEOFF).lines[2] == said


@pytest.mark.parametrize("z", [0.0, -0.0, 0.04, -0.04])
def test_a_path_at_the_height_of_the_ground_is_neither_above_nor_below(z: float) -> None:
    words = words_of_place(path(f"from: [0, 0, {z}], to: [-50, 0, {z}]"), Origin.TAKEOFF)
    assert words.lines[0] == "the path runs at the height of the take-off point"
    assert words.lines[1] == "it begins at that point"
    assert words.warnings == (
        "the whole path is on the ground, at the height of the take-off point: give it a height to fly at",
    )
    rising = words_of_place(path(f"from: [0, 0, {z}], to: [-50, 0, -20]"), Origin.HOME)
    assert rising.lines[0] == "the path runs 0.0 to 20.0 m above home"
    assert rising.warnings == ("the path comes down to the height of home: to the ground, where that is level",)
    sinking = words_of_place(path(f"from: [0, 0, {z}], to: [-50, 0, 20]"), Origin.HOME)
    assert sinking.lines[0] == "the path runs 0.0 to 20.0 m BELOW home"


def test_no_figure_is_minus_zero() -> None:
    for z in (-0.0, -0.01, 0.01):
        for x in (-0.0, -0.4, -0.01):
            for far in (-3.0, -20_000.0, 20_000.0):
                mission = path(f"from: [{x}, {x}, {z}], to: [{far}, {x}, {z}]")
                words = str(words_of_place(mission, Origin.HOME))
                assert not re.search(r"-0(\.0*)?(?![.\d])", words), words


def test_words_for_a_path_from_a_vehicle() -> None:
    mission = path("from: [0, 0, -10], to: [50, 0, -10]", origin="origin: local")
    words = words_of_place(mission, Origin.LOCAL, VehicleLocation((-20.0, 0.0, 2.0), on_ground=True))
    assert words.lines[0] == "the path runs 12.0 m above the ground where the vehicle stands"
    assert words.lines[1] == "it begins 12.0 m up, 20 m north of that point"
    assert "local frame" in words_of_place(mission, Origin.LOCAL, VehicleLocation((0.0, 0.0, -5.0))).lines[0]
    flying = VehicleLocation((0.0, 0.0, -5.0), on_ground=False, home_n=(0.0, 0.0, 3.0))
    assert words_of_place(mission, Origin.LOCAL, flying).lines[0] == "the path runs 13.0 m above home"
    far = words_of_place(path("from: [3000, 0, -10], to: [3050, 0, -10]"), Origin.TAKEOFF, STANDING)
    assert "3.0 km away" in far.warnings[0]


def test_words_for_a_place_on_the_earth() -> None:
    words = words_of_place(circle("origin: [47.4, 8.5, 490]"), Origin.TAKEOFF)
    assert (
        words.lines[0]
        == "the path runs 10.0 m above the mission's origin (47.400000, 8.500000, 490.0 m above sea level)"
    )
    assert words.lines[1] == "that is 500.0 m above sea level"
    where = VehicleLocation((0.0, 0.0, 0.0), True, LocalFrame(47.4, 8.5, 495.0))
    words = words_of_place(circle("origin: [47.4, 8.5, 490]"), Origin.TAKEOFF, where)
    assert words.lines[:2] == (
        "the path runs 5.0 m above the ground where the vehicle stands",
        "that is 500.0 m above sea level",
    )
