"""A recorded function as machine code, by LLVM: the same floats, bit for bit, in a sixth of the time.

For processes that fly hundreds of times (a study's workers, which call ``use``): LLVM takes its time for each function,
and a real flight is not to hang on it. Where llvmlite is not installed (extra ``study``) everything stays Python.

Bit for bit, because it is the same operations in the same order: IEEE 754 fixes ``+ - * /`` and the square root to the
last bit, without fast-math nothing is contracted or reordered, and the other functions are the C library's, as in
Python. What raises in Python raises here too, at the end of the function instead of on the way.
"""

from __future__ import annotations

import ctypes
import math
import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Symbol, Tape

in_use = False
"""Whether ``function_of`` gives machine code in this process."""

_OPERATORS = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_FUNCTIONS = {
    "sqrt": "llvm.sqrt.f64", "abs": "llvm.fabs.f64", "sin": "sin", "cos": "cos", "atan2": "atan2",
    "remainder": "remainder",
}  # fmt: skip
"""LLVM's own, or the C library's."""
_DECLARED = "".join(
    f"declare double @{name}({'double, double' if name in ('atan2', 'remainder') else 'double'})\n"
    for name in _FUNCTIONS.values()
)
_COMPARISONS = {"minimum": "olt", "maximum": "ogt"}
"""As in Python min(a, b) is b where b < a, else a."""
_compilers: list[Any] = []  # who own the code; it is never given back


def use() -> bool:
    """Have ``function_of`` give machine code in this process from now on. False: llvmlite is not installed."""
    global in_use
    if not in_use:
        try:
            import llvmlite.binding as llvm
        except ImportError:
            return False
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        in_use = True
    return in_use


def function_of(tape: Tape, name: str, outputs: Sequence[Scalar]) -> Function:
    """``tape.function``, as machine code where that is in use and can be."""
    text = assembly(tape, outputs) if in_use else None
    return tape.function(name, outputs) if text is None else compiled(text, tape.arity, len(outputs))


def assembly(tape: Tape, outputs: Sequence[Scalar]) -> str | None:
    """The function in LLVM's language: from an array of inputs to one of outputs. It returns whether Python would have
    raised. None: it uses a function that is not known here."""
    lines = ["%raised0 = or i1 false, false"]
    raised = 0
    values: dict[int, str] = {}

    def operand(scalar: Scalar) -> str:
        return values[scalar.index] if isinstance(scalar, Symbol) else _constant(scalar)

    for symbol in tape.needed(outputs):
        k, operation = symbol.index, symbol.operation
        own = values[k] = f"%v{k}"
        if operation == "input":
            lines += [f"%at{k} = getelementptr double, ptr %given, i64 {tape.place(symbol)}"]
            lines += [f"{own} = load double, ptr %at{k}"]
            continue
        arguments = [operand(argument) for argument in symbol.arguments]
        a, b = arguments[0], arguments[-1]
        doubt = ""
        if operation in _OPERATORS:
            lines.append(f"{own} = {_OPERATORS[operation]} double {a}, {b}")
            doubt = f"fcmp oeq double {b}, 0.0" if operation == "div" else ""
        elif operation == "neg":
            lines.append(f"{own} = fneg double {a}")
        elif operation in _COMPARISONS:
            lines.append(f"%is{k} = fcmp {_COMPARISONS[operation]} double {b}, {a}")
            lines.append(f"{own} = select i1 %is{k}, double {b}, double {a}")
        elif operation in _FUNCTIONS:
            lines.append(f"{own} = call double @{_FUNCTIONS[operation]}({', '.join(f'double {x}' for x in arguments)})")
            lines += [f"%known{k} = fcmp ord double {a}, {b}", f"%nan{k} = fcmp uno double {own}, {own}"]
            doubt = f"and i1 %known{k}, %nan{k}"
        else:
            return None
        if doubt:
            lines += [f"%doubt{k} = {doubt}", f"%raised{raised + 1} = or i1 %raised{raised}, %doubt{k}"]
            raised += 1
    for at, output in enumerate(outputs):
        lines.append(f"%to{at} = getelementptr double, ptr %made, i64 {at}")
        lines.append(f"store double {operand(output)}, ptr %to{at}")
    lines += [f"%result = zext i1 %raised{raised} to i32", "ret i32 %result"]
    return "\n".join([_DECLARED + "define i32 @function(ptr %given, ptr noalias %made) {", *lines, "}"])


@lru_cache(maxsize=256)
def compiled(text: str, arity: int, count: int) -> Function:
    """What ``assembly`` wrote, to be called with ``arity`` floats; it returns ``count``. ArithmeticError: Python would
    have raised one, or a ValueError."""
    import llvmlite.binding as llvm

    # opt=0: made in a quarter of the time, and nearly as quick, for there is nothing to find in straight lines
    machine = llvm.Target.from_default_triple().create_target_machine(opt=0)
    compiler = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    compiler.finalize_object()
    _compilers.append(compiler)
    # PYFUNCTYPE keeps Python's lock: it is over sooner than the lock could change hands
    run = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p)(compiler.get_function_address("function"))
    pack, unpack = struct.Struct(f"{arity}d").pack, struct.Struct(f"{count}d").unpack
    room = ctypes.c_char * (8 * count)

    def function(*inputs: float) -> tuple[float, ...]:
        made = room()
        if run(pack(*inputs), made):
            raise ZeroDivisionError("division by zero, or a function outside its domain")
        return unpack(made)

    return function


def _constant(value: float) -> str:
    """A float as LLVM reads it: its bits."""
    if not math.isfinite(value):
        raise OverflowError("a constant of the expression is not finite")
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
