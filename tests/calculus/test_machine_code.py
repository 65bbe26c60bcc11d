"""Recorded functions as machine code: the same floats as in Python, bit for bit, in the arithmetic and in a flight."""

from __future__ import annotations

import dataclasses
import math
import random
import struct
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from companion.calculus import machine_code
from companion.calculus.expression import parse
from companion.calculus.machine_code import PackedNumbers, packed, unpacked
from companion.calculus.scalar import Scalar, elementary, maximum, minimum, sqrt, wrap
from companion.calculus.straight import Function, Packed, Tape, flat
from companion.estimation.kalman_step import AXES, PER_AXIS, SIZE, UPPER, step_of
from companion.estimation.predictor import ForceModel, predict
from companion.estimation.rate_loop_model import RateLoopState, TimedCommand, alike
from companion.study.flying import cases_of, row_of
from companion.study.reading import load_study
from sim_bridge.integrate import advance_of
from sim_bridge.rigid_body import Body
from tests.calculus.test_calculus import SAMPLES

CIRCLE = Path(__file__).resolve().parents[2] / "configs/studies/dispersed_circle.yaml"
SPECIAL = (0.0, -0.0, 1.0, -1.0, math.pi, 1e300, 1e-300, 5e-324, math.inf, -math.inf, math.nan)


@pytest.fixture(autouse=True)
def in_use() -> Iterator[None]:
    pytest.importorskip("llvmlite")
    before = machine_code.in_use
    assert machine_code.use()
    yield
    machine_code.in_use = before


def bits(values: Sequence[float]) -> list[bytes]:
    """Every nan alike, and -0.0 not 0.0."""
    return [b"nan" if math.isnan(value) else struct.pack("d", value) for value in values]


def outcome(function: Function, *inputs: float | PackedNumbers) -> object:
    """What a function gives, or that it raises."""
    try:
        return bits(flat([unpacked(part) for part in function(*inputs)]))
    except (ValueError, ArithmeticError):
        return "raised"


def both(tape: Tape, outputs: Sequence[Scalar]) -> tuple[Function, Function]:
    text = machine_code.assembly(tape, outputs)
    assert text is not None
    return tape.function("f", outputs), machine_code.compiled(text)


def test_operations_are_those_of_python_for_every_kind_of_float() -> None:
    tape = Tape()
    x, y = tape.inputs("x", "y")
    results = [x + y, x - y, x * y, -x, 2.5 - x, maximum(x, y), minimum(x, y), minimum(x, 1.0), abs_of(x), sine_of(x)]
    for result in (
        *results,
        x / y,
        1.0 / x,
        sqrt(x),
        wrap(x),
        elementary("power", x, 2.0),
        elementary("power", x, y),
        parse("atan2(x, y)", ("x", "y"))({"x": x, "y": y}),
    ):
        python, machine = both(tape, [result])
        for a in SPECIAL:
            for b in SPECIAL:
                assert outcome(machine, a, b) == outcome(python, a, b), (result.operation, a, b)


def abs_of(x: Scalar) -> Scalar:
    return parse("abs(x)", ("x",))({"x": x})


def sine_of(x: Scalar) -> Scalar:
    return parse("sin(x)*cos(x)", ("x",))({"x": x})


def test_products_are_rounded_before_they_are_added() -> None:
    """A processor that multiplies and adds in one would leave the rounding error of the product."""
    tape = Tape()
    x, y = tape.inputs("x", "y")
    _, machine = both(tape, [x * x - y])
    a = 1.0 + 2.0**-30
    assert machine(a, a * a) == (0.0,)


def test_it_is_called_as_pythons_own_functions_are() -> None:
    tape = Tape()
    x, y = tape.inputs("x", "y")
    _, machine = both(tape, [x / y, 2.0, y])
    assert machine(1, 2.0) == (0.5, 2.0, 2.0)
    for given in ((), (1.0,), (1.0, 2.0, 3.0), ("1", 2.0), (1.0, None)):
        with pytest.raises(TypeError):
            machine(*given)  # type: ignore[arg-type] # what is wrong of them is tested
    with pytest.raises(ArithmeticError):
        machine(1.0, 0.0)


def test_tuples_are_taken_and_given_as_they_are() -> None:
    tape = Tape()
    (x,), (a, _, c), (y,) = tape.inputs("x"), tape.tuple_input("a", "b", "c"), tape.inputs("y")
    for function in both(tape, [x, (a + c, 2.0), [y]]):
        assert function(1.0, (2.0, 3.0, 4.0), 5.0) == (1.0, (6.0, 2.0), (5.0,))
        for wrong in ((2.0, 3.0), (2.0, 3.0, 4.0, 5.0), 2.0, None):
            with pytest.raises((TypeError, ValueError)):
                function(1.0, wrong, 5.0)
    many = tape.array_function("f", [x, (a + c, 2.0), [y]])
    assert many(1.0, 2.0, 3.0, 4.0, 5.0).tolist() == [1.0, 6.0, 2.0, 5.0]


