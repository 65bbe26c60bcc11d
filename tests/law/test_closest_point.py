"""The closest-point law: equal to the implicit law where both apply, and to an oracle where only it does."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from companion.calculus.expression import parse
from companion.calculus.scalar import cos, sin
from companion.calculus.vectors import Vector
from companion.frames import Heading, rotation_from_euler
from companion.law.flight import Flying, Law, OverArc, curve_law, implicit_law
from companion.law.gains import Gains, Level, from_poles
from companion.law.implicit import Specification
from companion.law.motion import Model
from companion.law.speed_scale import SpeedScale
from companion.paths.curve import Curve, analytic
from companion.profiles import (
    ConstantSpeed,
    ConstantYaw,
    LookAt,
    SpeedExpression,
    TangentYaw,
    Yaw,
    YawExpression,
    speed_table,
    yaw_table,
)

MODEL = Model(1.7, Vector(0.021, 0.026, 0.039), 9.81, 0.3)
GAINS = {level: Gains(*(from_poles([-2.0 - 0.3 * i for i in range(n)]) for n in level.degrees)) for level in Level}


def random_flying(rng: random.Random, near: tuple[float, float, float], s: float, spread: float) -> Flying:
    x, y, z = (c + rng.gauss(0.0, spread) for c in near)
    return Flying(
        p_n=(x, y, z),
        v_n=(rng.gauss(0, 3), rng.gauss(0, 3), rng.gauss(0, 2)),
        r_nb=rotation_from_euler(rng.uniform(-3, 3), rng.uniform(-1, 1), rng.uniform(-1, 1)),
        zeta=rng.uniform(8, 30),
        w_b=(rng.gauss(0, 1), rng.gauss(0, 1), rng.gauss(0, 1)),
        zeta_dot=rng.gauss(0, 8),
        disturbance=(rng.gauss(0, 0.5), rng.gauss(0, 0.5), rng.gauss(0, 0.5)),
        drag=0.3,
        s=s,
    )


def difference(a: Law, b: Law, flying: Flying, ramp: SpeedScale) -> float:
    one, two = a(flying, ramp), b(flying, ramp)
    first, second = ([c.zeta_derivative, *c.turn, c.speed, c.alpha, *c.tangent] for c in (one, two))
    return float(np.max(np.abs(np.array(first) - np.array(second))) / np.max(np.abs(first)))


def implicit(h1: str, h2: str, alpha: str, beta: Callable[[Any, Any], Any]) -> Specification:
    f1, f2, fa = (parse(text, ("x", "y", "z")) for text in (h1, h2, alpha))

    def names(p: Any) -> dict[str, Any]:
        return dict(zip(("x", "y", "z"), p, strict=True))

    return Specification(lambda p: (f1(names(p)), f2(names(p))), lambda p, mu: fa(names(p)), beta)


@pytest.mark.parametrize("kind", list(Heading), ids=lambda kind: kind.value)
@pytest.mark.parametrize("level", list(Level), ids=lambda level: level.name)
@pytest.mark.parametrize(
    ("name", "yaw", "beta"),
    [
        ("number", ConstantYaw(0.4), lambda p, mu: 0.4),
        ("tangent", TangentYaw(0.2), lambda p, mu: TangentYaw(0.2).value({}, p, mu)),
    ],
)
def test_a_circle_as_a_distance(level: Level, name: str, yaw: Yaw, beta: Any, kind: Heading) -> None:
    """h1 = hypot(x, y) - r, h2 = z - z0 are distances: the implicit law is the closest-point law."""
    spec = replace(implicit("hypot(x, y) - 7", "z + 4", "3", beta), heading=kind)
    # mu of the implicit circle runs counter-clockwise seen from above, as this curve does
    curve = analytic(lambda u: (7.0 * cos(u), -7.0 * sin(u), -4.0), 0.0, math.tau, True)
    a = implicit_law(spec, level, MODEL, GAINS[level], None)
    b = curve_law(curve, ConstantSpeed(3.0), yaw, level, MODEL, GAINS[level], None, 1.0, kind)
    rng = random.Random(name)
    for _ in range(60):
        s = rng.uniform(0.0, curve.table.length)
        flying = random_flying(rng, curve.table.at(s)[0], s, 1.2)
        assert difference(a, b, flying, SpeedScale(0.7, 0.2, -0.1)) < 1e-9


@pytest.mark.parametrize("level", list(Level), ids=lambda level: level.name)
def test_a_speed_profile_on_a_circle(level: Level) -> None:
    """alpha as a function of the angle is alpha as a function of arc length over r."""
    spec = implicit("hypot(x, y) - 7", "z + 4", "3 + sin(atan2(y, x))", lambda p, mu: 0.3)
    curve = analytic(lambda u: (7.0 * cos(u), -7.0 * sin(u), -4.0), 0.0, math.tau, True)
    speed = SpeedExpression(parse("3 - sin(s/r)", ("s", "r")), {"r": 7.0})
    a = implicit_law(spec, level, MODEL, GAINS[level], None)
    b = curve_law(curve, speed, ConstantYaw(0.3), level, MODEL, GAINS[level], None, 1.0)
    rng = random.Random(3)
    for _ in range(60):
        s = rng.uniform(0.0, curve.table.length)
        assert difference(a, b, random_flying(rng, curve.table.at(s)[0], s, 1.0), SpeedScale()) < 1e-8


@pytest.mark.parametrize("level", list(Level), ids=lambda level: level.name)
def test_a_helix_on_a_cylinder_and_the_yaw_towards_a_point(level: Level) -> None:
    """A vertical line and a level line through it: straight, where distances are coordinates."""
    spec = implicit(
        "y - 2", "z + 3", "2", lambda p, mu: LookAt((30.0, 20.0, 0.0)).value({}, (p[0], 2.0 + 0.0 * p[0], p[2]), mu)
    )
    # its ends are so far that the stop before them is nowhere near
    line = analytic(lambda u: (u, 2.0 + 0.0 * u, -3.0 + 0.0 * u), -500.0, 500.0, False)
    a = implicit_law(spec, level, MODEL, GAINS[level], None)
    b = curve_law(line, ConstantSpeed(2.0), LookAt((30.0, 20.0, 0.0)), level, MODEL, GAINS[level], None, 1.0)
    rng = random.Random(5)
    for _ in range(40):
        flying = random_flying(rng, (rng.uniform(-10, 10), 2.0, -3.0), 20.0, 0.5)
        assert difference(a, b, flying, SpeedScale()) < 1e-9


def lissajous(u: Any) -> tuple[Any, Any, Any]:
    return (6.0 * cos(u), 3.0 * sin(2.0 * u), -10.0 + 1.5 * sin(u))


class BishopOracle:
    """The outputs measured in a parallel-transport frame carried along the curve, differentiated symbolically.

    States beside the vehicle's: the curve's parameter and two normals N1, N2 that turn with the curve only as they must.
    h1 = N1 . (X - gamma), h2 = N2 . (X - gamma), h3 = T . V - alpha(s): an independent statement of what is linearised.
    """

    def __init__(self, level: Level, alpha: Callable[[Any], Any], drag: float) -> None:
        u, s = ca.SX.sym("u"), ca.SX.sym("s")
        gamma = ca.vertcat(6 * ca.cos(u), 3 * ca.sin(2 * u), -10 + 1.5 * ca.sin(u))
        g1 = ca.jacobian(gamma, u)
        g2 = ca.jacobian(g1, u)
        n = ca.norm_2(g1)
        T = g1 / n
        X, V, A, J = (ca.SX.sym(name, 3) for name in "XVAJ")
        N1, N2 = ca.SX.sym("N1", 3), ca.SX.sym("N2", 3)
        e = X - gamma
        u_dot = ca.dot(g1, V) / (ca.dot(g1, g1) - ca.dot(g2, e))
        T_dot = ca.jacobian(T, u) * u_dot
        unknown = ca.SX.sym("S", 3)  # the highest derivative of the position
        chain = [V, A, J, unknown] if level is Level.MOTORS else [V, A, unknown]
        state = ca.vertcat(u, s, N1, N2, X, V, A, *([J] if level is Level.MOTORS else []))
        rate = ca.vertcat(
            u_dot,
            n * u_dot,
            -ca.dot(N1, T_dot) * T,
            -ca.dot(N2, T_dot) * T,
            *chain[: 4 if level is Level.MOTORS else 3],
        )
        outputs = [ca.dot(N1, e), ca.dot(N2, e), ca.dot(T, V) - alpha(s)]
        self.rows = []
        gains = GAINS[level]
        for h, degree, k in zip(outputs, level.degrees[:3], (gains.h1, gains.h1, gains.h3), strict=True):
            derivative, total = h, 0
            for j in range(degree):
                total = total + k[j] * derivative
                derivative = ca.jtimes(derivative, state, rate)
            self.rows.append(derivative + total)
        equations = ca.vertcat(*self.rows)
        solution = ca.solve(ca.jacobian(equations, unknown), -ca.substitute(equations, unknown, ca.DM.zeros(3)))
        inputs = [u, s, N1, N2, X, V, A, *([J] if level is Level.MOTORS else [])]
        self.solve = ca.Function("oracle", inputs, [solution])
        self.tangent = ca.Function("tangent", [u], [T])


@pytest.mark.parametrize("level", list(Level), ids=lambda level: level.name)
def test_a_space_curve_against_a_parallel_transport_oracle(level: Level) -> None:
    """The wanted snap or jerk on a Lissajous curve with a speed over arc length, from thrust and rates back."""
    curve = analytic(lissajous, 0.0, math.tau, True)
    speed = SpeedExpression(parse("3 + sin(s/5)", ("s",)), {})
    law = curve_law(curve, speed, ConstantYaw(0.1), level, MODEL, GAINS[level], None, 1.0)
    oracle = BishopOracle(level, lambda s: 3 + ca.sin(s / 5), MODEL.c)
    rng = random.Random(8)
    worst = 0.0
    for _ in range(150):
        s = rng.uniform(1.0, curve.table.length - 1.0)
        flying = random_flying(rng, curve.table.at(s)[0], s, 0.25)
        command = law(flying, SpeedScale())
        R = np.array(flying.r_nb).reshape(3, 3)
        d, V = np.array(flying.disturbance), np.array(flying.v_n)
        m, c, zeta = MODEL.m, flying.drag, flying.zeta
        A = np.array([0, 0, MODEL.g]) - zeta / m * R[:, 2] + d - c * V
        p, q, r = flying.w_b
        u, _ = curve.closest(flying.p_n, curve.parameter(s))
        T = np.array(oracle.tangent(u)).ravel()
        N1 = np.linalg.svd(T[None])[2][1]
        N2 = np.cross(T, N1)
        position = (u, curve.arc(u), N1, N2, flying.p_n, flying.v_n, A)
        if level is Level.RATES:
            wanted = np.array(oracle.solve(*position)).ravel()
            zeta_dot = command.zeta_derivative
            pc, qc, _ = command.turn
            made = -(zeta_dot * R[:, 2] + zeta * R @ np.array([qc, -pc, 0.0])) / m - c * A
        else:
            J = -(flying.zeta_dot * R[:, 2] + zeta * R @ np.array([q, -p, 0.0])) / m - c * A
            wanted = np.array(oracle.solve(*position, J)).ravel()
            w = np.array([p, q, r])
            inertia = np.array(MODEL.J.components())
            w_dot = (np.array(command.turn) - np.cross(w, inertia * w)) / inertia
            b_dot = R @ np.array([q, -p, 0.0])
            b_ddot = R @ (np.cross(w, np.cross(w, [0, 0, 1])) + np.cross(w_dot, [0, 0, 1]))
            made = -(command.zeta_derivative * R[:, 2] + 2 * flying.zeta_dot * b_dot + zeta * b_ddot) / m - c * J
        worst = max(worst, float(np.max(np.abs(made - wanted)) / np.max(np.abs(wanted))))
    assert worst < 1e-9


def test_yaw_over_arc_length_is_differentiated() -> None:
    curve = analytic(lissajous, 0.0, math.tau, True)
    yaw = YawExpression(parse("90*sin(s/4)", ("s",)), {})
    level = Level.RATES
    law = curve_law(curve, ConstantSpeed(3.0), yaw, level, MODEL, GAINS[level], None, 1.0)
    s = 9.0
    x, T, _ = curve.table.at(s)
    velocity = (3.0 * T[0], 3.0 * T[1], 3.0 * T[2])
    heading = math.radians(90.0 * math.sin(s / 4.0))
    command = law(Flying(x, velocity, rotation_from_euler(heading, 0.0, 0.0), 16.0, s=s), SpeedScale())
    assert command.beta == pytest.approx(heading, abs=1e-6)
    # level and on the wanted heading, the yaw rate is beta'(s) times the speed
    assert command.turn[2] == pytest.approx(math.radians(90.0) * math.cos(s / 4.0) / 4.0 * 3.0, rel=1e-4)


def test_a_crossing_keeps_its_branch() -> None:
    """At the middle of the figure-eight both branches are near: the one at hand is kept."""
    curve: Curve = analytic(lambda u: (6.0 * cos(u), 3.0 * sin(2.0 * u), -10.0 + 0.0 * u), 0.0, math.tau, True)
    law = curve_law(curve, ConstantSpeed(3.0), ConstantYaw(0.0), Level.RATES, MODEL, GAINS[Level.RATES], None, 1.0)
    one, two = curve.arc(0.5 * math.pi), curve.arc(1.5 * math.pi)
    at = Flying((0.02, 0.01, -10.0), (0.0, 0.0, 0.0), rotation_from_euler(0, 0, 0), 16.0)
    first, second = law(at._replace(s=one), SpeedScale()).tangent, law(at._replace(s=two), SpeedScale()).tangent
    assert first[0] < -0.5
    assert second[0] > 0.5


def test_a_table_over_arc_length_on_an_implicit_path() -> None:
    """On the path and along it, speed and yaw over arc length are those of the same circle as a curve."""
    spec = implicit("hypot(x, y) - 7", "z + 4", "0", lambda p, mu: 0.0)
    curve = analytic(lambda u: (7.0 * cos(u), -7.0 * sin(u), -4.0), 0.0, math.tau, True)
    period = curve.table.length
    speed = speed_table([(0.0, 2.0), (10.0, 4.0), (25.0, 3.0)], period)
    yaw = yaw_table([(0.0, 0.2), (12.0, 1.4), (30.0, -0.5)], period)
    a = implicit_law(spec, Level.RATES, MODEL, GAINS[Level.RATES], None, OverArc(curve.table, speed, yaw))
    b = curve_law(curve, speed, yaw, Level.RATES, MODEL, GAINS[Level.RATES], None, 1.0)
    rng = random.Random(6)
    for _ in range(60):
        s = rng.uniform(0.0, period)
        x, T, _ = curve.table.at(s)
        v = rng.uniform(-4.0, 6.0)
        flying = random_flying(rng, x, s, 0.0)._replace(v_n=(v * T[0], v * T[1], v * T[2]))
        assert difference(a, b, flying, SpeedScale(0.7, 0.2, -0.1)) < 1e-8
