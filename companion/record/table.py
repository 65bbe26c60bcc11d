"""The flight as one columnar table, ``flight.npy``: what the pilot saw at each tick and what it did.

A numpy structured array, so ``numpy.load("flight.npy")["path_error"]`` and ``pandas.DataFrame(numpy.load(...))`` work.
It is written as the flight goes on, with a valid header at every moment: a killed flight leaves a readable file.
"""

from __future__ import annotations

import struct
from collections import deque
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

Row = tuple[Any, ...]
Table = NDArray[np.void]


class Column(NamedTuple):
    """A quantity: its name, its struct code, what it means."""

    name: str
    code: str
    meaning: str


class TableWriter:
    """Appends rows to a .npy file. ``columns`` fix the layout."""

    def __init__(self, path: Path, columns: tuple[Column, ...]) -> None:
        self._packer = struct.Struct("<" + "".join(column.code for column in columns))
        self._dtype = dtype_of(columns)
        self._file: BinaryIO = path.open("wb")
        self._rows = 0
        self._pending: deque[bytes] = deque()
        self._header()

    def append(self, row: Row) -> None:
        """Take a row; it reaches the file with the next ``flush``, which another thread may call."""
        self._pending.append(self._packer.pack(*row))

    def flush(self) -> None:
        """Write what was appended, and a header that counts it."""
        waiting = len(self._pending)
        self._file.seek(0, 2)
        self._file.write(b"".join(self._pending.popleft() for _ in range(waiting)))
        self._rows += waiting
        self._header()
        self._file.flush()

    def close(self) -> None:
        """Flush and close."""
        self.flush()
        self._file.close()

    def _header(self) -> None:
        # the .npy format: magic, version, length, a dict as text; padded so that any row count fits in its place
        text = f"{{'descr': {self._dtype.descr!r}, 'fortran_order': False, 'shape': ({self._rows:>12d},), }}"
        size = -(-(12 + len(text) + 1) // 64) * 64
        header = text.ljust(size - 13).encode("latin-1") + b"\n"
        self._file.seek(0)
        self._file.write(b"\x93NUMPY\x02\x00" + struct.pack("<I", len(header)) + header)


def dtype_of(columns: tuple[Column, ...]) -> np.dtype[np.void]:
    """The numpy layout of rows packed without gaps."""
    return np.dtype(
        [(column.name, "<" + {"d": "f8", "f": "f4", "i": "i4", "b": "i1"}[column.code]) for column in columns]
    )


def load_table(path: Path) -> Table:
    """The table of a flight. OSError, ValueError: it cannot be read or is not a table."""
    table = np.load(path, allow_pickle=False)
    if table.dtype.names is None:
        raise ValueError(f"{path} has no named columns")
    return np.asarray(table)
