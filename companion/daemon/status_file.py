"""Where each running companion stands, for other terminals: one small file a process, written anew every second.

It lies in the service's runtime directory (/run/companion), else in the user's, else beside other temporary files. The
file of a process that is no more is a flight that ended without a word. Other users can write beside it: see
``record.owned_files``; what another user's companion says is data, and shown as such.
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

from companion.record.owned_files import READABLE, owner_of, read_owned, write_owned

SCHEMA = "companion.status/1"
LIVE, PATH = ".live", ".path"
"""What lies beside a status file: see ``live``."""
SILENT_AFTER = 5.0
"""s without a new word after which a running companion hangs. Engineering choice."""

PID_MAX = 1 << 22
"""Linux's largest process number (proc(5), pid_max)."""
TIME_MAX = 1e11
"""s since 1970: what is later was not written by a clock. Engineering choice."""
FILES_MAX = 100
"""Files of one directory that are looked at. Engineering choice."""


def _temporary_directory() -> str:
    """Where temporary files go; the usual place where this system has none that can be written to."""
    try:
        return tempfile.gettempdir()
    except OSError:
        return "/tmp"


SHARED = ("run/companion", "run/user/*/companion", f"{_temporary_directory()}/companion-*".lstrip("/"))
"""Where companions of other users leave theirs, seen from the root."""


class FlightStatus(NamedTuple):
    """What one companion said last. ``age``: s since then. ``running``: whether its process is still there. ``file``:
    where it said so, ``owner``: the user's number it belongs to."""

    document: Mapping[str, Any]
    age: float
    running: bool
    file: Path = Path()
    owner: int = 0


class StatusFile:
    """This process's own file. A directory that cannot be written to is no reason not to fly."""

    def __init__(self, about: Mapping[str, Any], environment: Mapping[str, str] = os.environ) -> None:
        self._about = {"schema": SCHEMA, "pid": os.getpid(), **about}
        self._file = own_directory(environment) / f"{os.getpid()}.json"

    def write(self, said: Mapping[str, Any]) -> None:
        """Say where the flight stands."""
        write_owned(self._file, json.dumps({**self._about, **said, "written_at": time.time()}), READABLE)

    def remove(self) -> None:
        """The flight is over."""
        with contextlib.suppress(OSError):
            self._file.unlink()


def read_statuses(environment: Mapping[str, str] = os.environ, *, once: bool = True) -> list[FlightStatus]:
    """Every companion on this computer, the last one heard first. ``once``: those that are no more are told once."""
    found = []
    for file, owner in _files(environment):
        document = _parse(read_owned(file, owner))
        if document is None:
            continue
        running = _is_running(document["pid"])
        if once and not running and owner == os.geteuid():
            for left in (file, file.with_suffix(LIVE), file.with_suffix(PATH)):
                with contextlib.suppress(OSError):
                    left.unlink()
        found.append(FlightStatus(document, max(0.0, time.time() - document["written_at"]), running, file, owner))
    return sorted(found, key=lambda status: status.age)


def own_directory(environment: Mapping[str, str]) -> Path:
    """Where this user's companions say how they are."""
    given = environment.get("RUNTIME_DIRECTORY", "").split(":")[0]
    if given:
        return Path(given).resolve()  # a service manager may give a link
    users = environment.get("XDG_RUNTIME_DIR")
    return Path(users) / "companion" if users else Path(_temporary_directory()) / f"companion-{os.getuid()}"


def _parse(text: str | None) -> dict[str, Any] | None:
    """What a file says, if a companion wrote it."""
    try:
        document = json.loads(text or "")
        pid, written_at = document["pid"], document["written_at"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    numbers = isinstance(pid, int) and isinstance(written_at, int | float)
    return document if numbers and 0 < pid <= PID_MAX and 0.0 <= written_at < TIME_MAX else None


def _files(environment: Mapping[str, str]) -> Iterator[tuple[Path, int]]:
    """Each file, and the user's number it must belong to: its directory's owner."""
    shared = (directory for pattern in SHARED for directory in Path("/").glob(pattern))
    for directory in sorted({own_directory(environment), *shared}):
        owner = owner_of(directory)
        if owner is not None:
            with contextlib.suppress(OSError):
                yield from ((file, owner) for file in sorted(directory.glob("*.json"))[:FILES_MAX])


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:  # somebody else's
        return True
    return True
