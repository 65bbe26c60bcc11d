"""The law that holds a point: still when there, linear near it, bounded far from it."""

from __future__ import annotations

import math
from typing import NamedTuple

import pytest

from companion.calculus.vectors import Vector
from companion.frames import (
    Vec3,
    from_rotation_vector,
    multiply,
    quaternion_from_euler,
    rotation_matrix,
    tilt,
)
from companion.law.errors import LawError
from companion.law.feedback import YAW_RETURN_RATE, Bounds
from companion.law.flight import Flying, curve_law
from companion.law.gains import Level, default_gains
from companion.law.hold import HoldLaw, hold_law
from companion.law.motion import Model
from companion.law.speed_scale import SpeedScale
from companion.paths.round import circle
from companion.profiles import ConstantSpeed, TangentYaw
from companion.vehicle import VehicleState

MODEL = Model(1.5, Vector(0.02, 0.02, 0.04), 9.81, 0.0)
PLACE, YAW = (3.0, -2.0, -10.0), 0.4
LEVELS = list(Level)


def law_at(level: Level, bounds: Bounds | None = None) -> HoldLaw:
    return hold_law(level, MODEL, default_gains(level), bounds)


def hovering(p_n: Vec3 = PLACE, v_n: Vec3 = (0.0, 0.0, 0.0), yaw: float = YAW) -> Flying:
    return Flying(p_n, v_n, rotation_matrix(quaternion_from_euler(yaw, 0.0, 0.0)), 1.5 * 9.81)


@pytest.mark.parametrize("level", LEVELS)
def test_there_and_still_nothing_is_asked(level: Level) -> None:
    command = law_at(level, Bounds())(hovering(), PLACE, YAW)
    assert command.zeta_derivative == pytest.approx(0.0, abs=1e-9)
    assert command.turn == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("level", LEVELS)
def test_signs(level: Level) -> None:
    def turn_and_lift(**changes: object) -> tuple[Vec3, float]:
        flying = hovering(yaw=0.0)._replace(**changes)  # type: ignore[arg-type]
        command = law_at(level, Bounds())(flying, PLACE, 0.0)
        return command.turn, command.zeta_derivative

    x, y, z = PLACE
    assert turn_and_lift(p_n=(x - 1.0, y, z))[0][1] < 0.0  # too far south: nose down
    assert turn_and_lift(p_n=(x, y - 1.0, z))[0][0] > 0.0  # too far west: roll right
    assert turn_and_lift(p_n=(x, y, z + 1.0))[1] > 0.0  # too low: more thrust
    assert turn_and_lift(v_n=(1.0, 0.0, 0.0))[0][1] > 0.0  # flying north: nose up
    turned = rotation_matrix(quaternion_from_euler(0.2, 0.0, 0.0))
    assert turn_and_lift(r_nb=turned)[0][2] < 0.0  # nose too far right: left


@pytest.mark.parametrize("level", LEVELS)
def test_bounds_change_nothing_near_the_point(level: Level) -> None:
    flying = hovering((3.2, -2.1, -10.1), (0.1, -0.2, 0.1))
    bounded, linear = law_at(level, Bounds())(flying, PLACE, YAW), law_at(level)(flying, PLACE, YAW)
    assert bounded.turn == pytest.approx(linear.turn)
    assert bounded.zeta_derivative == pytest.approx(linear.zeta_derivative)


@pytest.mark.parametrize("error", [-3.0, -0.8, 0.8, 3.0])
def test_a_heading_error_is_turned_out_slowly(error: float) -> None:
    command = law_at(Level.RATES, Bounds(yaw_rate=3.5))(hovering(yaw=YAW + error), PLACE, YAW)
    assert command.turn[2] == pytest.approx(-math.copysign(YAW_RETURN_RATE, error))


