"""The true state of every step in a NumPy file that can be read at any time, even if the plant was killed.

The rows go out in blocks; after each block the header is rewritten with their number. ``numpy.load`` reads it.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from sim_bridge.plant import Truth
from sim_bridge.rotors import Four

COLUMNS = (("t_boot", 1), ("p_n", 3), ("v_n", 3), ("q_nb", 4), ("w_b", 3), ("rotor_thrusts", 4), ("commands", 4))
"""Name and width: s, m, m/s, body to world, rad/s, N, the rotors' own units."""
HEADER_SIZE = 512
"""bytes: room for the number of rows to grow in."""
BLOCK = 250
"""rows written at once: a second's."""
DTYPE = np.dtype([(name, "<f8") if width == 1 else (name, "<f8", (width,)) for name, width in COLUMNS])
"""The layout of a row."""
_ROW = struct.Struct(f"<{sum(width for _, width in COLUMNS)}d")


def header(rows: int) -> bytes:
    """The header of a file with ``rows`` rows, always HEADER_SIZE bytes (NumPy format 1.0)."""
    text = f"{{'descr': {DTYPE.descr}, 'fortran_order': False, 'shape': ({rows},), }}"
    start = b"\x93NUMPY\x01\x00" + struct.pack("<H", HEADER_SIZE - 10)
    return start + text.ljust(HEADER_SIZE - 11).encode("ascii") + b"\n"


def row(truth: Truth, commands: Four) -> bytes:
    """The state after a step and the commands that led to it."""
    t_boot, p_n, v_n, _, q_nb, w_b, rotor_thrusts, _ = truth
    return _ROW.pack(t_boot, *p_n, *v_n, *q_nb, *w_b, *rotor_thrusts, *commands)


class TruthRows:
    """The same in memory, as ``table``."""

    def __init__(self) -> None:
        self._rows: list[bytes] = []
        self._last = -1.0

    def append(self, truth: Truth, commands: Four) -> None:
        """See TruthFile."""
        if truth.t_boot != self._last:
            self._last = truth.t_boot
            self._rows.append(row(truth, commands))

    @property
    def table(self) -> NDArray[np.void]:
        """The rows so far, as in the file."""
        return np.frombuffer(b"".join(self._rows), DTYPE)


class TruthFile:
    """Writes one. A context manager; OSError where the file cannot be made.

    A disk that is full or gone later is no reason for a vehicle to stop flying: then the file ends, whole as it is.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self._rows = 0
        self._block: list[bytes] = []
        self._last = -1.0
        self.ended = False
        self._write(0, header(0))

    def append(self, truth: Truth, commands: Four) -> None:
        """The state after a step and the commands that led to it. Nothing is added while the vehicle's clock stands."""
        if truth.t_boot == self._last or self.ended:
            return
        self._last = truth.t_boot
        self._block.append(row(truth, commands))
        if len(self._block) >= BLOCK:
            self.flush()

    def flush(self) -> None:
        """Bring everything to the file: the rows first, then the header that counts them."""
        self._write(HEADER_SIZE + self._rows * _ROW.size, b"".join(self._block))
        if not self.ended:
            self._rows += len(self._block)
            self._write(0, header(self._rows))
        self._block.clear()

    def close(self) -> None:
        """Write what is left and close."""
        self.flush()
        self._file.close()

    def _write(self, at: int, data: bytes) -> None:
        try:
            while data and not self.ended:
                count = os.pwrite(self._file.fileno(), data, at)
                at, data = at + count, data[count:]
        except OSError:
            self.ended = True

    def __enter__(self) -> TruthFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
