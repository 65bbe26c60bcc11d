"""The yaw rates that the path will ask for, held to the flatness of the law that flies it."""

from __future__ import annotations

import math

import pytest

from companion.calculus.vectors import Vector
from companion.frames import Heading
from companion.law.motion import Model
from companion.law.reference import reference_over_arc
from companion.mission import Mission
from companion.paths.curve import Curve
from companion.steering.speed_governor import Capability, Course, Place, course_of
from companion.steering.yaw_forecast import FORECAST_LENGTH, FORECAST_STEP, forecast_yaw_rates, rate_at
from trials.measured import course as mission_of

GRAVITY, DRAG = 9.81, 0.6
CAPABILITY = Capability(20.0, math.inf, DRAG, (0.0, 0.0, 0.0), GRAVITY)


def along(mission: Mission, direction: float = 1.0) -> Course:
    return course_of(mission.table, mission.alpha, mission.closed, direction, mission.beta)


def exact(mission: Mission, s: float, speed: float, heading: Heading) -> float:
    """rad/s, by the law's own flatness."""
    assert isinstance(mission.path, Curve)
    h, table = 1e-2, mission.table
    point, tangent, curvature = (Vector(*each) for each in table.at(s))
    third = (Vector(*table.at(s + h)[2]) - Vector(*table.at(s - h)[2])) / (2.0 * h)
    model = Model(1.0, Vector(0.02, 0.02, 0.03), GRAVITY, DRAG)
    there = reference_over_arc(
        [point, tangent, curvature, third, Vector(0.0, 0.0, 0.0)],
        (speed, 0.0, 0.0, 0.0),
        (0.3, 0.0, 0.0),
        model,
        heading,
    )
    return float(there.w.z)


@pytest.mark.parametrize("heading", list(Heading))
def test_it_is_the_laws_where_the_nose_stays(heading: Heading) -> None:
    mission, speed = mission_of("figure8", 3.0), 3.0
    course = course_of(mission.table, mission.alpha, True, 1.0, lambda s: 0.3)
    table = mission.table
    worst = largest = 0.0
    for k in range(40):
        s = table.length * k / 40
        forecast = forecast_yaw_rates(course, s, 1.0, CAPABILITY, heading)
        for i, rate in enumerate(forecast):
            there = exact(mission, (s + i * speed * FORECAST_STEP) % table.length, speed, heading)
            worst, largest = max(worst, abs(rate - there)), max(largest, abs(there))
    assert largest > 0.15
    assert worst < 0.15 * largest  # differences over 0.1 s


def test_level_flight_straight_on_asks_for_none_and_a_nose_that_turns_for_its_own_rate() -> None:
    ahead = Place((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 2.0)
    still = Capability(20.0, math.inf, 0.0, (0.0, 0.0, 0.0), GRAVITY)
    straight = Course((ahead,) * 20, 0.5, False, 1.0)
    assert forecast_yaw_rates(straight, 1.0, 1.0, still, Heading.PROJECTED) == (0.0,) * FORECAST_LENGTH
    turning = Course(tuple(ahead._replace(heading=0.1 * k) for k in range(20)), 0.5, False, 1.0)
    for heading in Heading:
        rates = forecast_yaw_rates(turning, 2.0, 1.0, still, heading)
        assert rates == pytest.approx((0.4,) * FORECAST_LENGTH)
        assert forecast_yaw_rates(turning, 6.0, -0.5, still, heading) == pytest.approx((-0.2,) * FORECAST_LENGTH)


def test_a_nose_that_goes_round_does_not_jump_where_the_path_closes() -> None:
    mission = mission_of("circle_r5", 3.0)
    level = CAPABILITY._replace(drag=0.0)
    tangent = course_of(mission.table, mission.alpha, True, 1.0, lambda s: math.remainder(s / 5.0, math.tau))
    for k in range(20):
        s = mission.table.length * k / 20
        rates = forecast_yaw_rates(tangent, s, 1.0, level, Heading.PROJECTED)
        assert max(rates) - min(rates) < 0.05
        assert 0.4 < rates[0] < 0.6


def test_the_wind_that_leans_the_vehicle_is_in_it() -> None:
    """A turning nose under a lean that stays in the world: psi' cos(theta) cos(phi) - theta' sin(phi)."""
    ahead = tuple(Place((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 2.0, heading=0.1 * k) for k in range(60))
    leaning = Capability(20.0, math.inf, 0.0, (0.0, 4.0, 0.0), GRAVITY)
    first = forecast_yaw_rates(Course(ahead, 0.5, False, 1.0), 0.2, 1.0, leaning, Heading.PROJECTED)[0]
    lean = math.atan2(4.0, GRAVITY)  # to the right, of a nose to the north that turns to it
    assert first == pytest.approx(0.4 * (math.cos(lean) + math.sin(lean) * math.tan(lean)), rel=0.02)


def test_between_its_moments_it_is_a_line_and_goes_on_beyond() -> None:
    forecast = (0.0, 1.0, 3.0, 3.0, 4.0)
    assert rate_at(forecast, 0.05) == pytest.approx(0.5)
    assert rate_at(forecast, 0.12) == pytest.approx(1.4)
    assert rate_at(forecast, 0.5) == pytest.approx(5.0)


def test_an_open_path_ends_and_a_closed_one_goes_on() -> None:
    places = tuple(Place((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 2.0) for _ in range(4))
    course = Course(places, 0.5, False, 1.0)
    assert course.between(-1.2)[:2] == (0, 0)
    assert course.between(9.0)[:2] == (3, 3)
    assert course.between(0.75) == (1, 2, 0.5)
    closed = Course(places, 0.5, True, 1.0)
    assert closed.between(1.75) == (3, 0, 0.5)
    assert closed.between(-0.25) == (3, 0, 0.5)


def test_a_speed_that_rises_leans_the_vehicle() -> None:
    """East along a straight line, the nose to the north: the lean is a roll, out of which it turns."""
    still = Capability(20.0, math.inf, 0.0, (0.0, 0.0, 0.0), GRAVITY)
    places = tuple(Place((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 2.0 + 0.5 * k, heading=0.01 * k) for k in range(40))
    course = Course(places, 0.5, False, 1.0)
    assert forecast_yaw_rates(course, 2.0, 1.0, still, Heading.TWIST) == pytest.approx((0.08,) * FORECAST_LENGTH)
    lean = math.atan2(4.0 * 1.0, GRAVITY)  # 4 m/s, by 1 m/s more each metre
    projected = forecast_yaw_rates(course, 2.0, 1.0, still, Heading.PROJECTED)[0]
    assert projected == pytest.approx(0.08 / math.cos(lean), rel=0.1)
