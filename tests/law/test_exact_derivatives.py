"""The law against exact Lie derivatives: given values, and an independent oracle for expressions of any form."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from companion.calculus.expression import parse
from companion.calculus.vectors import Vector
from companion.frames import Heading, rotation_from_euler
from companion.law.bare import bare_law
from companion.law.errors import LawError
from companion.law.feedback import Bounds
from companion.law.flight import Flying, implicit_law
from companion.law.gains import Gains, Level
from companion.law.implicit import Specification
from companion.law.motion import Model
from companion.law.speed_scale import SpeedScale
from tests.support.oracle import oracle

DATA = Path(__file__).parents[1] / "data"

GIVEN = {
    "circle_sq": ("x**2 + y**2 - r**2", "z - z0", "alpha", "beta"),
    "circle_dist": ("sqrt(x**2 + y**2) - r", "z - z0", "alpha", "beta"),
    "ellipse_tilted": ("(x/a)**2 + (y/b)**2 - 1", "z - z0 - kx*x - ky*y", "alpha", "beta"),
    "ellipse_profile": (
        "(x/a)**2 + (y/b)**2 - 1",
        "z - z0 - kx*x - ky*y",
        "alpha + alpha1*(y/b)/hypot(x/a, y/b)",
        "beta + beta1*(x/a)/hypot(x/a, y/b) + beta2*y/b",
    ),
}

ANY_FORM = {
    "circle on a wavy sheet": ("hypot(x, y) - 6 - sin(3*atan2(y, x))", "z + 5 - 0.5*cos(x)", "2 + exp(-y**2/9)", "0.3*x"),
    "intersection of a sphere and a cylinder": ("x**2 + y**2 + z**2 - 49", "(x - 2)**2 + y**2 - 16", "3 + tan(z/9)", "y/5"),
    "super-ellipse": ("abs(x/9)**3.5 + abs(y/6)**3.5 - 1", "z + 8 - log(9 + x)", "3*sqrt(1.2 + x/40)", "atan(x - y)"),
    "logarithms and inverse functions": (
        "log(x**2/30 + y**2/20) - asin(z/50)", "z + 6 + acos(x/60)/3", "-2 - 1/(1 + y**2)", "degrees_free*x**3/500"),
    "power of an expression": ("(x**2 + y**2)**1.5/5**3 - 1.1**z", "z + 4 - 2**(x/9)", "-(3 + y/20)", "hypot(x, z)/9"),
}  # fmt: skip


TWISTED = "intersection of a sphere and a cylinder"
"""Of them the one that is flown with the twist heading too."""


def specification(texts: Sequence[str], constants: Mapping[str, float]) -> Specification:
    h1, h2, alpha, beta = (parse(text, ("x", "y", "z", *constants)) for text in texts)

    def names(p: Any) -> dict[str, Any]:
        return {"x": p[0], "y": p[1], "z": p[2], **constants}

    return Specification(
        lambda p: (h1(names(p)), h2(names(p))), lambda p, mu: alpha(names(p)), lambda p, mu: beta(names(p))
    )


def model_of(given: Mapping[str, float]) -> Model:
    return Model(given["m"], Vector(given["Ix"], given["Iy"], given["Iz"]), given["g"])


def gains_of(given: Mapping[str, Sequence[float]]) -> Gains:
    k1, k2, k3, k4 = (tuple(given[k]) for k in ("k1", "k2", "k3", "k4"))
    return Gains(k1, k2, k3, k4)


def error(ours: Any, theirs: Any) -> float:
    """The largest difference over the largest entry."""
    a, b = np.ravel(np.array(ours, dtype=float)), np.ravel(np.array(theirs, dtype=float))
    assert a.shape == b.shape
    return float(np.max(np.abs(a - b)) / np.max(np.abs(b)))


def cases(file: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((DATA / file).read_text())["cases"]
    return found


@pytest.mark.parametrize("case", cases("law_cases.json"), ids=lambda c: f"{c['path']}-{c['id']}")
def test_given_values_at_the_level_of_motors(case: dict[str, Any]) -> None:
    spec = specification(GIVEN[case["path"]], case["path_params"])
    answer = bare_law(spec, Level.MOTORS, model_of(case["model"]), gains_of(case["gains"]))(case["chi"])
    assert error(answer.xi, case["xi"]) < 1e-12
    assert error(answer.b, case["b"]) < 1e-12
    assert error(answer.D, case["D"]) < 1e-12
    assert error(answer.inputs, case["ubar"]) < 1e-10


@pytest.mark.parametrize("case", cases("law_cases_level3.json"), ids=lambda c: f"{c['path']}-{c['id']}")
def test_given_values_at_the_level_of_rates(case: dict[str, Any]) -> None:
    spec = specification(GIVEN[case["path"]], case["path_params"])
    answer = bare_law(spec, Level.RATES, model_of(case["model"]), gains_of(case["gains"]))(case["chi"])
    assert error(answer.xi, case["xi"]) < 1e-12
    assert error(answer.b, case["b"]) < 1e-12
    assert error(answer.D, case["D"]) < 1e-12
    assert error(answer.inputs, case["u"]) < 1e-10


MODEL = {"m": 1.7, "g": 9.81, "Ix": 0.021, "Iy": 0.026, "Iz": 0.039}


def random_state(rng: random.Random, level: Level) -> list[float]:
    around = rng.uniform(0.0, math.tau)
    X = [7.0 * math.cos(around) + rng.gauss(0, 0.7), 6.0 * math.sin(around) + rng.gauss(0, 0.7), -6.0 + rng.gauss(0, 1)]
    angles = [rng.uniform(-3.0, 3.0), rng.uniform(-1.2, 1.2), rng.uniform(-1.2, 1.2)]
    V = [rng.gauss(0, 3) for _ in range(3)]
    if level is Level.RATES:
        return [*X, *angles, *V, rng.uniform(5, 30)]
    return [*X, *angles, *V, *(rng.gauss(0, 2) for _ in range(3)), rng.uniform(5, 30), rng.gauss(0, 10)]


@pytest.mark.parametrize("level", list(Level), ids=lambda level: level.name)
@pytest.mark.parametrize(
    ("name", "kind"), [*((name, Heading.PROJECTED) for name in ANY_FORM), (TWISTED, Heading.TWIST)]
)
def test_expressions_of_any_form_equal_the_oracle(name: str, kind: Heading, level: Level) -> None:
    texts = ANY_FORM[name]
    constants = {"degrees_free": 0.7}
    exact = oracle(*texts, constants, MODEL, level is Level.RATES, kind is Heading.TWIST)
    gains = Gains(*(tuple(float(3 + j) for j in range(n)) for n in level.degrees))
    law = bare_law(replace(specification(texts, constants), heading=kind), level, model_of(MODEL), gains)
    rng = random.Random(name)
    for _ in range(25):
        chi = random_state(rng, level)
        answer, truth = law(chi), exact(chi)
        assert truth.lower == 0.0  # the relative degree is well defined (Lemma 4.1)
        assert error(answer.xi, truth.xi) < 1e-11
        assert error(answer.b, truth.b) < 1e-11
        assert error(answer.D, truth.D) < 1e-11
        xi = np.split(truth.xi, np.cumsum(level.degrees)[:3])
        v = [-float(np.dot(k, x)) for k, x in zip(gains.each, xi, strict=True)]
        assert error(answer.inputs, np.linalg.solve(truth.D, v - truth.b)) < 1e-9


@pytest.mark.parametrize("name", [TWISTED])
def test_the_factored_form_with_the_twist_heading(name: str) -> None:
    """Where h4 need not be wrapped the two forms are equal, as steep as it may be."""
    spec = replace(specification(ANY_FORM[name], {"degrees_free": 0.7}), heading=Heading.TWIST)
    rng = random.Random(name)
    for level in Level:
        gains = Gains(*(tuple(float(3 + j) for j in range(n)) for n in level.degrees))
        bare = bare_law(spec, level, model_of(MODEL), gains)
        flown = implicit_law(spec, level, model_of(MODEL), gains, None)
        compared = 0
        for _ in range(40):
            chi = random_state(rng, level)
            wanted = bare(chi)
            if abs(wanted.xi[-2] if level is Level.MOTORS else wanted.xi[-1]) > math.pi:
                continue
            w = (0.0, 0.0, 0.0) if level is Level.RATES else (chi[9], chi[10], chi[11])
            zeta, zeta_dot = (chi[9], 0.0) if level is Level.RATES else (chi[12], chi[13])
            place, speed = (chi[0], chi[1], chi[2]), (chi[6], chi[7], chi[8])
            command = flown(Flying(place, speed, rotation_from_euler(*chi[3:6]), zeta, w, zeta_dot), SpeedScale())
            assert error([command.zeta_derivative, *command.turn], wanted.inputs) < 1e-9
            compared += 1
        assert compared > 10


@pytest.mark.parametrize("name", ANY_FORM)
def test_the_factored_form_equals_the_lie_derivative_form(name: str) -> None:
    texts = ANY_FORM[name]
    constants = {"degrees_free": 0.7}
    spec = specification(texts, constants)
    rng = random.Random(name)
    for level in Level:
        gains = Gains(*(tuple(float(3 + j) for j in range(n)) for n in level.degrees))
        bare = bare_law(spec, level, model_of(MODEL), gains)
        flown = implicit_law(spec, level, model_of(MODEL), gains, None)
        for _ in range(25):
            chi = random_state(rng, level)
            if level is Level.RATES:
                w, zeta, zeta_dot = (0.0, 0.0, 0.0), chi[9], 0.0
            else:
                w, zeta, zeta_dot = (chi[9], chi[10], chi[11]), chi[12], chi[13]
            # the yaw error is not wrapped in the bare form: compare where it need not be
            wanted = bare(chi)
            h4 = wanted.xi[-2] if level is Level.MOTORS else wanted.xi[-1]
            shift = math.tau * round(h4 / math.tau)
            wanted = bare([*chi[:3], chi[3] - shift, *chi[4:]])
            p, q, r = chi[:3], chi[6:9], rotation_from_euler(*chi[3:6])
            flying = Flying((p[0], p[1], p[2]), (q[0], q[1], q[2]), r, zeta, w, zeta_dot)
            command = flown(flying, SpeedScale())
            assert error([command.zeta_derivative, *command.turn], wanted.inputs) < 1e-9


@pytest.mark.parametrize("kind", list(Heading), ids=lambda kind: kind.value)
def test_determinant_of_D(kind: Heading) -> None:
    """Lemma 4.1 without its factor d^3; and the same for rates. With the twist heading roll and pitch have no say."""
    rng = random.Random(4)
    m, ix, iy, iz = (MODEL[k] for k in ("m", "Ix", "Iy", "Iz"))
    for name, texts in ANY_FORM.items():
        exact = replace(specification(texts, {"degrees_free": 0.7}), heading=kind)
        for level in Level:
            gains = Gains(*((1.0,) * n for n in level.degrees))
            law = bare_law(exact, level, model_of(MODEL), gains)
            chi = random_state(rng, level)
            theta, phi, zeta = chi[4], chi[5], chi[9] if level is Level.RATES else chi[12]
            D = np.array(law(chi).D)
            # (grad h1 x grad h2) . mu is the length of the cross product: from D itself, whose rows carry the gradients
            R = np.array(rotation_from_euler(*chi[3:6])).reshape(3, 3)
            scale = np.stack([-R[:, 2] / m, zeta / m * R[:, 1], -zeta / m * R[:, 0]])
            if level is Level.MOTORS:
                scale[1] /= ix
                scale[2] /= iy
            gradients = np.linalg.solve(scale, D[:3, :3].T).T
            area = float(np.linalg.norm(np.cross(gradients[0], gradients[1])))
            expected = -(zeta**2) / m**3 * area
            if kind is Heading.PROJECTED:
                expected *= math.cos(phi) / math.cos(theta)
            if level is Level.MOTORS:
                expected /= ix * iy * iz
            assert np.linalg.det(D) == pytest.approx(expected, rel=1e-9), name


def test_where_the_law_is_not_defined() -> None:
    spec = specification(GIVEN["circle_sq"], {"r": 10.0, "z0": -20.0, "alpha": 3.0, "beta": 0.0})
    law = bare_law(spec, Level.MOTORS, model_of(MODEL), Gains((1,) * 4, (1,) * 4, (1,) * 3, (1,) * 2))
    good = [0.0, 10.0, -20.0, 0.0, 0.1, 0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 20.0, 0.0]
    law(good)
    for index, value, reason in (
        (12, 0.0, "zeta = 0"),
        (5, math.pi / 2, "phi"),
        (4, -math.pi / 2, "theta"),
        (1, 0.0, "grad h1 and grad h2"),
    ):
        bad = list(good)
        bad[index] = value
        with pytest.raises(LawError, match=reason):
            law(bad)


def test_a_domain_left_is_said() -> None:
    law = bare_law(
        specification(("sqrt(x) - 2", "z + y", "1", "0"), {}),
        Level.RATES,
        model_of(MODEL),
        Gains((1,) * 3, (1,) * 3, (1,) * 2, (1,)),
    )
    with pytest.raises(LawError, match="not defined here"):
        law([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 10.0])


def test_bounds_do_not_touch_a_small_error() -> None:
    spec = specification(GIVEN["circle_dist"], {"r": 5.0, "z0": -5.0, "alpha": 3.0, "beta": 0.0})
    gains = Gains((625.0, 500.0, 150.0, 20.0), (625.0, 500.0, 150.0, 20.0), (27.0, 27.0, 9.0), (4.0, 4.0))
    free = implicit_law(spec, Level.MOTORS, model_of(MODEL), gains, None)
    bound = implicit_law(spec, Level.MOTORS, model_of(MODEL), gains, Bounds())
    r = rotation_from_euler(0.2, 0.1, -0.1)
    flying = Flying((0.3, 5.2, -5.1), (2.5, 0.1, 0.0), r, 16.0, (0.1, 0.0, 0.1), 1.0)
    a, b = (law(flying, SpeedScale()) for law in (free, bound))
    assert a.zeta_derivative == pytest.approx(b.zeta_derivative, rel=1e-12)
    assert a.turn == pytest.approx(b.turn, rel=1e-12)


def test_bounds_hold_what_a_large_error_asks() -> None:
    """Ten metres above and outside: with bounds the law asks for no more than from the bound's distance."""
    spec = specification(GIVEN["circle_dist"], {"r": 5.0, "z0": -5.0, "alpha": 3.0, "beta": 0.0})
    gains = Gains((625.0, 500.0, 150.0, 20.0), (625.0, 500.0, 150.0, 20.0), (27.0, 27.0, 9.0), (4.0, 4.0))
    bound = implicit_law(spec, Level.MOTORS, model_of(MODEL), gains, Bounds())
    level = rotation_from_euler(0.0, 0.0, 0.0)
    hover = MODEL["m"] * MODEL["g"]

    def asked(up: float) -> float:
        return bound(Flying((0.0, 5.0, -5.0 - up), (3.0, 0.0, 0.0), level, hover), SpeedScale()).zeta_derivative

    assert asked(10.0) == pytest.approx(asked(1.5), rel=1e-9)
    assert abs(asked(1.0)) < abs(asked(1.5))
