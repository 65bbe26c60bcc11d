"""What an export needs of a flight folder beside its tables."""

from __future__ import annotations

import json
from pathlib import Path

from companion.record.export.mcap_file import FolderContext


def read_context(directory: Path) -> FolderContext:
    """The clock's epoch, the notes and the words of a flight folder that ``load_flight`` has read. A note that is cut
    short, and all that is missing, is left out."""
    resolved = json.loads((directory / "resolved.json").read_text(encoding="utf-8"))
    about = {
        "mission": resolved["mission"]["name"],
        "vehicle": resolved["vehicle"]["name"],
        "output": resolved["output"],
        "version": str(resolved.get("version", "")),
        "frames": "local: x east, y north, z up, metres; vehicle: x forward, y left, z up",
    }
    try:
        text = (directory / "notes.txt").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    notes = []
    for line in text.splitlines():
        stamp, _, words = line.partition(" ")
        try:
            seconds = float(stamp)
        except ValueError:
            continue
        if 0.0 <= seconds < 1e10:
            notes.append((seconds, words))
    return FolderContext(float(resolved.get("epoch", 0.0)), notes, about)
