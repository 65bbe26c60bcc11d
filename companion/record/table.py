"""The flight as one columnar table, ``flight.npy``: what the pilot saw at each tick and what it did.

A numpy structured array, so ``numpy.load("flight.npy")["path_error"]`` and ``pandas.DataFrame(numpy.load(...))`` work.
It is written as the flight goes on, with a valid header at every moment; ``read_table`` reads one cut anywhere.
"""

from __future__ import annotations

import math
import os
import struct
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from companion.record.growing import GrowingFile

Row = tuple[Any, ...]
Table = NDArray[np.void]

ROWS_WAITING = 20_000
"""Rows that wait for the disk at most: 80 s at 250 Hz in 10 MB (engineering choice)."""
FLOAT32_MAX = float(np.finfo(np.float32).max)
_RANGES = {"i": (-(2**31), 2**31 - 1), "b": (-128, 127)}
"""The whole numbers each code holds."""


class Column(NamedTuple):
    """A quantity: its name, its struct code, what it means."""

    name: str
    code: str
    meaning: str


class RowPacker:
    """Rows of ``columns`` as bytes, of the layout ``dtype``."""

    def __init__(self, columns: tuple[Column, ...]) -> None:
        self.dtype = dtype_of(columns)
        self._codes = [column.code for column in columns]
        self._struct = struct.Struct("<" + "".join(self._codes))

    def pack(self, row: Row) -> bytes:
        """A row. What does not go into its column (a number too large for 32 bits) is brought to its limit."""
        try:
            return self._struct.pack(*row)
        except (struct.error, OverflowError):
            return self._struct.pack(*(_clamped(value, code) for value, code in zip(row, self._codes, strict=True)))


class TableWriter(GrowingFile):
    """Appends rows to a .npy file. ``columns`` fix the layout.

    The header counts the rows that are on the disk for certain: it is written anew only behind a sync. ``read_table``
    also finds the rows behind that count. The table has no holes, because a replay stands on that: once a row was lost
    it has ended.
    """

    def __init__(self, path: Path, columns: tuple[Column, ...]) -> None:
        self._packer = RowPacker(columns)
        self.dtype = self._packer.dtype
        head = header(self.dtype, 0)
        self._start = len(head)
        self._counted = 0
        super().__init__(path, ROWS_WAITING, head)

    def row(self, row: Row) -> None:
        """Take a row."""
        whole = self._packer.pack(row)
        if self.lost:
            self.lost += 1
        else:
            self.append(whole)

    def sync(self) -> None:
        """See GrowingFile; then a header that counts what is there."""
        super().sync()
        self.count()

    def count(self) -> None:
        """Have the header count the rows that are in the file."""
        rows = max(0, self.written - self._start) // self.dtype.itemsize
        if self.descriptor is not None and rows != self._counted:
            os.pwrite(self.descriptor, header(self.dtype, rows), 0)
            self._counted = rows

    @property
    def missing(self) -> int:
        """Rows that were taken and are not in the file."""
        return self.lost + self.waiting

    def table(self) -> Table:
        """Everything that was taken so far and not lost, in the file or still waiting for it."""
        waiting = np.frombuffer(self._whole(self.unwritten[max(0, self._start - self.written) :]), self.dtype)
        if self.descriptor is None or self.written <= self._start:
            return waiting
        whole = (self.written - self._start) // self.dtype.itemsize
        with open(self.descriptor, "rb", closefd=False) as file:
            rows = map_rows(file, self._start, whole, self.dtype)
        return rows if not len(waiting) else np.concatenate([rows, waiting])

    def _whole(self, unwritten: bytes) -> bytes:
        """Rows of bytes that wait, without the first one where a part of it is in the file."""
        size = self.dtype.itemsize
        begun = max(0, self.written - self._start) % size
        rest = unwritten[size - begun :] if begun else unwritten
        return rest[: len(rest) // size * size]


def header(dtype: np.dtype[np.void], rows: int) -> bytes:
    """Of a .npy file (version 2.0) of ``rows`` rows: its magic, its length, a dict as text, padded so that any count
    fits in its place."""
    text = f"{{'descr': {dtype.descr!r}, 'fortran_order': False, 'shape': ({rows:>12d},), }}"
    size = -(-(12 + len(text) + 1) // 64) * 64
    padded = text.ljust(size - 13).encode("latin-1") + b"\n"
    return b"\x93NUMPY\x02\x00" + struct.pack("<I", len(padded)) + padded


def dtype_of(columns: tuple[Column, ...]) -> np.dtype[np.void]:
    """The numpy layout of rows packed without gaps."""
    return np.dtype(
        [(column.name, "<" + {"d": "f8", "f": "f4", "i": "i4", "b": "i1"}[column.code]) for column in columns]
    )


class ReadTable(NamedTuple):
    """A table as far as it can be read. ``cut``: in words, where it does not end as a finished flight's does."""

    rows: Table
    cut: str | None


def read_table(path: Path, columns: tuple[Column, ...] | None = None) -> ReadTable:
    """The table of a flight, up to where its file was cut. ``columns``: what it holds, where its header was cut too.

    OSError, ValueError: it cannot be read or is not a table.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        try:
            dtype, clock, counted = _read_header(file)
        except ValueError:
            expected = b"" if columns is None else header(dtype_of(columns), 0)
            with path.open("rb") as again:
                if columns is None or size >= len(expected) or not expected.startswith(again.read()[:8]):
                    raise
            return ReadTable(
                np.zeros(0, dtype_of(columns)), f"{path.name} is cut within its header: no row of it is left"
            )
        start = file.tell()
        rows = map_rows(file, start, (size - start) // dtype.itemsize, dtype)
    if len(rows) > counted:
        rows = rows[: counted + _unbroken(rows[clock], counted)]
    if start + counted * dtype.itemsize == size:
        return ReadTable(rows, None)
    return ReadTable(rows, f"{path.name} was cut short; {len(rows)} whole rows of it are read")


def load_table(path: Path) -> Table:
    """The rows of ``read_table``."""
    return read_table(path).rows


def map_rows(file: BinaryIO, start: int, count: int, dtype: np.dtype[np.void]) -> Table:
    """``count`` rows of an open file from byte ``start`` on, read from the disk as they are used."""
    if count <= 0:
        return np.zeros(0, dtype)
    return np.asarray(np.memmap(file, dtype, "r", start, (count,)))


def _read_header(file: BinaryIO) -> tuple[np.dtype[np.void], str, int]:
    """The layout, the name of its first column, which is a clock, and how many rows it counts."""
    version = npy.read_magic(file)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read(file)
    if dtype.names is None or len(shape) != 1:
        raise ValueError("it has no named columns")
    return dtype, dtype.names[0], shape[0]


def _unbroken(clock: NDArray[np.float64], counted: int) -> int:
    """How many rows behind the ``counted`` ones are rows: after a power cut a block may be there and hold nothing."""
    before = clock[counted - 1] if counted else 0.0
    late = clock[counted:]
    holds = (late > 0.0) & (late >= np.concatenate(([before], late[:-1])))
    return len(late) if np.all(holds) else int(np.argmin(holds))


def _clamped(value: Any, code: str) -> Any:
    if code == "f" and abs(value) > FLOAT32_MAX:
        return math.copysign(math.inf, value)
    if code in _RANGES:
        low, high = _RANGES[code]
        return min(max(int(value), low), high)
    return value
