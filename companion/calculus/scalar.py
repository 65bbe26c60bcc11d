"""Arithmetic shared by every number type: floats, symbols, Taylor series, numbers with a gradient.

``+ - * /`` are Python's own operators. The functions here take any of these types; a type other than float brings
``elementary(function, others)``. The table ``DERIVATIVES`` is the only place that knows how a function is
differentiated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

Scalar = Any  # float | Symbol | Taylor | Gradient: a type for this would need a Protocol on every operator


def _sign(x: float) -> float:
    return math.copysign(1.0, x)


FLOAT_FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "atan2": math.atan2,
    "power": math.pow,
    "abs": abs,
    "sign": _sign,
    "minimum": min,
    "maximum": max,
    "remainder": math.remainder,
}
"""What each function is on floats. ValueError, ZeroDivisionError or OverflowError outside its domain."""

ARRAY_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "power": np.power,
    "abs": np.abs,
    "sign": lambda x: np.copysign(1.0, x),
    "minimum": np.minimum,
    "maximum": np.maximum,
    "remainder": lambda x, y: x - y * np.round(x / y),
}
"""The same on numpy arrays. nan outside the domain."""


def elementary(function: str, *arguments: Scalar) -> Scalar:
    """``function`` of ``arguments``, whichever number types they are."""
    for argument in arguments:
        if not isinstance(argument, float | int):
            return argument.elementary(function, arguments)
    return FLOAT_FUNCTIONS[function](*arguments)


def sqrt(x: Scalar) -> Scalar:
    """The square root."""
    return elementary("sqrt", x)


def sin(x: Scalar) -> Scalar:
    """The sine of an angle in radians."""
    return elementary("sin", x)


def cos(x: Scalar) -> Scalar:
    """The cosine of an angle in radians."""
    return elementary("cos", x)


def atan2(y: Scalar, x: Scalar) -> Scalar:
    """The angle of (x, y), radians in [-pi, pi]."""
    return elementary("atan2", y, x)


def minimum(x: Scalar, y: Scalar) -> Scalar:
    """The smaller of two; not differentiated."""
    return elementary("minimum", x, y)


def maximum(x: Scalar, y: Scalar) -> Scalar:
    """The larger of two; not differentiated."""
    return elementary("maximum", x, y)


def wrap(angle: Scalar) -> Scalar:
    """The same angle in [-pi, pi]."""
    return elementary("remainder", angle, math.tau)


def hypot(x: Scalar, y: Scalar) -> Scalar:
    """sqrt(x^2 + y^2)."""
    return sqrt(x * x + y * y)


def absolute(x: Scalar) -> Scalar:
    """|x|; its derivative at 0 is taken as +1."""
    return elementary("abs", x)


def power(x: Scalar, y: Scalar) -> Scalar:
    """x ** y. A whole exponent is repeated multiplication and takes any x; any other needs x > 0."""
    if isinstance(y, float | int):
        if y == int(y) and abs(y) <= 64:
            return _whole_power(x, int(y))
        return elementary("power", x, float(y))
    return elementary("exp", y * elementary("log", x))


def _whole_power(x: Scalar, n: int) -> Scalar:
    if n < 0:
        return 1.0 / _whole_power(x, -n)
    result: Scalar = 1.0
    square = x
    while n:
        if n & 1:
            result = square if result == 1.0 else result * square
        n >>= 1
        if n:
            square = square * square
    return result


DERIVATIVES: dict[str, Callable[..., tuple[Scalar, ...]]] = {
    "sqrt": lambda f, x: (0.5 / f,),
    "exp": lambda f, x: (f,),
    "log": lambda f, x: (1.0 / x,),
    "sin": lambda f, x: (cos(x),),
    "cos": lambda f, x: (-sin(x),),
    "tan": lambda f, x: (1.0 + f * f,),
    "asin": lambda f, x: (1.0 / sqrt(1.0 - x * x),),
    "acos": lambda f, x: (-1.0 / sqrt(1.0 - x * x),),
    "atan": lambda f, x: (1.0 / (1.0 + x * x),),
    "atan2": lambda f, y, x: (x / (x * x + y * y), -y / (x * x + y * y)),
    "power": lambda f, x, n: (n * power(x, n - 1.0), 0.0),
    "abs": lambda f, x: (elementary("sign", x),),
    "sign": lambda f, x: (0.0,),
    "remainder": lambda f, x, period: (1.0, 0.0),
}
"""function -> its partial derivatives, given its value ``f`` and its arguments."""
