"""The place of a flight folder: new or empty, and only what was made there is removed."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import time
from pathlib import Path

from companion.config.syntax.faults import ConfigError, Fault

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""The disk is full, a quota is used up, a file may not grow: no mistake of the person who started the flight."""


class Place:
    """A directory and what was made there. ``make`` first."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self._directories: list[Path] = []
        self._files: list[Path] = []

    def make(self) -> None:
        """Make the directory, and those above it. ConfigError: it is not empty. OSError: see ``judge``."""
        missing = [path for path in (self.directory, *self.directory.parents) if not path.exists()]
        for path in reversed(missing):
            with contextlib.suppress(FileExistsError):  # somebody made it meanwhile: not ours to remove
                path.mkdir()
                self._directories.insert(0, path)
        refuse_used(self.directory)

    def mine(self, name: str) -> Path:
        """The path of a file that is about to be made here."""
        path = self.directory / name
        if path not in self._files and not path.exists():
            self._files.append(path)
        return path

    def judge(self, error: OSError) -> None:
        """ConfigError, unless the flight may be flown without a record: only a full disk is nobody's mistake."""
        if error.errno not in FULL:
            self.unmake()
            raise fault(self.directory, _complaint(error)) from None

    def unmake(self) -> None:
        """Remove the files that were made here, and the directories if nothing else is in them."""
        for path in self._files:
            with contextlib.suppress(OSError):
                path.unlink()
        for path in self._directories:
            with contextlib.suppress(OSError):
                path.rmdir()


def refuse_used(directory: Path) -> None:
    """ConfigError, if something is in the place of a flight folder, or it cannot be looked at."""
    try:
        if os.path.lexists(directory) and not directory.is_dir():
            raise fault(directory, "is no folder")
        if directory.is_dir() and next(os.scandir(directory), None) is not None:
            raise fault(directory, "is not empty, and nothing in it is written over")
    except OSError as error:
        raise fault(directory, _complaint(error)) from None


def fault(directory: Path, complaint: str) -> ConfigError:
    """A folder that cannot hold a record."""
    return ConfigError([Fault("--record", 0, "", f"{directory} {complaint}; expected a new or an empty folder")])


def _complaint(error: OSError) -> str:
    if error.errno == errno.EEXIST:
        return "is being written by another companion"
    return f"cannot be written ({error.strerror})"


def new_directory(mission: str) -> Path:
    """A name for a new flight folder: flights/DATE-TIME-MISSION, not taken yet."""
    slug = re.sub(r"[^a-z0-9]+", "-", mission.lower())[:60].strip("-") or "flight"
    stem = Path("flights") / f"{time.strftime('%Y%m%d-%H%M%S')}-{slug}"
    candidate, number = stem, 2
    while candidate.exists():
        candidate = stem.with_name(f"{stem.name}-{number}")
        number += 1
    return candidate
