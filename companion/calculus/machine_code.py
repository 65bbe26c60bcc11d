"""A recorded function as machine code, by LLVM: the same floats, bit for bit, in a sixth of the time.

For processes that fly hundreds of times (a study's workers, which call ``use``): LLVM takes its time for each function,
and a real flight is not to hang on it. Where llvmlite is not installed (extra ``study``) everything stays Python.

Bit for bit, because it is the same operations in the same order: IEEE 754 fixes ``+ - * /`` and the square root to the
last bit, without fast-math nothing is contracted or reordered, and the other functions are the C library's, as in
Python. What raises in Python raises here too, at the end of the function instead of on the way.

Python calls what is compiled as it calls its own built-in functions: the code takes the floats out of their objects
itself and makes new ones, which costs a tenth of packing them for a foreign function.
"""

from __future__ import annotations

import ctypes
import math
import struct
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Outputs, Packed, Symbol, Tape

in_use = False
"""Whether ``function_of`` gives machine code in this process."""

PackedNumbers = tuple[float, ...] | bytes
"""Numbers that only recorded functions read: as machine code these keep them as bytes, a fifth of the memory."""
_OPERATORS = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_FUNCTIONS = {
    "sqrt": "llvm.sqrt.f64", "abs": "llvm.fabs.f64", "sin": "sin", "cos": "cos", "atan2": "atan2",
    "remainder": "remainder", "power": "pow",
}  # fmt: skip
"""LLVM's own, or the C library's."""
_OF_TWO = ("atan2", "remainder", "pow")
_COMPARISONS = {"minimum": "olt", "maximum": "ogt"}
"""As in Python min(a, b) is b where b < a, else a."""
_DECLARED = """\
@PyExc_TypeError = external global ptr
@PyExc_ZeroDivisionError = external global ptr
@arity = constant [28 x i8] c"another number of arguments\\00"
@domain = constant [51 x i8] c"division by zero, or a function outside its domain\\00"
declare double @PyFloat_AsDouble(ptr)
declare ptr @PyFloat_FromDouble(double)
declare ptr @PyTuple_New(i64)
declare i64 @PyTuple_Size(ptr)
declare ptr @PyBytes_FromStringAndSize(ptr, i64)
declare ptr @PyBytes_AsString(ptr)
declare i64 @PyBytes_Size(ptr)
declare ptr @PyErr_Occurred()
declare void @PyErr_SetString(ptr, ptr)
""" + "".join(
    f"declare double @{name}({'double, double' if name in _OF_TWO else 'double'})\n" for name in _FUNCTIONS.values()
)
"""What is used of Python's C interface and of the C library."""
_FAILED = """\
miscalled:
  %type_error = load ptr, ptr @PyExc_TypeError
  call void @PyErr_SetString(ptr %type_error, ptr @arity)
  ret ptr null
raised:
  %zero_division = load ptr, ptr @PyExc_ZeroDivisionError
  call void @PyErr_SetString(ptr %zero_division, ptr @domain)
  ret ptr null
unread:
  ret ptr null
}
"""
"""Where a call ends that gives nothing but an exception."""
_DOUBLE = 8
"""bytes of a float."""
_METH_FASTCALL = 0x0080
"""Python's flag of a function that is given a C array of its arguments, and their number."""
_owners: list[Any] = []  # of the code; it is never given back


class _MethodDef(ctypes.Structure):
    """Python's PyMethodDef."""

    _fields_ = (("name", ctypes.c_char_p), ("call", ctypes.c_void_p), ("flags", ctypes.c_int), ("doc", ctypes.c_char_p))


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


def packed(numbers: Sequence[float]) -> PackedNumbers:
    """Numbers as a function takes and gives them that says ``Packed``."""
    return struct.pack(f"{len(numbers)}d", *numbers) if in_use else tuple(numbers)


def unpacked(numbers: PackedNumbers) -> tuple[float, ...]:
    """What was ``packed``."""
    return struct.unpack(f"{len(numbers) // _DOUBLE}d", numbers) if isinstance(numbers, bytes) else numbers


def function_of(tape: Tape, name: str, outputs: Outputs) -> Function:
    """``tape.function``, as machine code where that is in use and can be."""
    text = assembly(tape, outputs) if in_use else None
    return tape.function(name, outputs) if text is None else compiled(text)


def assembly(tape: Tape, outputs: Outputs) -> str | None:
    """The function in LLVM's language, as Python calls its own: it returns a tuple, or none after it has set an
    exception. None: it uses a function that is not known here."""
    inputs = _inputs(tape)
    lines, values, doubts = list[str](), dict[int, str](), list[str]()

    def operand(scalar: Scalar) -> str:
        return values[scalar.index] if isinstance(scalar, Symbol) else _constant(scalar)

    for symbol in tape.needed(outputs):
        k, operation = symbol.index, symbol.operation
        own = values[k] = f"%v{k}"
        if operation == "input":
            lines += _read(k, *inputs[symbol.arguments[0]])
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
            made = own
            if operation == "power":  # raises where finite numbers have no finite power: their differences are no nan
                lines += [f"%less{i}_{k} = fsub double {x}, {x}" for i, x in enumerate((a, b, own))]
                a, b, made = (f"%less{i}_{k}" for i in range(3))
            lines += [f"%known{k} = fcmp ord double {a}, {b}", f"%nan{k} = fcmp uno double {made}, {made}"]
            doubt = f"and i1 %known{k}, %nan{k}"
        else:
            return None
        if doubt:
            lines += [f"%doubt{k} = {doubt}", f"%doubted{k} = or i1 {(doubts or ['false'])[-1]}, %doubt{k}"]
            doubts.append(f"%doubted{k}")
    lines += ["%error = call ptr @PyErr_Occurred()", "%is_read = icmp eq ptr %error, null"]
    lines += ["br i1 %is_read, label %judge, label %unread", "judge:"]
    lines += [f"br i1 {(doubts or ['false'])[-1]}, label %raised, label %answer", "answer:"]
    lines += [*_made(outputs, "%made", operand), "ret ptr %made"]
    return "\n".join([_DECLARED, *_begun(tape), *lines, _FAILED])


