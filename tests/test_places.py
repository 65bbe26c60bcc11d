"""Where missions stand: home, take-off point, places on the earth, and the vehicle's local frame."""

from __future__ import annotations

import math
import random

import pytest

from companion.config.document import parse
from companion.config.mission import mission_from
from companion.geodesy import LocalFrame, MapProjection
from companion.law.gains import Level
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.standing import PlaceError, Whereabouts, home_in, origin_in, placed

ZURICH = LocalFrame(47.397742, 8.545594, 489.4)
STANDING = Whereabouts((12.0, -3.0, -0.2), on_ground=True)


def circle(origin: str = "", frame: str = "ned") -> Mission:
    height = -10 if frame == "ned" else 10
    text = f"mission: m\nframe: {frame}\n{origin}\npath: {{kind: circle, center: [0, 0, {height}], radius: 5}}\nspeed: 2.0\n"
    return mission_from(parse(text, "m.yaml"), Level.MOTORS)


def test_local_takeoff_and_home() -> None:
    assert origin_in(Origin.LOCAL, STANDING) == (0.0, 0.0, 0.0)
    assert origin_in(Origin.TAKEOFF, STANDING) == STANDING.p_n
    assert origin_in(Origin.HOME, Whereabouts((0.0, 0.0, 0.0), home_n=(4.0, 5.0, 1.0))) == (4.0, 5.0, 1.0)


def test_home_as_a_place_on_the_earth_wins_over_its_old_coordinates() -> None:
    home = ZURICH.to_global((30.0, 40.0, 2.0))
    assert home_in(Whereabouts((0.0, 0.0, 0.0), frame=ZURICH, home=home)) == pytest.approx((30.0, 40.0, 2.0), abs=1e-6)
    near = Whereabouts((0.0, 0.0, 0.0), frame=ZURICH, home=home, home_n=(30.0, 41.0, 2.0))
    assert home_in(near) == pytest.approx((30.0, 40.0, 2.0), abs=1e-6)
    with pytest.raises(PlaceError, match="two ways that are 50 m apart"):
        home_in(Whereabouts((0.0, 0.0, 0.0), frame=ZURICH, home=home, home_n=(0.0, 0.0, 2.0)))


def test_a_place_on_the_earth_needs_the_vehicles_frame() -> None:
    origin = GlobalOrigin(*ZURICH.to_global((100.0, 200.0, -7.0)))
    where = Whereabouts((0.0, 0.0, 0.0), frame=ZURICH)
    assert origin_in(origin, where) == pytest.approx((100.0, 200.0, -7.0), abs=1e-6)
    with pytest.raises(PlaceError, match="GPS_GLOBAL_ORIGIN"):
        origin_in(origin, STANDING)


def test_an_altitude_above_home() -> None:
    home = ZURICH.to_global((30.0, 40.0, 2.0))
    latitude, longitude, _ = ZURICH.to_global((100.0, 200.0, 0.0))
    where = Whereabouts((0.0, 0.0, 0.0), frame=ZURICH, home=home)
    origin = GlobalOrigin(latitude, longitude, 15.0, above_home=True)
    assert origin_in(origin, where) == pytest.approx((100.0, 200.0, -13.0), abs=1e-6)  # 15 m above 2 m below


@pytest.mark.parametrize(
    ("origin", "where", "said"),
    [
        (Origin.TAKEOFF, Whereabouts((0.0, 0.0, -5.0), on_ground=False), "needs a vehicle on the ground"),
        (Origin.TAKEOFF, Whereabouts((0.0, 0.0, -5.0)), "needs a vehicle on the ground"),
        (Origin.HOME, STANDING, "home is not known"),
        (GlobalOrigin(48.5, 9.0, 300.0), Whereabouts((0.0, 0.0, 0.0), frame=ZURICH), "127 km from the vehicle"),
        (GlobalOrigin(47.4, 8.5, 9.0, True), Whereabouts((0.0, 0.0, 0.0), frame=ZURICH), "home is not known"),
    ],
)
def test_what_is_not_known_is_said(origin: Origin | GlobalOrigin, where: Whereabouts, said: str) -> None:
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
        moved = placed(mission, Origin.LOCAL, Whereabouts((0.0, 0.0, 0.0), frame=ZURICH))
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
