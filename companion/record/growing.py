"""A file that grows while a flight goes on: one thread appends to memory and never waits, another writes and syncs.

A disk that is full, slow or gone costs the file, never the flight: what waits to be written is bounded, and what does
not fit is counted. Writing is tried again each time, and goes on at the very byte where it stopped.
"""

from __future__ import annotations

import os
from collections import deque
from pathlib import Path

NEW_FILE = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
"""A file of ours is a new one: never somebody else's, never through a symbolic link."""
MODE = 0o644
"""Permissions of a new file: others read."""


class GrowingFile:
    """``path``: made with the first ``write``. ``limit``: pieces that wait at most. ``head``: bytes at its beginning.

    ``lost``: pieces that found no room to wait in.
    """

    def __init__(self, path: Path, limit: int, head: bytes = b"") -> None:
        self.path = path
        self.lost = 0
        self._limit = limit
        self._waiting: deque[bytes] = deque()
        self._backlog = head  # taken from the queue, not yet in the file
        self._taken = 0  # pieces in the backlog
        self._end = 0
        self._descriptor: int | None = None
        self._synced = 0
        self._closed = False

    def append(self, piece: bytes) -> None:
        """Take a piece; it reaches the file with the next ``write``. Never waits, never fails."""
        if len(self._waiting) >= self._limit:
            self.lost += 1
        else:
            self._waiting.append(piece)

    def write(self) -> None:
        """Write what waits. OSError: not all of it could be written; the rest goes on waiting."""
        if self._closed:
            return
        if self._descriptor is None:
            self._descriptor = os.open(self.path, NEW_FILE, MODE)
        self._write_backlog(self._descriptor)
        self._taken = len(self._waiting)
        self._backlog = b"".join(self._waiting.popleft() for _ in range(self._taken))
        self._write_backlog(self._descriptor)

    def sync(self) -> None:
        """Have what was written reach the disk itself, as a power cut asks for. OSError: it did not."""
        if self._descriptor is not None and self._synced != self._end:
            os.fdatasync(self._descriptor)
            self._synced = self._end

    def close(self) -> None:
        """Write, sync, close. OSError: not all of it could be written; it is closed all the same."""
        if self._closed:
            return
        try:
            self.write()
            self.sync()
        finally:
            self._closed = True
            if self._descriptor is not None:
                os.close(self._descriptor)
                self._descriptor = None

    @property
    def waiting(self) -> int:
        """Pieces that are not (or not wholly) in the file."""
        return self._taken + len(self._waiting)

    @property
    def written(self) -> int:
        """Bytes in the file."""
        return self._end

    @property
    def unwritten(self) -> bytes:
        """What still waits."""
        return self._backlog + b"".join(self._waiting)

    @property
    def descriptor(self) -> int | None:
        """The open file; None before the first ``write`` and after ``close``."""
        return self._descriptor

    @property
    def is_gone(self) -> bool:
        """Whether somebody deleted the file while it was open."""
        return self._descriptor is not None and os.fstat(self._descriptor).st_nlink == 0

    def _write_backlog(self, descriptor: int) -> None:
        while self._backlog:
            count = os.pwrite(descriptor, self._backlog, self._end)
            self._end += count
            self._backlog = self._backlog[count:]
        self._taken = 0
