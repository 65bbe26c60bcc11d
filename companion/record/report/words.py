"""The sentences of the page: what was flown, how it ended, what a reader must not overlook."""

from __future__ import annotations

from datetime import UTC, datetime

from companion.record.report.evidence import SETTLE, Evidence
from companion.record.report.numbers import worded
from companion.vehicle import OutputLevel

NBSP = "\N{NO-BREAK SPACE}"
LEVELS = {
    OutputLevel.MOTORS: "motor commands",
    OutputLevel.RATES: "body rates and thrust",
    OutputLevel.ATTITUDE: "attitude and thrust",
}


def facts(evidence: Evidence) -> list[str]:
    """Vehicle, output level, kind of flight, date."""
    return [
        str(evidence.figures["vehicle"]),
        LEVELS[evidence.plan.level],
        _kind(evidence),
        *([] if evidence.lockstep else [_date(evidence)]),
    ]


def _kind(evidence: Evidence) -> str:
    if evidence.lockstep:
        return "simulated, in lockstep"
    return "simulated, in real time" if evidence.simulated else "real-time flight"


def _date(evidence: Evidence) -> str:
    try:
        begun = datetime.fromtimestamp(evidence.resolved["epoch"] + evidence.resolved["begun_at"], UTC)
    except (KeyError, TypeError, ValueError, OverflowError, OSError):
        return "date not recorded"
    return f"{begun.day} {begun:%B %Y, %H:%M} UTC"


def outcome(evidence: Evidence) -> tuple[bool, str]:
    """Whether it was completed, and how it ended in one sentence."""
    duration, distance, laps = (evidence.number("follow", key) for key in ("duration_s", "distance_m", "laps"))
    flown = None
    if duration and distance is not None and laps is not None:
        flown = f"the path for {worded(duration)}{NBSP}s over {worded(distance)}{NBSP}m, {worded(laps)} laps"
    if evidence.figures["outcome"] == "completed":
        return True, f"Completed: followed {flown}." if flown else "Completed, without following the path."
    when = f"after following {flown}" if flown else "before it came to follow the path"
    reason = evidence.figures.get("reason")
    return False, f"Aborted {when}: {reason}." if reason else f"Aborted {when}, for no reason on record."


def notes(evidence: Evidence) -> list[str]:
    """What must not be overlooked: the summary's own notes, and what the folder lacks."""
    told = evidence.figures.get("notes")
    found = [str(note) for note in told] if isinstance(told, list) else []
    if evidence.remade:
        found.append(
            f"the folder holds no summary, so its figures were computed from the record, with {SETTLE:g} s to settle"
        )
    if evidence.followed and evidence.settled_from is None:
        found.append("the flight ended before it counted as settled, so there are no settled figures")
    return [note[:1].upper() + note[1:] + ("" if note.endswith(".") else ".") for note in found]
