"""Taylor arithmetic, straight-line code and expressions: against CasADi, against floats, against attackers."""

from __future__ import annotations

import math
import random
from typing import Any

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.calculus.expression import DEPTH_MAX, FUNCTIONS, ExpressionError, parse
from companion.calculus.scalar import maximum, minimum, wrap
from companion.calculus.straight import Symbol, Tape
from companion.calculus.taylor import Gradient, Taylor
from tests.support.oracle import FUNCTIONS as CASADI

SAMPLES = [
    "x**3 - 2*x*y + z/(1 + x*x)",
    "sqrt(1 + x*x)*sin(y) - cos(z*x)",
    "exp(-x*x/4)*log(3 + y*y) + tan(z/4)",
    "asin(x/5) + acos(y/5)*atan(z)",
    "atan2(y + 3, x - 4) + hypot(x, y + 2)",
    "abs(x + 3)**2.5 + (2 + y*y)**(z/3) + 2**x",
    "degrees(x) - radians(y)*pi + -z + +x",
    "(x - y)**-2 + (x + 5)**0 + 1/(z + 9)**3",
]


def casadi_value(text: str, names: dict[str, Any]) -> Any:
    scope = {
        **CASADI,
        "abs": ca.fabs,
        "hypot": lambda a, b: ca.sqrt(a * a + b * b),
        "degrees": lambda a: a * 180 / math.pi,
        "radians": lambda a: a * math.pi / 180,
        "pi": math.pi,
    }
    return eval(text, {"__builtins__": {}}, {**scope, **names})


@pytest.mark.parametrize("text", SAMPLES)
def test_time_derivatives_and_gradients_equal_casadi(text: str) -> None:
    """The value along X(t) to order 4, and its gradient along X(t), by symbolic differentiation."""
    rng = random.Random(text)
    t, X = ca.SX.sym("t"), ca.SX.sym("X", 3)
    motion = [[rng.uniform(-1.5, 1.5) for _ in range(5)] for _ in range(3)]
    along = ca.vertcat(*(sum(c * t**k for k, c in enumerate(row)) for row in motion))
    exact = casadi_value(text, {"x": X[0], "y": X[1], "z": X[2]}) + 0 * X[0]
    x, y, z = (Taylor(tuple(row)) for row in motion)
    result = parse(text, ("x", "y", "z"))(
        {"x": Gradient(x, (1.0, 0.0, 0.0)), "y": Gradient(y, (0.0, 1.0, 0.0)), "z": Gradient(z, (0.0, 0.0, 1.0))}
    )
    for wanted, ours in zip(
        (exact, *ca.vertsplit(ca.gradient(exact, X))), (result.value, *result.partials), strict=True
    ):
        current = ca.substitute(wanted, X, along)
        for k in range(5):
            theirs = float(ca.Function("f", [t], [current])(0.0))
            mine = ours.derivative(k) if isinstance(ours, Taylor) else ours if k == 0 else 0.0
            assert mine == pytest.approx(theirs, rel=1e-9, abs=1e-9)
            current = ca.gradient(current, t)


@pytest.mark.parametrize("text", SAMPLES)
def test_straight_line_code_equals_direct_evaluation(text: str) -> None:
    rng = random.Random(text)
    expression = parse(text, ("x", "y", "z"))
    tape = Tape()
    x, y, z = tape.inputs("x", "y", "z")
    series = {"x": Taylor((x, 1.0, 0.5)), "y": Taylor((y, x, 0.0)), "z": Taylor((z, 0.0, y))}
    function = tape.function("f", expression(series).c)
    for _ in range(20):
        a, b, c = (rng.uniform(-1.5, 1.5) for _ in range(3))
        direct = expression({"x": Taylor((a, 1.0, 0.5)), "y": Taylor((b, a, 0.0)), "z": Taylor((c, 0.0, b))})
        assert function(a, b, c) == pytest.approx(direct.c, rel=1e-12, abs=1e-12)


