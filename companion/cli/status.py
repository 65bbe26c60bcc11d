"""``status``: what the companions on this computer are doing, asked from another terminal."""

from __future__ import annotations

import json
import math

from companion.cli.finish import COMPLETED, FAILED
from companion.daemon.status_file import SILENT_AFTER, FlightStatus, read_statuses
from companion.plain_text import printable

LABEL = 9
"""characters before a line's text."""
NOTES_MAX, TEXT_MAX = 20, 300
"""Lines, and characters of a line, that are shown of one companion."""


def status(as_json: bool) -> int:
    """Print it; the exit code: 0 where one is running."""
    found = read_statuses()
    if as_json:
        print(json.dumps([{**s.document, "age_s": round(s.age, 1), "running": s.running} for s in found], indent=2))
    else:
        print("\n\n".join(map(in_words, found)) if found else "no companion is running on this computer")
    return COMPLETED if any(status.running for status in found) else FAILED


def in_words(status: FlightStatus) -> str:
    """One companion, for a person. What it said may come from another user, and is shown as data."""
    shown = {key: _plain(value) for key, value in status.document.items() if key != "notes"}
    who = f"{shown.get('mission', '?')} on {shown.get('vehicle', '?')} at {shown.get('output', '?')}"
    who += f", process {shown['pid']}"
    if not status.running:
        head = f"{who}: ended without a word {_ago(status.age)}; look at the vehicle and at its flight folder"
    elif status.age > SILENT_AFTER:
        head = f"{who}: has said nothing for {status.age:.0f} s; it hangs, or the computer does"
    else:
        head = f"{who}: {shown.get('phase', '?')}"
    lines = [head]
    for label in ("link", "mode", "battery", "progress", "others", "record"):
        value = shown.get(label)
        if value:
            lines.append(f"  {label:{LABEL}} {value}")
    said = status.document.get("notes")
    notes = [_plain(note) for note in said[:NOTES_MAX]] if isinstance(said, list) else []
    lines += [f"  {'said' if i == 0 else '':{LABEL}} {note}" for i, note in enumerate(notes)]
    return "\n".join(lines)


def _plain(value: object) -> str:
    """A value of the status file as text that fits a line."""
    return "" if value is None else printable(str(value))[:TEXT_MAX]


def _ago(age: float) -> str:
    if age < 120.0:
        return f"{age:.0f} s ago"
    return f"{age / 60.0:.0f} min ago" if age < 7200.0 else f"{math.floor(age / 3600.0)} h ago"
