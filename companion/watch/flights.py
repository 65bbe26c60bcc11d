"""What the companions of this computer publish, read again and again; and where each vehicle has been since."""

from __future__ import annotations

import json
import os
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from companion.daemon.status_file import LIVE, PATH, SILENT_AFTER, FlightStatus, read_statuses
from companion.plain_text import printable
from companion.record.owned_files import read_owned

STATUS_PERIOD = 1.0
"""s between two looks for companions: they write their status as often."""
TRAIL_PERIOD = 0.25
TRAIL_POINTS = 1200
"""Of a trail: five minutes."""
GONE_AFTER = 600.0
"""s that a companion which ended without a word is shown."""
TEXT_MAX, NOTES_MAX = 300, 20
LABELS = ("mission", "vehicle", "output", "link", "record", "progress", "battery", "others")


class Flight(NamedTuple):
    """One companion: its status, its path if it has one, its trail (points north, east, down, m)."""

    status: FlightStatus
    path: Any
    trail: deque[list[float]]


class Flights:
    """Reads them. ``look`` is called as often as a page wants to know."""

    def __init__(
        self, environment: Mapping[str, str] = os.environ, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._environment = environment
        self._clock = clock
        self._looked_at = self._trailed_at = -STATUS_PERIOD
        self._flights: dict[int, Flight] = {}

    def look(self) -> list[dict[str, Any]]:
        """Every companion as a page shows it."""
        now = self._clock()
        if now - self._looked_at >= STATUS_PERIOD:
            self._looked_at = now
            self._look_around()
        trails = now - self._trailed_at >= TRAIL_PERIOD
        if trails:
            self._trailed_at = now
        return [self._document(pid, flight, trails) for pid, flight in sorted(self._flights.items())]

    def drawing(self, pid: int) -> dict[str, Any] | None:
        """The path and the trail of one companion; None where there is none such."""
        flight = self._flights.get(pid)
        return None if flight is None else {"path": flight.path, "trail": list(flight.trail)}

    def _look_around(self) -> None:
        found = {}
        for status in read_statuses(self._environment, once=False):
            if not status.running and status.age > GONE_AFTER:
                continue
            pid = status.document["pid"]
            known = self._flights.get(pid)
            path = _read(status, PATH) or (None if known is None else known.path)
            found[pid] = Flight(status, path, deque(maxlen=TRAIL_POINTS) if known is None else known.trail)
        self._flights = found

    def _document(self, pid: int, flight: Flight, trails: bool) -> dict[str, Any]:
        status = flight.status
        live = _read(status, LIVE) if status.running else None
        place = None if live is None else _place(live.get("p_n"))
        if trails and place is not None:
            flight.trail.append(place)
        said = status.document.get("notes")
        return {
            "pid": pid,
            "running": status.running,
            "state": _state(status),
            "has_path": flight.path is not None,
            "about": {label: _plain(status.document.get(label)) for label in LABELS},
            "phase": _plain(status.document.get("phase")),
            "notes": [_plain(note) for note in said[:NOTES_MAX]] if isinstance(said, list) else [],
            "live": live,
        }


def _state(status: FlightStatus) -> str:
    if not status.running:
        return "ended without a word; look at the vehicle and at its flight folder"
    if status.age > SILENT_AFTER + STATUS_PERIOD:
        return f"has said nothing for {status.age:.0f} s; it hangs, or the computer does"
    return ""


def _read(status: FlightStatus, suffix: str) -> dict[str, Any] | None:
    """What lies beside a status file, if its companion wrote it."""
    try:
        document = json.loads(read_owned(status.file.with_suffix(suffix), status.owner) or "", parse_constant=_refuse)
    except (ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def _refuse(name: str) -> None:
    raise ValueError(f"{name} is no JSON")


def _place(document: Any) -> list[float] | None:
    known = isinstance(document, list) and len(document) == 3 and all(isinstance(x, int | float) for x in document)
    return document if known else None


def _plain(value: object) -> str:
    return "" if value is None else printable(str(value))[:TEXT_MAX]