def test_packed_numbers_are_read_and_made_by_functions_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    tape = Tape()
    a, b, c = tape.tuple_input("a", "b", "c", packed=True)
    python, machine = both(tape, [a + b, Packed([b, -c])])
    assert python((1.0, 2.0, 3.0)) == (3.0, (2.0, -3.0))
    given = packed([1.0, 2.0, 3.0])
    assert isinstance(given, bytes) and unpacked(given) == (1.0, 2.0, 3.0)
    assert machine(given) == (3.0, packed((2.0, -3.0)))
    for wrong in (packed([1.0, 2.0]), packed([1.0] * 4), (1.0, 2.0, 3.0), 1.0, None):
        with pytest.raises(TypeError):
            machine(wrong)
    monkeypatch.setattr(machine_code, "in_use", False)
    assert packed([1.0, 2.0, 3.0]) == unpacked((1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)


def test_what_is_not_known_stays_python() -> None:
    for text in SAMPLES:
        tape = Tape()
        x, y, z = tape.inputs("x", "y", "z")
        outputs = [parse(text, ("x", "y", "z"))({"x": x, "y": y, "z": z})]
        function, python = machine_code.function_of(tape, "f", outputs), tape.function("f", outputs)
        rng = random.Random(text)
        for _ in range(50):
            given = [rng.uniform(-1.5, 1.5) for _ in range(3)]
            assert outcome(function, *given) == outcome(python, *given)


def test_without_llvmlite_everything_stays_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "in_use", False)
    for name in ("llvmlite", "llvmlite.binding"):
        monkeypatch.setitem(sys.modules, name, None)
    assert not machine_code.use()
    tape = Tape()
    (x,) = tape.inputs("x")
    assert machine_code.function_of(tape, "f", [2.0 * x])(1.5) == (3.0,)


@pytest.mark.parametrize("learning", [True, False])
def test_the_step_of_the_filter_is_the_same(learning: bool) -> None:
    rng = random.Random(1)
    belief = (SIZE, AXES * len(UPPER), 2 * AXES * PER_AXIS, 3, SIZE, SIZE)
    for _ in range(200):
        single = [rng.uniform(-1.0, 1.0) for _ in range(7)]
        force, p_n, v_n, *levels, by_lag, by_curve = (tuple(rng.uniform(-1.0, 1.0) for _ in range(3)) for _ in range(9))
        known = [tuple(rng.uniform(-1.0, 1.0) for _ in range(size)) for size in belief]
        given = (0.008, force, 9.8, p_n, v_n, *single[:2], *levels, *single[2:6], by_lag, by_curve)
        x, S, G, T, *y = known
        machine = outcome(step_of(learning, True), *given, x, packed(S), packed(G), T, *map(packed, y))
        assert machine == outcome(step_of(learning, False), *given, *known)


@pytest.mark.parametrize("horizon", [0.004, 0.05, 0.11])
def test_the_prediction_is_the_same(horizon: float) -> None:
    rng = random.Random(horizon)
    for _ in range(50):
        a, b, c, d = ([rng.uniform(-2.0, 2.0) for _ in range(3)] for _ in range(4))
        state = RateLoopState(tuple(a), tuple(b), 9.0, 0.1)
        commands = tuple(TimedCommand(0.02 * k, (rng.uniform(-1.0, 1.0), 0.3, c[0]), 10.0 + d[0]) for k in range(4))
        forces, loop = ForceModel(1.1, 0.4, tuple(d), 9.8), alike(rng.uniform(0.03, 0.1), 0.03)
        found = []
        for machine_code.in_use in (True, False):
            there = predict(tuple(c), tuple(d), (0.8, 0.6, 0.0, 0.0), state, forces, loop, commands, 0.01, horizon)
            found.append(bits([value for part in there for value in part]))
        assert found[0] == found[1]


@pytest.mark.parametrize("more_drag", [(0.0, 0.0), (0.3, 0.05)])
def test_a_step_of_the_plant_is_the_same(more_drag: tuple[float, float]) -> None:
    rng = random.Random(2)
    arms = tuple((0.1 * x, 0.1 * y, 0.01) for x, y in ((1, 1), (-1, -1), (1, -1), (-1, 1)))
    body = Body(1.9, (0.02, 0.021, 0.04), 9.8, 0.3, 0.01, arms, *more_drag)
    motion, thrusts = (
        tuple(rng.uniform(-2.0, 2.0) for _ in range(13)),
        (tuple(rng.uniform(3.0, 6.0) for _ in range(4)),) * 3,
    )
    flown = []
    for machine_code.in_use in (True, False):
        after, advance = motion, advance_of(body, 0.004)
        for _ in range(100):
            after = advance(after, thrusts, (3.0, -2.0, 0.5), (0.1, 0.0, 9.8), 0.02)  # type: ignore[arg-type]
        flown.append(bits(after))
    assert flown[0] == flown[1]


def test_a_flight_of_a_study_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    case = dataclasses.replace(cases_of(load_study(CIRCLE))[2], duration=3.0, settle=1.0)
    with_it = row_of(case)
    monkeypatch.setattr(machine_code, "in_use", False)
    monkeypatch.setattr(machine_code, "use", lambda: False)
    without = row_of(case)
    assert with_it["outcome"] == "completed"
    assert {**with_it, "wall_s": 0.0} == {**without, "wall_s": 0.0}
