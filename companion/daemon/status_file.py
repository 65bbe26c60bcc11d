"""Where each running companion stands, for other terminals: one small file a process, written anew every second.

It lies in the service's runtime directory (/run/companion), else in the user's, else beside other temporary files. The
file of a process that is no more is a flight that ended without a word.
"""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from companion.record.folder import written_whole

SCHEMA = "companion.status/1"
SILENT_AFTER = 5.0
"""s without a new word after which a running companion hangs."""

SHARED = ("run/companion", "run/user/*/companion", f"{tempfile.gettempdir()}/companion-*".lstrip("/"))
"""Where companions of other users leave theirs, seen from the root."""


class Standing(NamedTuple):
    """What one companion said last. ``age``: s since then. ``running``: whether its process is still there."""

    told: Mapping[str, Any]
    age: float
    running: bool


class Notice:
    """This process's own file. A directory that cannot be written to is no reason not to fly."""

    def __init__(self, about: Mapping[str, Any], environment: Mapping[str, str] = os.environ) -> None:
        self._about = {"schema": SCHEMA, "pid": os.getpid(), **about}
        self._file = _own_directory(environment) / f"{os.getpid()}.json"

    def write(self, said: Mapping[str, Any]) -> None:
        """Say where the flight stands."""
        written_whole(self._file, json.dumps({**self._about, **said, "written_at": time.time()}))

    def remove(self) -> None:
        """The flight is over."""
        with contextlib.suppress(OSError):
            self._file.unlink()


def standings(environment: Mapping[str, str] = os.environ) -> list[Standing]:
    """Every companion on this computer, the last one heard first; those that are no more are told once."""
    found = []
    for file in _files(environment):
        try:
            told = json.loads(file.read_text(encoding="utf-8"))
            pid, written_at = int(told["pid"]), float(told["written_at"])
        except (OSError, ValueError, KeyError, TypeError):
            continue
        running = _is_running(pid)
        if not running:
            with contextlib.suppress(OSError):
                file.unlink()
        found.append(Standing(told, max(0.0, time.time() - written_at), running))
    return sorted(found, key=lambda standing: standing.age)


def _own_directory(environment: Mapping[str, str]) -> Path:
    given = environment.get("RUNTIME_DIRECTORY", "").split(":")[0]
    if given:
        return Path(given)
    users = environment.get("XDG_RUNTIME_DIR")
    return Path(users) / "companion" if users else Path(tempfile.gettempdir()) / f"companion-{os.getuid()}"


def _files(environment: Mapping[str, str]) -> Iterator[Path]:
    shared = (directory for pattern in SHARED for directory in Path("/").glob(pattern))
    for directory in sorted({_own_directory(environment), *shared}):
        with contextlib.suppress(OSError):
            yield from sorted(directory.glob("*.json"))


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:  # somebody else's
        return True
    return True
