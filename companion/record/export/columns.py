"""Columns of a recorded table as text, a line a row: their units, and their numbers with enough digits and no NaN.

A flight of five minutes has millions of numbers. A line is made by one template for all of its numbers, and a column
that seldom changes is made into text once a change.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[Any]

UNITS = frozenset({"m", "m/s", "m/s^2", "rad", "rad/s", "s", "Hz", "N", "N/s", "1/s"})
DIGITS = 9
"""Significant digits: a millimetre in 100 km, a microsecond in 1000 s (engineering choice)."""
CLOCK_DECIMALS = 6
"""Of a time in s: microseconds."""
CLOCKS = frozenset({"now", "t_boot"})
"""Columns that are times of a clock."""
SELDOM = 0.1
"""Share of the rows at which a column changes, up to which its text is kept until it does. Engineering choice."""


def unit_of(meaning: str) -> str:
    """The unit that a column's meaning begins with ("m/s, velocity", "Hz of states"); empty where it has none."""
    first = meaning.partition(" ")[0].rstrip(",")
    return first if first in UNITS else ""


def as_csv(names: Sequence[str], columns: Sequence[Numbers]) -> bytes:
    """A table with the names of its columns; times of a clock have microseconds."""
    parts = ["", *[","] * (len(columns) - 1), ""]
    clocks = frozenset(i for i, name in enumerate(names) if name in CLOCKS)
    return b"\n".join([",".join(names).encode(), *as_lines(parts, columns, "", clocks), b""])


def as_lines(
    parts: Sequence[str], columns: Sequence[Numbers], missing: str, clocks: frozenset[int] = frozenset()
) -> list[bytes]:
    """A line a row: ``parts`` with a number of each of ``columns`` between them, ``missing`` where it is not finite.
    ``clocks``: which of the columns are times of a clock, in s."""
    between, nothing = [part.encode() for part in parts], missing.encode()
    codes = [_code(values, i in clocks) for i, values in enumerate(columns)]
    template, cells = [_escaped(between[0])], []
    finite = np.ones(len(columns[0]), dtype=bool)
    changes = [_changes(values) for values in columns]
    limit = SELDOM * len(columns[0])
    for seldom, group in groupby(range(len(columns)), lambda i: np.count_nonzero(changes[i]) <= limit):
        of = list(group)
        if seldom:
            template.append(b"%b" + _escaped(between[of[-1] + 1]))
            texts = [_texts(columns[i], changes[i], codes[i], nothing) for i in of]
            cells.append(_joined(between[of[0] + 1 : of[-1] + 1], texts, [changes[i] for i in of]))
            continue
        template += [codes[i] + _escaped(between[i + 1]) for i in of]
        cells += [columns[i].tolist() for i in of]
        finite &= np.logical_and.reduce([np.isfinite(columns[i]) for i in of])
    whole = b"".join(template)
    lines = [whole % row for row in zip(*cells, strict=True)]
    parted = b"".join(_escaped(part) + b"%b" for part in between[:-1]) + _escaped(between[-1])
    rows = np.flatnonzero(~finite)
    numbers = zip(*(values[rows].tolist() for values in columns), strict=True)
    for row, its in zip(rows.tolist(), numbers, strict=True):
        lines[row] = parted % tuple(_text(value, code, nothing) for value, code in zip(its, codes, strict=True))
    return lines


def _code(values: Numbers, clock: bool) -> bytes:
    """How a number of a column is written."""
    if values.dtype.kind in "iu":
        return b"%d"
    return b"%%.%df" % CLOCK_DECIMALS if clock else b"%%.%dg" % DIGITS


def _escaped(part: bytes) -> bytes:
    return part.replace(b"%", b"%%")


def _text(value: float, code: bytes, missing: bytes) -> bytes:
    return code % value if math.isfinite(value) else missing


def _changes(values: Numbers) -> NDArray[np.bool_]:
    """Where a value is another one than that before it, the first included; NaN is NaN."""
    before, after = values[:-1], values[1:]
    changed = np.ones(len(values), dtype=bool)
    changed[1:] = (before != after) & ((before == before) | (after == after))
    return changed


def _texts(values: Numbers, changed: NDArray[np.bool_], code: bytes, missing: bytes) -> NDArray[np.object_]:
    """The text of each row of a column, made where it ``changed``."""
    new = [_text(value, code, missing) for value in values[changed].tolist()]
    return _repeated(new, changed)


def _joined(
    between: Sequence[bytes], texts: Sequence[NDArray[np.object_]], changes: Sequence[NDArray[np.bool_]]
) -> list[bytes]:
    """The text of each row of columns that stand side by side. ``between``: what parts them."""
    changed = np.logical_or.reduce(changes)
    template = b"%b" + b"".join(_escaped(part) + b"%b" for part in between)
    new = [template % row for row in zip(*(text[changed].tolist() for text in texts), strict=True)]
    found: list[bytes] = _repeated(new, changed).tolist()
    return found


def _repeated(texts: Sequence[bytes], changed: NDArray[np.bool_]) -> NDArray[np.object_]:
    """What stands at the rows that ``changed``, at every row."""
    return np.repeat(np.array(texts, dtype=object), np.diff(np.flatnonzero(changed), append=len(changed)))