def _made(output: Scalar | Sequence[Scalar], name: str, operand: Callable[[Scalar], str]) -> list[str]:
    """The object of an output under a ``name``. ``operand``: what stands for a number."""
    if isinstance(output, Packed):
        lines = [f"{name} = call ptr @PyBytes_FromStringAndSize(ptr null, i64 {_DOUBLE * len(output)})"]
        lines += [f"{name}_data = call ptr @PyBytes_AsString(ptr {name})"]
        for at, item in enumerate(output):
            lines += [f"{name}_{at} = getelementptr double, ptr {name}_data, i64 {at}"]
            lines += [f"store double {operand(item)}, ptr {name}_{at}"]
        return lines
    if isinstance(output, Sequence):
        lines = [f"{name} = call ptr @PyTuple_New(i64 {len(output)})"]
        for at, item in enumerate(output):
            made = f"{name}_{at}"
            lines += [*_made(item, made, operand), f"{made}_place = {_item(name, at)}"]
            lines += [f"store ptr {made}, ptr {made}_place"]
        return lines
    return [f"{name} = call ptr @PyFloat_FromDouble(double {operand(output)})"]


def _begun(tape: Tape) -> list[str]:
    """The beginning of the function: whether it is given what it takes."""
    lines = ["define ptr @function(ptr %self, ptr %given, i64 %count) {"]
    lines += [f"%fits = icmp eq i64 %count, {len(tape.arguments)}"]
    lines += ["br i1 %fits, label %open, label %miscalled", "open:"]
    fits = "true"
    for at, names in enumerate(tape.arguments):
        if isinstance(names, tuple):
            lines += [f"%place{at} = getelementptr ptr, ptr %given, i64 {at}", f"%tuple{at} = load ptr, ptr %place{at}"]
            if isinstance(names, Packed):
                lines += [f"%data{at} = call ptr @PyBytes_AsString(ptr %tuple{at})"]
                lines += [f"%bytes{at} = call i64 @PyBytes_Size(ptr %tuple{at})"]
                lines += [f"%size{at} = sdiv i64 %bytes{at}, {_DOUBLE}"]
            else:
                lines += [f"%size{at} = call i64 @PyTuple_Size(ptr %tuple{at})"]
            lines += [f"%has{at} = icmp eq i64 %size{at}, {len(names)}", f"%fits{at} = and i1 {fits}, %has{at}"]
            fits = f"%fits{at}"
    return [*lines, f"br i1 {fits}, label %compute, label %miscalled", "compute:"]


def _inputs(tape: Tape) -> dict[str, tuple[str, bool]]:
    """Where each input is: among the arguments, or among the items of one; and whether it is a packed number."""
    places = dict[str, tuple[str, bool]]()
    for at, given in enumerate(tape.arguments):
        if isinstance(given, str):
            places[given] = f"getelementptr ptr, ptr %given, i64 {at}", False
            continue
        is_packed = isinstance(given, Packed)
        for item, name in enumerate(given):
            place = f"getelementptr double, ptr %data{at}, i64 {item}" if is_packed else _item(f"%tuple{at}", item)
            places[name] = place, is_packed
    return places


def _read(k: int, place: str, is_packed: bool) -> list[str]:
    """An input as a float."""
    at = f"%at{k} = {place}"
    if is_packed:
        return [at, f"%v{k} = load double, ptr %at{k}"]
    return [at, f"%object{k} = load ptr, ptr %at{k}", f"%v{k} = call double @PyFloat_AsDouble(ptr %object{k})"]


def _item(of: str, at: int) -> str:
    """Where an item of a tuple is."""
    return f"getelementptr i8, ptr {of}, i64 {tuple.__basicsize__ + at * tuple.__itemsize__}"


@lru_cache(maxsize=256)
def compiled(text: str) -> Function:
    """What ``assembly`` wrote, to be called. ArithmeticError: Python would have raised one, or a ValueError."""
    import llvmlite.binding as llvm

    # opt=0: made in a quarter of the time, and nearly as quick, for there is nothing to find in straight lines
    machine = llvm.Target.from_default_triple().create_target_machine(opt=0)
    compiler = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    compiler.finalize_object()
    definition = _MethodDef(b"function", compiler.get_function_address("function"), _METH_FASTCALL, None)
    _owners.append((compiler, definition))
    made = ctypes.pythonapi.PyCFunction_NewEx
    made.restype, made.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
    function: Function = made(ctypes.addressof(definition), None, None)
    return function


def _constant(value: float) -> str:
    """A float as LLVM reads it: its bits."""
    if not math.isfinite(value):
        raise OverflowError("a constant of the expression is not finite")
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
