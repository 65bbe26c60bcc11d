"""Gains of its own for the vertical part of the distance to the path."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from companion.calculus.expression import parse
from companion.calculus.scalar import cos, sin
from companion.calculus.vectors import Vector
from companion.frames import rotation_from_euler
from companion.law.feedback import HEIGHT_ACCELERATION, Bounds
from companion.law.flight import Flying, Law, curve_law, implicit_law
from companion.law.gains import Gains, Level, from_poles
from companion.law.implicit import Specification
from companion.law.motion import Model
from companion.law.speed_scale import SpeedScale
from companion.paths.curve import analytic
from companion.profiles import ConstantSpeed, ConstantYaw

MODEL = Model(1.5, Vector(0.02, 0.02, 0.03), 9.81, 0.0)
LEVEL, OWN = from_poles((-6.0,) * 3), from_poles((-9.0,) * 3)
SNAP_LEVEL, SNAP_OWN = from_poles((-6.0, -6.0, -6.0, -14.0)), from_poles((-9.0, -9.0, -9.0, -20.0))
"""The same at motors."""
RADIUS, SPEED = 7.0, 3.0


def circle(
    vertical: tuple[float, ...] | None, bounds: Bounds | None = None, level: Level = Level.RATES
) -> tuple[Law, Law]:
    """The same level circle by h1 and h2, and as a curve."""
    gains = Gains(LEVEL, LEVEL, from_poles((-2.5, -2.5)), (2.0,), vertical)
    if level is Level.MOTORS:
        gains = Gains(SNAP_LEVEL, SNAP_LEVEL, from_poles((-2.5, -2.5, -14.0)), (4.0, 4.0), vertical)
    h1, h2 = parse("hypot(x, y) - 7", ("x", "y")), parse("z + 4", ("z",))
    spec = Specification(
        lambda p: (h1({"x": p[0], "y": p[1]}), h2({"z": p[2]})), lambda p, mu: SPEED, lambda p, mu: 0.0
    )
    curve = analytic(lambda u: (RADIUS * cos(u), -RADIUS * sin(u), -4.0), 0.0, math.tau, True)
    return (
        implicit_law(spec, level, MODEL, gains, bounds),
        curve_law(curve, ConstantSpeed(SPEED), ConstantYaw(0.0), level, MODEL, gains, bounds, 1.0),
    )


def jerk(law: Law, flying: Flying) -> np.ndarray:
    """m/s^3: what the command makes of the motion, (zeta b)' = -m J."""
    command = law(flying, SpeedScale(1.0, 0.0, 0.0))
    R = np.array(flying.r_nb).reshape(3, 3)
    p, q, _ = command.turn
    turned = flying.zeta * np.array([q, -p, 0.0]) + np.array([0.0, 0.0, command.zeta_derivative])
    return np.asarray(-R @ turned / MODEL.m)


def snap(law: Law, flying: Flying) -> np.ndarray:
    """m/s^4: what the command of the level of motors makes of the motion, (zeta b)'' = -m S."""
    command = law(flying, SpeedScale(1.0, 0.0, 0.0))
    R, w, J = np.array(flying.r_nb).reshape(3, 3), np.array(flying.w_b), np.array([MODEL.J.x, MODEL.J.y, MODEL.J.z])
    w_dot = (np.array(command.turn) - np.cross(w, J * w)) / J
    e3, zeta, zeta_dot = np.array([0.0, 0.0, 1.0]), flying.zeta, flying.zeta_dot
    turned = np.cross(w_dot, e3) + np.cross(w, np.cross(w, e3))
    body = command.zeta_derivative * e3 + 2.0 * zeta_dot * np.cross(w, e3) + zeta * turned
    return np.asarray(-R @ body / MODEL.m)