@given(st.tuples(*[st.floats(0.2, 3.0)] * 4), st.tuples(*[st.floats(0.2, 3.0)] * 4))
def test_taylor_arithmetic_is_that_of_polynomials(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    p, q = Taylor(a), Taylor(b)
    assert ((p * q) / q).c == pytest.approx(a, rel=1e-6, abs=1e-6)
    assert (p - p).c == (0.0,) * 4
    assert (2.0 * p + 1.0 - p - p).c == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-12)
    assert (1.0 / (1.0 / p)).c == pytest.approx(a, rel=1e-6, abs=1e-6)
    assert (p * p).differentiated().c == pytest.approx((2.0 * p * p.differentiated()).c, rel=1e-9)


def test_equal_terms_are_computed_once_and_constants_folded() -> None:
    tape = Tape()
    x, y = tape.inputs("x", "y")
    source = tape.source("f", [(x + y) * (y + x), 0.0 * x + 1.0 * y, x - x, -1.0 * (-1.0 * x), x * 0.0])
    assert source.count("x + y") + source.count("y + x") == 1
    assert "return (" in source
    assert tape.function("f", [0.0 * x + 1.0 * y, x - x, -1.0 * (-1.0 * x)])(2.0, 3.0) == (3.0, 0.0, 2.0)


def test_bounds_and_wrap_in_straight_line_code() -> None:
    tape = Tape()
    (x,) = tape.inputs("x")
    function = tape.function("f", [maximum(minimum(x, 1.0), -1.0), wrap(x)])
    assert function(4.0) == (1.0, pytest.approx(4.0 - math.tau))
    assert function(-0.5) == (-0.5, -0.5)


def test_a_constant_that_is_not_finite_never_reaches_the_code() -> None:
    tape = Tape()
    (x,) = tape.inputs("x")
    with pytest.raises(OverflowError):
        tape.function("f", [x * math.inf])


def test_a_symbol_refuses_what_is_no_number() -> None:
    (x,) = Tape().inputs("x")
    assert isinstance(x, Symbol)
    with pytest.raises(TypeError):
        _ = x + "1"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x^2 + y", r"expected \*\*"),
        ("", "empty"),
        ("x +", "not an expression"),
        ("q + 1", "'q' is unknown here"),
        ("sin", "wants its argument in brackets"),
        ("sin(x, y)", "takes 1 argument"),
        ("atan2(y)", "takes 2 arguments"),
        ("sinh(x)", "no function here"),
        ("__import__('os').system('true')", "not allowed"),
        ("x.real", "not allowed"),
        ("(lambda: x)()", "not allowed"),
        ("[x for x in (1, 2)]", "not allowed"),
        ("x if y else z", "not allowed"),
        ("x < y", "not allowed"),
        ("x and y", "not allowed"),
        ("True", "not a number"),
        ("'a'", "not a number"),
        ("2j", "not a number"),
        ("x; y", "not an expression"),
        ("x = 3", "not an expression"),
        ("12:30", "not an expression"),
        ("1e999", "too large"),
        ("9" * 400, "too large"),
        ("sin(x=1)", "not allowed"),
        ("sin(*x)", "takes 1 argument"),
        ("x // y", "not allowed"),
        ("x % y", "not allowed"),
        ("~x", "not allowed"),
        ("f'{x}'", "not allowed"),
        ("(" * 300 + "x" + ")" * 300, "not an expression|nested"),
        ("-" * (DEPTH_MAX + 5) + "x", "nested deeper"),
        ("+".join(["x"] * 1500), "characters|nested"),
        ("x\0", "not an expression"),
    ],
)
def test_what_is_no_expression_is_said(text: str, said: str) -> None:
    with pytest.raises(ExpressionError, match=said):
        parse(text, ("x", "y", "z"))


@given(st.text(max_size=40))
def test_any_text_is_an_expression_or_a_fault(text: str) -> None:
    try:
        parse(text, ("x",))
    except ExpressionError:
        return


def test_a_billion_is_not_computed() -> None:
    """Powers of constants overflow at once instead of running for hours."""
    with pytest.raises((OverflowError, ValueError)):
        parse("10**10**10**10", ())({})


def test_every_function_is_known_to_floats() -> None:
    for name, (count, function) in FUNCTIONS.items():
        assert math.isfinite(function(*([0.5] * count))), name
