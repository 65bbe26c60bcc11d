"""A Python function -> the expression that a mission file would hold, recorded by calling it once with symbols.

The law needs exact derivatives, so the function itself is not flown: what it does with its arguments is written down.
numpy's functions are understood (``np.sin(u)``), those of ``math`` take numbers only.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

from companion.calculus.expression import FUNCTIONS
from companion.config.syntax.faults import ConfigError, Fault

_CALLS = {
    **{name: name for name in ("sqrt", "sin", "cos", "tan", "exp", "log", "hypot", "degrees", "radians")},
    **{"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "absolute": "abs"},
    **{"asin": "asin", "acos": "acos", "atan": "atan", "atan2": "atan2", "rad2deg": "degrees", "deg2rad": "radians"},
}
"""numpy's name of a function -> its name in an expression."""
_OPERATORS = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "true_divide": "/", "power": "**"}


class FormulaError(TypeError):
    """A function does something with its arguments that no expression can."""


class Symbol:
    """What stands for a variable while a function is recorded. ``text``: what has become of it so far."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Symbol:
        name = ufunc.__name__
        if method == "__call__" and not options:
            if name in _CALLS:
                return Symbol(f"{_CALLS[name]}({', '.join(map(_text, inputs))})")
            if name in _OPERATORS:
                return _between(inputs[0], _OPERATORS[name], inputs[1])
            if name == "square":
                return _between(inputs[0], "**", 2)
            if name == "negative":
                return -self
        raise FormulaError(f"numpy.{name} is not known; expected + - * / ** and {', '.join(FUNCTIONS)}")

    def __add__(self, other: Any) -> Symbol:
        return _between(self, "+", other)

    def __radd__(self, other: Any) -> Symbol:
        return _between(other, "+", self)

    def __sub__(self, other: Any) -> Symbol:
        return _between(self, "-", other)

    def __rsub__(self, other: Any) -> Symbol:
        return _between(other, "-", self)

    def __mul__(self, other: Any) -> Symbol:
        return _between(self, "*", other)

    def __rmul__(self, other: Any) -> Symbol:
        return _between(other, "*", self)

    def __truediv__(self, other: Any) -> Symbol:
        return _between(self, "/", other)

    def __rtruediv__(self, other: Any) -> Symbol:
        return _between(other, "/", self)

    def __pow__(self, other: Any) -> Symbol:
        return _between(self, "**", other)

    def __rpow__(self, other: Any) -> Symbol:
        return _between(other, "**", self)

    def __neg__(self) -> Symbol:
        return Symbol(f"(-{self.text})")

    def __pos__(self) -> Symbol:
        return self

    def __abs__(self) -> Symbol:
        return Symbol(f"abs({self.text})")

    def __float__(self) -> float:
        raise FormulaError("needs a number where there is none yet; expected numpy's functions, not those of math")

    def __bool__(self) -> bool:
        raise FormulaError("asks whether something is so; expected one formula for every place, without if and max")

    def _compare(self, other: Any) -> bool:
        return bool(self)

    __lt__ = __le__ = __gt__ = __ge__ = _compare


def recorded(function: Callable[..., Any], variables: Sequence[str], where: str, key: str) -> list[str]:
    """The expressions that a function of ``variables`` returns: one, or several in a tuple. ``where``, ``key``: what is
    said of a function that cannot be recorded (ConfigError)."""
    try:
        inspect.signature(function).bind(*variables)
    except TypeError:
        message = f"takes other arguments; expected a function of {', '.join(variables)}"
        raise ConfigError([Fault(where, 0, key, message)]) from None
    try:
        made = function(*map(Symbol, variables))
        return [_text(each) for each in (made if isinstance(made, tuple | list) else [made])]
    except FormulaError as error:
        raise ConfigError([Fault(where, 0, key, str(error))]) from None


def _between(left: Any, operator: str, right: Any) -> Symbol:
    return Symbol(f"({_text(left)} {operator} {_text(right)})")


def _text(value: Any) -> str:
    if isinstance(value, Symbol):
        return value.text
    try:
        number = repr(float(value))
    except (TypeError, ValueError):
        raise FormulaError(f"makes a {type(value).__name__}; expected a number or a formula") from None
    return f"({number})" if number.startswith("-") else number
