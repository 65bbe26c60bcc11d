"""The state file of a vehicle: what its last flight found out, for its next one.

$XDG_STATE_HOME/companion/VEHICLE.json      (usually ~/.local/state)
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

from companion.estimation.learned import Learned, sane
from companion.record.owned_files import read_owned, write_owned

SCHEMA = "companion.learned/1"
DAY = 86400.0
"""s."""


def state_directory() -> Path | None:
    """Where what outlives a flight is kept for this user; None where he has no home to keep it in."""
    base = os.environ.get("XDG_STATE_HOME")
    try:
        return (Path(base) if base else Path.home() / ".local" / "state") / "companion"
    except RuntimeError:  # no HOME, and no entry among the users: a container's number
        return None


def state_file(vehicle: str) -> Path | None:
    """Where the figures of a vehicle are kept; None where this user has no home to keep them in."""
    safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in vehicle).lstrip(".")[:100] or "vehicle"
    directory = state_directory()
    return None if directory is None else directory / f"{safe}.json"


def load_learned(file: Path | None) -> Learned | None:
    """What was learned, with its age by the clock on the wall; None where there is nothing that makes sense."""
    if file is None:
        return None
    try:
        document = json.loads(read_owned(file) or "")
        age = max(0.0, (time.time() - float(document["flown_at"])) / DAY)
        learned = Learned(
            hover_thrust=float(document["hover_thrust"]),
            drag=float(document["drag_per_s"]),
            rate_lag=float(document["rate_loop_lag_s"]),
            age_days=age,
            hover_thrust_std=float(document.get("hover_thrust_std", 0.0)),
            drag_std=float(document.get("drag_std_per_s", 0.0)),
            yaw_lag=float(document.get("yaw_loop_lag_s", 0.0)),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return learned if sane(learned) else None


def save_learned(file: Path, learned: Learned) -> bool:
    """Keep ``learned``; whether that was possible. A file half written is never left behind."""
    document = {
        "schema": SCHEMA,
        "hover_thrust": round(learned.hover_thrust, 4),
        "hover_thrust_std": round(learned.hover_thrust_std, 5),
        "drag_per_s": round(learned.drag, 4),
        "drag_std_per_s": round(learned.drag_std, 5),
        "rate_loop_lag_s": round(learned.rate_lag, 4),
        "yaw_loop_lag_s": round(learned.yaw_lag, 3),
        "flown_at": round(time.time(), 1),
    }
    return write_owned(file, json.dumps(document, indent=2) + "\n")
