"""Files that others read while we write: whole or not at all, new or not at all."""

from __future__ import annotations

import contextlib
import itertools
import os
from pathlib import Path

from companion.record.growing import MODE, NEW_FILE

_NUMBERS = itertools.count()


def write_whole(path: Path, text: str, *, durable: bool = True) -> None:
    """Write a file that is never seen half written; with ``durable`` not even after a power cut. OSError: nothing is
    changed."""
    part = path.with_name(f".{path.name[:100]}.{os.getpid()}-{next(_NUMBERS)}.part")
    descriptor = os.open(part, NEW_FILE, MODE)
    try:
        try:
            with open(descriptor, "w", encoding="utf-8", closefd=False) as file:
                file.write(text)
            if durable:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)
        os.replace(part, path)
    except OSError:
        with contextlib.suppress(OSError):
            part.unlink()
        raise
    if durable:
        sync_directory(path.parent)


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet. FileExistsError: it is. Other OSErrors: nothing is left of it."""
    descriptor = os.open(path, NEW_FILE, MODE)
    try:
        with open(descriptor, "w", encoding="utf-8", closefd=False) as file:
            file.write(text)
        os.fsync(descriptor)
    except OSError:
        path.unlink()
        raise
    finally:
        os.close(descriptor)


def sync_directory(path: Path) -> None:
    """Have the names in a directory reach the disk. A file system that cannot is none of our business."""
    with contextlib.suppress(OSError):
        descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