def somewhere(rng: random.Random, spread: float = 0.3) -> Flying:
    u = rng.uniform(0.0, math.tau)
    x, y, z = RADIUS * math.cos(u), -RADIUS * math.sin(u), -4.0
    return Flying(
        (x + rng.gauss(0, spread), y + rng.gauss(0, spread), z + rng.gauss(0, spread)),
        (rng.gauss(0, 2), rng.gauss(0, 2), rng.gauss(0, 1)),
        rotation_from_euler(rng.uniform(-3, 3), rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6)),
        rng.uniform(10, 20),
        (rng.gauss(0, 0.5), rng.gauss(0, 0.5), rng.gauss(0, 0.5)),
        rng.gauss(0, 5),
        s=RADIUS * u,
    )


@pytest.mark.parametrize("kind", [0, 1], ids=["implicit", "curve"])
def test_on_a_level_path_height_has_its_own_linear_dynamics_and_the_rest_is_untouched(kind: int) -> None:
    own, usual = circle(OWN)[kind], circle(None)[kind]
    rng = random.Random(4)
    for _ in range(20):
        flying = somewhere(rng)
        a, b = jerk(own, flying), jerk(usual, flying)
        acceleration = MODEL.g - flying.zeta / MODEL.m * flying.r_nb[8]
        errors = (flying.p_n[2] + 4.0, flying.v_n[2], acceleration)
        assert a[2] == pytest.approx(-sum(k * e for k, e in zip(OWN, errors, strict=True)))
        assert a[:2] == pytest.approx(b[:2])


@pytest.mark.parametrize("kind", [0, 1], ids=["implicit", "curve"])
def test_at_motors_the_height_has_its_own_linear_dynamics_of_fourth_order(kind: int) -> None:
    own, usual = (circle(gains, level=Level.MOTORS)[kind] for gains in (SNAP_OWN, None))
    rng = random.Random(7)
    for _ in range(20):
        flying = somewhere(rng)
        a, b = snap(own, flying), snap(usual, flying)
        R = np.array(flying.r_nb).reshape(3, 3)
        down = flying.zeta_dot * R[:, 2] + flying.zeta * R @ np.cross(flying.w_b, [0.0, 0.0, 1.0])
        errors = (
            flying.p_n[2] + 4.0, flying.v_n[2], MODEL.g - flying.zeta / MODEL.m * flying.r_nb[8], -down[2] / MODEL.m,
        )  # fmt: skip
        assert a[2] == pytest.approx(-sum(k * e for k, e in zip(SNAP_OWN, errors, strict=True)))
        assert a[:2] == pytest.approx(b[:2])


def test_the_gains_of_h1_twice_are_the_law_without_them() -> None:
    rng = random.Random(5)
    for _ in range(20):
        flying = somewhere(rng)
        for same, usual in zip(circle(LEVEL), circle(None), strict=True):
            assert jerk(same, flying) == pytest.approx(jerk(usual, flying))
        both = (circle(gains, level=Level.MOTORS) for gains in (SNAP_LEVEL, None))
        for same, usual in zip(*both, strict=True):
            assert snap(same, flying) == pytest.approx(snap(usual, flying))


def test_both_ways_of_writing_a_circle_are_one() -> None:
    rng = random.Random(6)
    for bounds in (None, Bounds()):
        a, b = circle(OWN, bounds)
        for _ in range(20):
            flying = somewhere(rng, 1.0)
            assert jerk(a, flying) == pytest.approx(jerk(b, flying))


@pytest.mark.parametrize("height", [0.5, 3.0, 30.0, -30.0])
def test_the_thrust_does_not_go_however_high_it_is(height: float) -> None:
    """Flown in sih_noisy half a meter above the path, without it: the thrust went, the vehicle tilted by 80 deg."""
    for law in circle(OWN, Bounds()):
        s = 0.25 * math.tau * RADIUS
        flying = Flying((0.0, -RADIUS, -4.0 - height), (0.0, 0.0, 0.0), rotation_from_euler(0.0, 0.0, 0.0), 14.715, s=s)
        most = OWN[2] * HEIGHT_ACCELERATION
        assert jerk(law, flying)[2] == pytest.approx(math.copysign(most, height), rel=0.03)
