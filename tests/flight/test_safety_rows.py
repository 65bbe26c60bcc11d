"""The rows of what may not go on, one by one and without a flight; and the angle that the tilt error's row looks at."""

from __future__ import annotations

import math

import pytest

from companion.calculus.vectors import Vector
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.flight import conditions
from companion.flight.conduct import Limits
from companion.flight.safety import NOTHING_SINCE, ROWS, Action, SafetyInputs, update_breaches
from companion.law.feedback import Bounds
from companion.law.flight import Command, Flying, curve_law, implicit_law, model_of
from companion.law.gains import Level, default_gains
from companion.law.hold import hold_law
from companion.law.reference import reference_motion
from companion.law.speed_scale import SpeedScale
from companion.paths.implicit import ImplicitPath
from companion.paths.polyline import line
from companion.profiles import ConstantSpeed, ConstantYaw
from companion.vehicle import KnownStatus

LIMITS = Limits(tilt=math.radians(58.0))
CALM = SafetyInputs(KnownStatus(), following=True)


def after(seconds: float, inputs: SafetyInputs, limits: Limits = LIMITS) -> Action:
    since, _ = update_breaches(NOTHING_SINCE, inputs, limits, 0.0)
    return update_breaches(since, inputs, limits, seconds)[1].action


def test_a_tilt_error_that_lasts_ends_it() -> None:
    leans = CALM._replace(tilt_error=math.radians(41.0))
    assert after(0.39, leans) is Action.NONE
    assert after(0.41, leans) is Action.ABORT
    assert after(10.0, leans._replace(tilt_error=math.radians(39.0))) is Action.NONE


def test_a_tilt_error_of_a_vehicle_that_is_held_does_not() -> None:
    assert after(10.0, CALM._replace(tilt_error=1.0, still=True)) is Action.NONE


def test_a_tilt_error_stays_under_the_failure_detector_and_belongs_to_vehicles_with_limits() -> None:
    leans = CALM._replace(tilt_error=math.radians(30.0))
    assert after(1.0, leans) is Action.NONE
    assert after(1.0, leans, Limits(tilt=math.radians(28.0))) is Action.ABORT
    assert after(1.0, leans._replace(tilt_error=2.0), Limits(tilt=None)) is Action.NONE


@pytest.mark.parametrize(("key", "within"), [("same_place", 0.15), ("same_attitude", 0.2)])
def test_a_part_of_the_state_that_stands_still_is_a_stale_state(key: str, within: float) -> None:
    frozen = CALM._replace(**{key: True})
    assert after(within - 0.01, frozen) is Action.NONE
    assert after(within, frozen) is Action.ABORT


def test_an_attitude_that_is_told_too_late_is_the_links_fault() -> None:
    late = CALM._replace(late=0.07)
    assert after(10.0, late) is Action.NONE  # it may be the vehicle's clock that is slow
    assert after(10.0, CALM._replace(rate_error=2.0)) is Action.NONE
    swings = late._replace(rate_error=2.0)
    assert after(0.09, swings) is Action.NONE
    assert after(0.1, swings) is Action.ABORT
    reason = conditions.late(swings, Limits())
    assert reason is not None and reason.startswith("states come 0.07 s late")


def test_link_gaps_are_counted() -> None:
    assert after(0.0, CALM._replace(gaps=conditions.GAPS - 1)) is Action.NONE
    assert after(0.0, CALM._replace(gaps=conditions.GAPS)) is Action.HAND_BACK


def test_every_row_says_what_it_watches_and_what_to_do() -> None:
    assert len({row.words for row in ROWS}) == len(ROWS)
    assert all(row.advice and row.action is not Action.NONE for row in ROWS)


X500 = load_vehicle("x500")
BARE = model_of(X500)


def angle(command: Command) -> float:
    return math.degrees(math.acos(min(command.aligned, 1.0)))