@pytest.mark.parametrize(("most", "flown"), [(3.5, 2.5), (1.2, 1.2)])
def test_a_path_turns_the_nose_as_quickly_as_the_vehicle_may(most: float, flown: float) -> None:
    """Along a bend of 2 m at 5 m/s, upright: 2.5 rad/s."""
    gains, bounds = default_gains(Level.RATES), Bounds(yaw_rate=most)
    bend = circle((0.0, 0.0, -10.0), 2.0, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    law = curve_law(bend, ConstantSpeed(5.0), TangentYaw(), Level.RATES, MODEL, gains, bounds, 1.0)
    x, y, z = law.curve.table.at(0.0)[0]
    tangent = law.curve.table.at(0.0)[1]
    heading = math.atan2(tangent[1], tangent[0])
    flying = hovering((x, y, z), (5.0 * tangent[0], 5.0 * tangent[1], 0.0), heading)
    assert abs(law(flying, SpeedScale()).turn[2]) == pytest.approx(flown, rel=1e-3)


def extrapolate(state: VehicleState, a_n: Vec3, w_dot_b: Vec3, h: float) -> VehicleState:
    """``state`` after ``h`` s of acceleration (m/s^2, world) and body acceleration (rad/s^2), to second order in h."""
    (x, y, z), (vx, vy, vz), (p, q, r) = state.p_n, state.v_n, state.w_b
    ax, ay, az = a_n
    p_dot, q_dot, r_dot = w_dot_b
    half = 0.5 * h
    turned = from_rotation_vector(
        (h * (p + half * p_dot), h * (q + half * q_dot), h * (r + half * r_dot)),
    )
    return VehicleState(
        state.t_boot + h,
        (x + h * (vx + half * ax), y + h * (vy + half * ay), z + h * (vz + half * az)),
        (vx + h * ax, vy + h * ay, vz + h * az),
        multiply(state.q_nb, turned),
        (p + h * p_dot, q + h * q_dot, r + h * r_dot),
        state.resets,
    )


class Flown(NamedTuple):
    end: VehicleState
    speed_max: float
    tilt_max: float


def flown(level: Level, p_n: Vec3, v_n: Vec3, seconds: float = 25.0, h: float = 0.005) -> Flown:
    """The ideal machine under the law, evaluated half a step ahead."""
    law = law_at(level, Bounds())
    state = VehicleState(0.0, p_n, v_n, quaternion_from_euler(YAW, 0.0, 0.0), (0.0, 0.0, 0.0))
    zeta, zeta_dot = 1.5 * 9.81, 0.0
    speed_max = tilt_max = 0.0
    for _ in range(round(seconds / h)):
        flying = Flying(state.p_n, state.v_n, state.r_nb, zeta, state.w_b, zeta_dot)
        command = law(flying, PLACE, YAW)
        r, specific_thrust = state.r_nb, zeta / 1.5
        a_n = (-specific_thrust * r[2], -specific_thrust * r[5], 9.81 - specific_thrust * r[8])
        if level is Level.RATES:
            zeta += h * command.zeta_derivative
            state = extrapolate(state._replace(w_b=command.turn), a_n, (0.0, 0.0, 0.0), h)
        else:
            zeta, zeta_dot = zeta + h * zeta_dot, zeta_dot + h * command.zeta_derivative
            p, q, w = state.w_b
            l, m, n = command.turn  # noqa: E741
            w_dot = ((l - 0.02 * q * w) / 0.02, (m + 0.02 * p * w) / 0.02, n / 0.04)
            state = extrapolate(state, a_n, w_dot, h)
        zeta = max(zeta, 0.2 * 1.5 * 9.81)
        speed_max, tilt_max = max(speed_max, math.hypot(*state.v_n)), max(tilt_max, tilt(state.r_nb))
    return Flown(state, speed_max, tilt_max)


@pytest.mark.parametrize("level", LEVELS)
def test_a_far_point_is_approached_at_a_bounded_speed(level: Level) -> None:
    done = flown(level, (18.0, -9.0, -4.0), (0.0, 0.0, 0.0))
    assert math.dist(done.end.p_n, PLACE) < 0.02
    assert done.speed_max < 2.8
    assert done.tilt_max < math.radians(35.0)


@pytest.mark.parametrize("level", LEVELS)
def test_a_vehicle_that_arrives_fast_brakes_within_its_means(level: Level) -> None:
    done = flown(level, PLACE, (7.0, 0.0, 0.0))
    assert math.dist(done.end.p_n, PLACE) < 0.02
    assert done.tilt_max < math.radians(35.0)


def test_without_thrust_or_sense_it_says_so() -> None:
    law = law_at(Level.RATES, Bounds())
    with pytest.raises(LawError, match="thrust"):
        law(hovering()._replace(zeta=0.0), PLACE, YAW)
    with pytest.raises(LawError, match="finite"):
        law(hovering((math.nan, 0.0, 0.0)), PLACE, YAW)
