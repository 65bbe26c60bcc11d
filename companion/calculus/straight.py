"""Records arithmetic on symbols and prints it as one straight-line Python function of floats.

Equal terms are computed once, constants are folded, what no output needs is left out. The result runs at the speed of
hand-written float code: a step of the paper's law in 10-20 us where the same arithmetic on objects takes a millisecond.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.calculus.scalar import ARRAY_FUNCTIONS, FLOAT_FUNCTIONS, Scalar

Function = Callable[..., tuple[Any, ...]]
"""Of floats and tuples of floats, to a tuple of such."""
Outputs = Sequence[Scalar | Sequence[Scalar]]
ArrayFunction = Callable[..., NDArray[np.float64]]

_OPERATORS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_NESTING_MAX = 12
"""operations written into one expression of the generated code (engineering choice)."""


class Symbol:
    """A float that is not known yet. Arithmetic on it is recorded on its tape."""

    __slots__ = ("arguments", "index", "operation", "tape")

    def __init__(self, tape: Tape, index: int, operation: str, arguments: tuple[Any, ...]) -> None:
        self.tape = tape
        self.index = index
        self.operation = operation
        self.arguments = arguments

    def __neg__(self) -> Scalar:
        if self.operation == "neg":
            return self.arguments[0]
        return self.tape.record("neg", (self,))

    def __add__(self, other: Scalar) -> Scalar:
        if not isinstance(other, Symbol | float | int):
            return NotImplemented
        if other == 0.0:
            return self
        if isinstance(other, Symbol) and other.operation == "neg":
            return self - other.arguments[0]
        return self.tape.record("add", _ordered(self, other))

    def __radd__(self, other: float) -> Scalar:
        return self + other

    def __sub__(self, other: Scalar) -> Scalar:
        if not isinstance(other, Symbol | float | int):
            return NotImplemented
        if other == 0.0:
            return self
        if other is self:
            return 0.0
        if isinstance(other, Symbol) and other.operation == "neg":
            return self + other.arguments[0]
        return self.tape.record("sub", (self, other))

    def __rsub__(self, other: float) -> Scalar:
        return -self if other == 0.0 else self.tape.record("sub", (other, self))

    def __mul__(self, other: Scalar) -> Scalar:
        if not isinstance(other, Symbol | float | int):
            return NotImplemented
        if not isinstance(other, Symbol):
            if other == 0.0:
                return 0.0
            if other == 1.0:
                return self
            if other == -1.0:
                return -self
        return self.tape.record("mul", _ordered(self, other))

    def __rmul__(self, other: float) -> Scalar:
        return self * other

    def __truediv__(self, other: Scalar) -> Scalar:
        if not isinstance(other, Symbol | float | int):
            return NotImplemented
        if other == 1.0:
            return self
        return self.tape.record("div", (self, other))

    def __rtruediv__(self, other: float) -> Scalar:
        return 0.0 if other == 0.0 else self.tape.record("div", (other, self))

    def elementary(self, function: str, arguments: tuple[Scalar, ...]) -> Scalar:
        """``function`` of ``arguments``, recorded."""
        for argument in arguments:
            if not isinstance(argument, Symbol | float | int):
                return argument.elementary(function, arguments)
        return self.tape.record(function, arguments)


class Packed(tuple[Any, ...]):
    """Inputs, or outputs, that only recorded functions read: see ``machine_code.packed``."""


class Tape:
    """A recording: make its ``inputs``, compute with them, then ask for a ``function``."""

    def __init__(self) -> None:
        self._symbols: list[Symbol] = []
        self._known: dict[tuple[Any, ...], Symbol] = {}
        self.arguments: list[tuple[str, ...] | str] = []
        """What the function will take, in the order it was made: floats, and tuples of so many floats."""

    def inputs(self, *names: str) -> tuple[Symbol, ...]:
        """New inputs, each an argument of the function."""
        self.arguments += names
        return tuple(self.record("input", (name,)) for name in names)

    def tuple_input(self, *names: str, packed: bool = False) -> tuple[Symbol, ...]:
        """New inputs that the function takes together, as one tuple. ``packed``: see Packed."""
        self.arguments.append(Packed(names) if packed else names)
        return tuple(self.record("input", (name,)) for name in names)

    def record(self, operation: str, arguments: tuple[Any, ...]) -> Symbol:
        """The symbol of an operation, the same one for the same operation."""
        key = (operation, *(a.index if isinstance(a, Symbol) else (a,) for a in arguments))
        symbol = self._known.get(key)
        if symbol is None:
            symbol = Symbol(self, len(self._symbols), operation, arguments)
            self._symbols.append(symbol)
            self._known[key] = symbol
        return symbol

    def needed(self, outputs: Outputs) -> list[Symbol]:
        """What the outputs are made of, each after what it is made of itself."""
        uses = self._uses(outputs)
        return [symbol for symbol in self._symbols if symbol.index in uses]

    def function(self, name: str, outputs: Outputs) -> Function:
        """A Python function of the arguments that returns ``outputs`` as a tuple."""
        return self._compiled(self.source(name, outputs), name, FLOAT_FUNCTIONS)

    def array_function(self, name: str, outputs: Outputs) -> ArrayFunction:
        """The same for many inputs at once: arrays (or floats) in, every input for itself, one row an output, nan where
        undefined."""
        function = self._compiled(self._source(name, flat(self.arguments), flat(outputs)), name, ARRAY_FUNCTIONS)

        def rows(*inputs: NDArray[np.float64] | float) -> NDArray[np.float64]:
            with np.errstate(all="ignore"):
                values = function(*inputs)
            return np.stack(np.broadcast_arrays(*values, *inputs)[: len(values)]).astype(float)

        return rows

    @staticmethod
    def _compiled(source: str, name: str, functions: Mapping[str, Callable[..., Any]]) -> Function:
        namespace: dict[str, Any] = {f"_{n}": f for n, f in functions.items()}
        exec(compile(source, f"<{name}>", "exec"), namespace)
        function: Function = namespace[name]
        return function

    def source(self, name: str, outputs: Outputs) -> str:
        """The text of that function: only names made here and float constants stand in it."""
        return self._source(name, self.arguments, outputs)

    def _source(self, name: str, arguments: Sequence[tuple[str, ...] | str], outputs: Outputs) -> str:
        uses = self._uses(outputs)
        taken = [given if isinstance(given, str) else f"_{at}" for at, given in enumerate(arguments)]
        lines = [f"def {name}({', '.join(taken)}):"]
        lines += [f"    {', '.join(given)}, = _{at}" for at, given in enumerate(arguments) if isinstance(given, tuple)]
        text: dict[int, str] = {}
        nesting: dict[int, int] = {}
        for symbol in self._symbols:
            if symbol.index not in uses:
                continue
            index = symbol.index
            if symbol.operation == "input":
                text[index], nesting[index] = symbol.arguments[0], 0
                continue
            parts = [text[a.index] if isinstance(a, Symbol) else _constant(a) for a in symbol.arguments]
            depth = 1 + max((nesting[a.index] for a in symbol.arguments if isinstance(a, Symbol)), default=0)
            if symbol.operation == "neg":
                value = f"(-{parts[0]})"
            elif symbol.operation in _OPERATORS:
                value = f"({parts[0]} {_OPERATORS[symbol.operation]} {parts[1]})"
            else:
                value = f"_{symbol.operation}({', '.join(parts)})"
            if uses[index] == 1 and depth < _NESTING_MAX:
                text[index], nesting[index] = value, depth
            else:
                lines.append(f"    t{index} = {value}")
                text[index], nesting[index] = f"t{index}", 0

        def returned(output: Scalar | Sequence[Scalar]) -> str:
            if isinstance(output, Sequence):
                return f"({''.join(f'{returned(item)}, ' for item in output)})"
            return text[output.index] if isinstance(output, Symbol) else _constant(output)

        lines.append(f"    return {returned(outputs)}")
        return "\n".join(lines) + "\n"

    def _uses(self, outputs: Outputs) -> dict[int, int]:
        """How often each symbol is used on the way to the outputs."""
        uses: dict[int, int] = {}
        for output in flat(outputs):
            if isinstance(output, Symbol):
                uses[output.index] = uses.get(output.index, 0) + 1
        for symbol in reversed(self._symbols):
            if symbol.index in uses:
                for argument in symbol.arguments:
                    if isinstance(argument, Symbol):
                        uses[argument.index] = uses.get(argument.index, 0) + 1
        return uses


def flat(given: Sequence[Any]) -> list[Any]:
    """The members of a sequence, those of tuples and lists in it in their places."""
    return [item for each in given for item in (each if isinstance(each, tuple | list) else (each,))]


def _ordered(a: Symbol, b: Scalar) -> tuple[Scalar, Scalar]:
    """The arguments of a commutative operation in one order, so that a*b and b*a are the same term."""
    return (b, a) if isinstance(b, Symbol) and b.index < a.index else (a, b)


def _constant(value: float) -> str:
    value = float(value)
    if math.isnan(value) or math.isinf(value):
        raise OverflowError("a constant of the expression is not finite")
    return repr(value) if value >= 0.0 else f"({value!r})"
