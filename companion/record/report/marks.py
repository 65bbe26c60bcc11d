"""What happened, drawn into the figures: spans over time, places on the map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from companion.record.events import OWN, FlightEvent
from companion.record.report.evidence import Array, Evidence
from companion.record.report.palette import AT_LIMIT, DONE_TO, FAINT, SLOWED, VERMILION

WORDS = {
    "start": "start",
    "hold": "held",
    "stood": "stood still",
    "push": "pushed",
    "wind": "wind",
    "motor_failure": "motor failure",
    "at_limit": "at a limit",
    "slowed": "slowed",
}
PLACES_MAX = 6
"""Events that are marked on the map; more would cover it (engineering choice)."""
SPAN_MIN = 0.004
"""Share of the time shown that a span is drawn wide at least, so that a moment is seen (engineering choice)."""


class Place(NamedTuple):
    """A marked place: east, north, up in m; the word beside it; matplotlib's marker; its colour."""

    point: Array
    word: str
    shape: str
    colour: str


def short(each: FlightEvent) -> str:
    """Two or three words: ``held 3.0 s``."""
    word = WORDS.get(each.kind, each.kind.replace("_", " "))
    return f"{word} {each.end - each.begin:.1f} s" if each.end > each.begin and each.kind not in OWN else word


def shade(panels: list[Axes], evidence: Evidence, begin: float, end: float) -> None:
    """Shade in every panel when something happened between two times of following, and name it in the first."""
    least = SPAN_MIN * (end - begin)
    name_y = -np.inf
    for each in evidence.flight_events:
        if each.end < begin or each.begin > end or each.kind == "start":
            continue
        colour = {"at_limit": AT_LIMIT, "slowed": SLOWED}.get(each.kind, DONE_TO)
        from_, to = max(each.begin, begin), min(max(each.end, each.begin + least), end)
        for panel in panels:
            panel.axvspan(from_, to, color=colour, linewidth=0, zorder=0.5)
        if each.kind not in OWN and from_ > name_y + 0.12 * (end - begin):
            name_y = from_
            late = from_ > begin + 0.75 * (end - begin)
            panels[0].annotate(
                WORDS.get(each.kind, each.kind.replace("_", " ")),
                (from_, 1.0),
                xytext=(-2 if late else 2, -3),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                ha="right" if late else "left",
                va="top",
                fontsize=8,
                color=FAINT,
            )


def legend_words(evidence: Evidence) -> str:
    """What the shades of the time plots mean, for a caption; empty where there are none."""
    kinds = {each.kind for each in evidence.flight_events if each.kind != "start"}
    parts = [
        *(["yellow, what was done to the vehicle"] if kinds - set(OWN) else []),
        *(["red, at a limit of the vehicle"] if "at_limit" in kinds else []),
        *(["grey, slowed down"] if "slowed" in kinds else []),
    ]
    return f" Shaded: {'; '.join(parts)}." if parts else ""


def places(evidence: Evidence, flown: Array) -> list[Place]:
    """Where it happened, on the track."""
    t = evidence.estimated["t"]
    marked: list[Place] = []
    for each in evidence.flight_events:
        if each.kind in (*OWN, "start") or len(marked) >= PLACES_MAX:
            continue
        point = np.array([np.interp(each.begin, t, flown[:, i]) for i in range(3)])
        marked.append(Place(point, short(each), "D", VERMILION))
    return marked


def timetable(evidence: Evidence) -> tuple[Array, Place] | None:
    """Where a reference on a timetable would have gone while the vehicle was first held: its way along the path, and
    where it would be when the vehicle was let go. None where it was not held."""
    held = [each for each in evidence.flight_events if each.kind in ("hold", "stood") and each.ahead > 0.0]
    if not held:
        return None
    plan, estimated = evidence.plan, evidence.estimated
    s = float(estimated["s"][int(np.argmin(np.abs(estimated["t"] - held[0].begin)))])
    way = [plan.table.at(s + plan.direction * share * held[0].ahead)[0] for share in np.linspace(0.0, 1.0, 60)]
    points = np.array([(east, north, -down) for north, east, down in way])
    return points, Place(points[-1], f"a timetable: {held[0].ahead:.1f} m ahead", "o", VERMILION)
