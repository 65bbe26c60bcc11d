"""The speed gives way where the vehicle could not fly the path, in time, and comes back."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import pytest

from companion.config.mission.mission import load_mission
from companion.law.gains import Level
from companion.law.speed_scale import UNITY, SpeedScale
from companion.steering.assembly import tan_tilt_max
from companion.steering.speed_governor import (
    BRAKING_MAX,
    SPEED_SCALE_MIN,
    Capability,
    Course,
    Place,
    course_of,
    govern_speed,
)
from companion.steering.tilt_barrier import STEADY_UNDER_DETECTOR
from trials.measured import machine

G = 9.80665
CALM = Capability(specific_thrust=15.0, tan_tilt_max=math.tan(1.2), drag=0.0, disturbance_n=(0.0, 0.0, 0.0), gravity=G)


def bend(speed: float = 6.0, closed: bool = False, direction: float = 1.0) -> Course:
    """40 m of straight path with a bend of 3 m radius between 20 and 22 m."""
    places = [
        Place((1.0, 0.0, 0.0), (0.0, 1.0 / 3.0, 0.0) if 20.0 <= 0.5 * i <= 22.0 else (0.0, 0.0, 0.0), speed)
        for i in range(81)
    ]
    return Course(tuple(places), 0.5, closed, direction)


def fly(
    course: Course, s: float, seconds: float, capability: Capability = CALM, asked: SpeedScale = UNITY
) -> list[tuple[float, float]]:
    """(arc length, speed) of a vehicle that flies exactly at the governed speed."""
    governor, flown, dt = UNITY, [], 0.01
    for _ in range(round(seconds / dt)):
        governor = govern_speed(governor, course, s, asked, capability, dt)
        speed = course.speed(s) * asked.value * governor.value
        s += course.direction * speed * dt
        flown.append((s, speed))
    return flown


def test_nothing_in_the_way_nothing_changes() -> None:
    assert bend().allowed_speed(0.0, 1.0, CALM._replace(specific_thrust=50.0, tan_tilt_max=50.0)) == math.inf
    assert (
        govern_speed(UNITY, bend(), 5.0, UNITY, CALM._replace(specific_thrust=50.0, tan_tilt_max=50.0), 0.01) == UNITY
    )


def test_a_bend_is_met_at_the_speed_it_can_be_flown_at() -> None:
    fastest = math.sqrt(3.0 * math.sqrt(15.0**2 - G * G))
    flown = fly(bend(), 0.0, 12.0)
    inside = [speed for s, speed in flown if 20.0 <= s <= 22.0]
    assert max(inside) <= fastest * 1.03
    assert min(inside) > 0.8 * fastest
    assert max(speed for s, speed in flown if s < 10.0) == pytest.approx(6.0)
    assert flown[-1][1] == pytest.approx(6.0)  # and it comes back
    changes = [abs(b - a) / 0.01 for (_, a), (_, b) in pairwise(flown)]
    assert max(changes) <= BRAKING_MAX * 1.05


def test_against_the_path_it_looks_the_other_way() -> None:
    flown = fly(bend(direction=-1.0), 40.0, 12.0)
    fastest = math.sqrt(3.0 * math.sqrt(15.0**2 - G * G))
    assert max(speed for s, speed in flown if 20.0 <= s <= 22.0) <= fastest * 1.03
    assert flown[-1][0] < 5.0


def test_a_steep_lean_slows_as_a_weak_thrust_does() -> None:
    leaning = CALM._replace(specific_thrust=50.0, tan_tilt_max=math.tan(math.radians(30.0)))
    inside = [speed for s, speed in fly(bend(), 0.0, 12.0, leaning) if 20.0 <= s <= 22.0]
    assert max(inside) <= 1.03 * math.sqrt(3.0 * G * math.tan(math.radians(30.0)))


def test_a_short_peak_may_take_what_a_long_bend_may_not() -> None:
    long = bend()
    short = dataclasses.replace(long, places=tuple(place._replace(sustained_ratio=0.8) for place in long.places))
    barely = CALM._replace(specific_thrust=math.hypot(6.0**2 / 3.0, G) * 1.01)
    assert short.allowed_speed(18.0, 1.0, barely) == math.inf
    assert long.allowed_speed(18.0, 1.0, barely) < math.inf
    assert short.allowed_speed(18.0, 1.0, barely._replace(specific_thrust=0.98 * barely.specific_thrust)) < math.inf


def test_wind_counts() -> None:
    against = CALM._replace(disturbance_n=(0.0, -6.0, 0.0))  # pushed out of the bend, which turns east
    assert bend().allowed_speed(20.5, 1.0, against) < bend().allowed_speed(20.5, 1.0, CALM)


def test_what_cannot_be_flown_at_all_is_flown_slowly() -> None:
    hopeless = CALM._replace(specific_thrust=5.0)
    flown = fly(bend(), 0.0, 10.0, hopeless)
    assert flown[-1][1] == pytest.approx(SPEED_SCALE_MIN * 6.0, rel=0.1)


def test_the_course_is_the_missions() -> None:
    mission = load_mission("circle_r5", Level.RATES)
    course = course_of(mission.table, mission.alpha, True, 1.0)
    assert len(course.places) * course.spacing == pytest.approx(mission.table.length)
    for place in course.places:
        assert math.hypot(*place.curvature) == pytest.approx(0.2, abs=1e-3)
        assert place.speed == pytest.approx(3.0)
        assert place.sustained_ratio == pytest.approx(1.0)


def test_a_figure_eights_sharpest_places_do_not_last() -> None:
    mission = load_mission("figure8", Level.RATES)
    places = course_of(mission.table, lambda s: 4.0, True, 1.0).places
    sharpest = max(places, key=lambda place: math.hypot(*place.curvature))
    assert 0.5 < sharpest.sustained_ratio < 0.9
    assert all(place.sustained_ratio <= 1.0 for place in places)


def test_the_steady_tilt_stays_eight_degrees_under_the_failure_detector() -> None:
    """A file may allow 60 deg, which PX4's failure detector does not: errors and gusts need what lies between."""
    limits = machine("sih").limits
    assert limits is not None
    steep = dataclasses.replace(limits, tilt=math.radians(60.0))
    assert math.degrees(math.atan(tan_tilt_max(machine("sih", limits=steep), STEADY_UNDER_DETECTOR))) == pytest.approx(
        52.0
    )
    assert math.degrees(math.atan(tan_tilt_max(machine("x500"), STEADY_UNDER_DETECTOR))) == pytest.approx(47.0)