@pytest.mark.parametrize(
    ("name", "level"), [("paper_case2", Level.MOTORS), ("circle_r5", Level.MOTORS), ("circle_r5", Level.RATES)]
)
def test_there_is_no_tilt_error_on_the_path_following_manifold(name: str, level: Level) -> None:
    """Leaning by 66 degrees and precessing, as the path wants it."""
    mission, vehicle = load_mission(name, level), load_vehicle("paper")
    assert isinstance(mission.path, ImplicitPath)
    specification, model = mission.specification(1.0), model_of(vehicle)
    law = implicit_law(specification, level, model, default_gains(level), None)
    x, y, z = mission.table.at(3.0)[0]
    ref = reference_motion(specification, model, Vector(x, y, z))
    rows = zip(*(axis.components() for axis in (ref.R.e1, ref.R.e2, ref.R.e3)), strict=True)
    r_nb = tuple(float(value) for row in rows for value in row)
    flying = Flying(ref.X.components(), ref.V.components(), r_nb, ref.zeta, ref.w.components(), ref.zeta_dot)
    assert angle(law(flying._replace(drag=model.c), SpeedScale())) < 1e-5


@pytest.mark.parametrize("level", list(Level))
def test_the_tilt_error_beside_a_path_is_the_lean_that_brings_the_vehicle_back(level: Level) -> None:
    """Level, at speed, far from its end, half a metre beside a straight line: k0/k2 times that is asked for, across it."""
    gains = default_gains(level)
    law = curve_law(
        line((0.0, 0.0, -10.0), (5000.0, 0.0, -10.0)), ConstantSpeed(3.0), ConstantYaw(0.0), level, BARE, gains, Bounds(),
        1.0,
    )  # fmt: skip
    flying = Flying((20.0, 0.5, -10.0), (3.0, 0.0, 0.0), (1, 0, 0, 0, 1, 0, 0, 0, 1), X500.weight, s=20.0)
    asked = gains.h1[0] / gains.h1[2] * 0.5
    assert angle(law(flying, SpeedScale())) == pytest.approx(math.degrees(math.atan(asked / X500.gravity)), abs=1e-6)
    assert angle(law(flying._replace(p_n=(20.0, 0.0, -10.0)), SpeedScale())) < 1e-6


@pytest.mark.parametrize("level", list(Level))
def test_the_tilt_error_beside_a_point(level: Level) -> None:
    law = hold_law(level, BARE, default_gains(level), Bounds())
    flying = Flying((10.0, 0.0, -10.0), (0.0, 0.0, 0.0), (1, 0, 0, 0, 1, 0, 0, 0, 1), X500.weight)
    assert angle(law(flying, (10.0, 0.0, -10.0), 0.0)) < 1e-6
    # far away no more than so much acceleration is asked for
    assert angle(law(flying, (0.0, 0.0, -10.0), 0.0)) == pytest.approx(math.degrees(math.atan(4.0 / X500.gravity)))


def test_thrust_that_does_not_answer_is_told_from_the_bottom_of_a_curve() -> None:
    weak = CALM._replace(thrust_share=0.97, sinking=1.0, specific_thrust_commanded=12.0, specific_thrust_made=10.0)
    limits = LIMITS._replace(tilt=1.0)
    assert after(0.29, weak, limits) is Action.NONE
    assert after(0.31, weak, limits) is Action.HAND_BACK
    for calm in (
        weak._replace(thrust_share=0.9), weak._replace(sinking=0.5), weak._replace(specific_thrust_made=11.0),
        weak._replace(specific_thrust_commanded=0.0, specific_thrust_made=0.0),
    ):  # fmt: skip
        assert after(10.0, calm, limits) is Action.NONE
    assert after(1.0, weak, limits._replace(tilt=None)) is Action.NONE


def test_a_link_that_becomes_slow_in_flight_hands_back() -> None:
    assert after(10.0, CALM._replace(round_trip=0.19)) is Action.NONE
    assert after(10.0, CALM) is Action.NONE
    slow = CALM._replace(round_trip=0.21)
    assert after(0.29, slow) is Action.NONE
    assert after(0.31, slow) is Action.HAND_BACK


def test_past_the_rate_loop_a_vehicle_that_turns_too_fast_is_given_back() -> None:
    turns = CALM._replace(body_rate=5.0, body_rate_max=4.6)
    assert after(0.04, turns) is Action.NONE
    assert after(0.06, turns) is Action.ABORT
    assert after(1.0, turns._replace(body_rate_max=None)) is Action.NONE
