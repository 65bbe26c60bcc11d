"""The text of an expression -> a tree that evaluates on floats, symbols and Taylor series.

Python's own parser reads the text; only numbers, names, ``+ - * / **`` and calls of the functions below pass. Nothing
in an expression can execute code.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from companion.calculus import scalar
from companion.calculus.scalar import Scalar, elementary

FUNCTIONS: dict[str, tuple[int, Callable[..., Scalar]]] = {
    **{name: (1, lambda x, name=name: elementary(name, x)) for name in ("sqrt", "sin", "cos", "tan", "asin", "acos")},
    **{name: (1, lambda x, name=name: elementary(name, x)) for name in ("atan", "exp", "log", "abs")},
    "atan2": (2, scalar.atan2),
    "hypot": (2, scalar.hypot),
    "degrees": (1, lambda x: x * (180.0 / math.pi)),
    "radians": (1, lambda x: x * (math.pi / 180.0)),
}
"""name -> number of arguments, and what it does."""

CONSTANTS = {"pi": math.pi}

LENGTH_MAX = 2000
"""characters of a formula (engineering choice)."""
DEPTH_MAX = 60
"""parentheses and functions inside one another (engineering choice)."""

_OPERATORS: dict[type[ast.operator], Callable[[Scalar, Scalar], Scalar]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: scalar.power,
}


class ExpressionError(ValueError):
    """A text that is not an expression; says what is wrong and what is expected."""


@dataclass(frozen=True, slots=True)
class Expression:
    """A parsed expression. ``names``: the variables and constants it uses, without ``pi``."""

    text: str
    tree: ast.expr
    names: frozenset[str]

    def __call__(self, values: Mapping[str, Scalar]) -> Scalar:
        """Its value. ValueError, ArithmeticError: outside its domain. KeyError: a name without a value."""
        return _evaluate(self.tree, values)

    def __str__(self) -> str:
        return self.text


def parse(text: str, known: Iterable[str] | None) -> Expression:
    """The expression in ``text``, whose names must be among ``known`` (None: any). ExpressionError otherwise."""
    known = None if known is None else [*known]
    if len(text) > LENGTH_MAX:
        raise ExpressionError(f"{len(text)} characters; expected at most {LENGTH_MAX}")
    if not text.strip():
        raise ExpressionError("empty; expected an expression")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except SyntaxError as error:
        where = f" at character {error.offset}" if error.offset else ""
        raise ExpressionError(f"{text!r} is not an expression: {error.msg}{where}") from None
    except (ValueError, MemoryError, RecursionError):
        raise ExpressionError(f"{text[:40]!r} is not an expression") from None
    names: set[str] = set()
    _check(tree, known, names, 0)
    return Expression(text.strip(), tree, frozenset(names))


def _check(node: ast.AST, known: list[str] | None, names: set[str], depth: int) -> None:
    if depth > DEPTH_MAX:
        raise ExpressionError(f"nested deeper than {DEPTH_MAX} levels")
    match node:
        case ast.Constant(value=bool() | complex() | str() | bytes() | None):
            raise ExpressionError(f"{ast.unparse(node)} is not a number")
        case ast.Constant(value=int() | float() as value):
            try:
                finite = math.isfinite(float(value))
            except OverflowError:
                finite = False
            if not finite:
                raise ExpressionError("a number that is too large")
        case ast.Name(id=name):
            if name in CONSTANTS:
                return
            if known is not None and name not in known:
                what = "a function that wants its argument in brackets" if name in FUNCTIONS else "unknown here"
                raise ExpressionError(f"{name!r} is {what}; expected one of {', '.join([*known, *CONSTANTS])}")
            names.add(name)
        case ast.BinOp(op=ast.BitXor()):
            raise ExpressionError("^ is not a power here; expected **")
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
            _check(left, known, names, depth + 1)
            _check(right, known, names, depth + 1)
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=operand):
            _check(operand, known, names, depth + 1)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            if name not in FUNCTIONS:
                raise ExpressionError(f"{name!r} is no function here; expected one of {', '.join(FUNCTIONS)}")
            count = FUNCTIONS[name][0]
            if len(arguments) != count or any(isinstance(a, ast.Starred) for a in arguments):
                raise ExpressionError(f"{name} takes {count} argument{'s' * (count > 1)}, not {len(arguments)}")
            for argument in arguments:
                _check(argument, known, names, depth + 1)
        case _:
            shown = ast.unparse(node)
            raise ExpressionError(
                f"{shown[:40]!r} is not allowed; expected numbers, names, + - * / ** and {', '.join(FUNCTIONS)}"
            )


def _evaluate(node: ast.expr, values: Mapping[str, Scalar]) -> Scalar:
    match node:
        case ast.Constant(value=value):
            return float(value)  # type: ignore[arg-type]
        case ast.Name(id=name):
            return CONSTANTS[name] if name in CONSTANTS else values[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_evaluate(operand, values)
        case ast.UnaryOp(operand=operand):
            return _evaluate(operand, values)
        case ast.BinOp(left=left, op=operator, right=right):
            return _OPERATORS[type(operator)](_evaluate(left, values), _evaluate(right, values))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return FUNCTIONS[name][1](*(_evaluate(argument, values) for argument in arguments))
    raise AssertionError(ast.dump(node))
