"""What happened to a flight, and what it did about it: the start off the path, the events of its world, standing still,
the time at a limit and the time slowed down. From the record alone, so that the page can be made again."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.flight.phases import Request
from companion.mavlink_common import MavResult
from companion.record.table import Table
from companion.vehicle import Mode

Array = NDArray[np.float64]
Series = dict[str, Array]

START_OFF = 0.3
"""m from the path from which a start is told as one off the path (engineering choice)."""
STANDING_SHARE = 0.1
"""Share of the mission's speed below which a vehicle is taken to stand (engineering choice)."""
STANDING_FOR = 0.7
"""s it stands, ramps apart, until that is told (engineering choice)."""
LIMIT_FOR = 0.2
"""s at a limit, or slowed down, until that is told (engineering choice)."""
MERGED_WITHIN = 0.5
"""s between two spans of a kind that are told as one (engineering choice)."""
SLOWED_BELOW = 0.98
"""Share of the mission's speed asked for below which the flight counts as slowed down (engineering choice)."""
SPANS_MAX = 12
"""Spans of a kind that are told; the longest are (engineering choice)."""
BACK_PATH, BACK_SPEED = 0.10, 0.10
"""m from the path, and share of the mission's speed, within which a vehicle is back on it (engineering choice)."""
BACK_FOR = 1.0
"""s for which it must stay there to count as back (engineering choice)."""


class FlightEvent(NamedTuple):
    """Something that happened while following. ``begin``, ``end``: s of following.

    ``error_max``: m, the largest path error from its begin until the vehicle was back; ``error_at_end``: m;
    ``speed_max``: m/s in the same time; ``back_after``: s from its end until the vehicle was back on the path at the
    mission's speed, None where it never was; ``ahead``: m that a reference on a timetable would have run ahead.
    """

    kind: str
    what: str
    begin: float
    end: float
    error_max: float
    error_at_end: float
    speed_max: float
    back_after: float | None
    ahead: float

    @property
    def document(self) -> dict[str, Any]:
        """For summary.json."""
        return {
            "kind": self.kind,
            "what": self.what,
            "words": in_words(self),
            "from_s": self.begin,
            "to_s": self.end,
            "path_error_max_m": self.error_max,
            "path_error_at_end_m": self.error_at_end,
            "speed_max_mps": self.speed_max,
            "back_after_s": self.back_after,
            "timetable_ahead_m": self.ahead,
        }


OWN = ("at_limit", "slowed")
"""Kinds that are the flight's own state, not something that was done to it."""


def flight_events(estimated: Series, table: Table, simulation: dict[str, Any] | None) -> list[FlightEvent]:
    """Everything that happened in the followed part, in the order of its begin."""
    if len(estimated["t"]) < 2:
        return []
    found = []
    if estimated["path_error"][0] > START_OFF:
        speed = abs(estimated["speed"][0])
        off, asked = estimated["path_error"][0], abs(estimated["alpha"][0])
        what = f"began {off:.1f} m off the path, at {speed:z.1f} of {asked:z.1f} m/s"
        found.append(_measure(estimated, "start", what, 0.0, 0.0))
    done = [_measure(estimated, *event) for event in _world_events(estimated, table, simulation)]
    found += done
    for begin, end in _spans(estimated, _standing(estimated), STANDING_FOR):
        if not any(each.begin - 1.0 < end and begin < each.end + 1.0 for each in done if each.kind == "hold"):
            found.append(_measure(estimated, "stood", "stood still, though the path goes on", begin, end))
    for begin, end in _spans(estimated, estimated["saturated"] > 0.0, LIMIT_FOR):
        found.append(_measure(estimated, "at_limit", "a limit of the vehicle was met", begin, end))
    # records from before the pace was written have none
    slowed = np.nan_to_num(estimated.get("pace", np.ones(len(estimated["t"]))), nan=1.0) < SLOWED_BELOW
    for begin, end in _spans(estimated, slowed, LIMIT_FOR):
        found.append(
            _measure(estimated, "slowed", "slowed down: the path asks for more than the vehicle has", begin, end)
        )
    return sorted(found, key=lambda each: each.begin)


def in_words(each: FlightEvent) -> str:
    """One sentence: what happened, and what the vehicle did."""
    lasted = "" if each.end <= each.begin else f" for {each.end - each.begin:.1f} s"
    said = f"{each.begin:.1f} s: {each.what}{lasted}"
    if each.kind in OWN:
        return f"{said}; path error to {length_in_words(each.error_max)}"
    if each.kind in ("hold", "stood"):
        near = length_in_words(each.error_at_end)
        said += f" (a timetable would be {each.ahead:.1f} m ahead; the path's near point is {near} away)"
    if each.back_after is None:
        return (
            f"{said}; path error to {length_in_words(each.error_max)}, not back on the path at its speed before the end"
        )
    return (
        f"{said}; back on the path at its speed {each.back_after:.1f} s later, path error to "
        f"{length_in_words(each.error_max)}, speed to {each.speed_max:.1f} m/s"
    )


def length_in_words(metres: float) -> str:
    """In m from one metre on, else in cm."""
    return f"{metres:.2f} m" if metres >= 1.0 else f"{100.0 * metres:.1f} cm"


def _world_events(
    estimated: Series, table: Table, simulation: dict[str, Any] | None
) -> list[tuple[str, str, float, float]]:
    """(kind, what, begin, end) of the world's events that fell into following."""
    offboard, found = offboard_at(table), []
    stamps, t = estimated["t_boot"], estimated["t"]
    for event in (simulation or {}).get("events", []):
        zero = 0.0 if event["after"] == "start" else offboard
        if zero is None:
            continue
        begin = zero + event["from_s"]
        end = math.inf if event["to_s"] is None else zero + event["to_s"]
        if end < stamps[0] or begin > stamps[-1]:
            continue
        told_begin, told_end = (float(np.interp(min(at, stamps[-1]), stamps, t)) for at in (begin, end))
        found.append((event["kind"], event["what"], told_begin, told_end))
    return found


def offboard_at(table: Table) -> float | None:
    """The vehicle's stamp (s) of the first state after OFFBOARD was accepted; None where it never was."""
    accepted = (table["answer_to"] == list(Request).index(Request.OFFBOARD)) & (
        table["answer"] == list(MavResult).index(MavResult.ACCEPTED)
    )
    there = accepted | (table["mode"] == list(Mode).index(Mode.OFFBOARD))
    if not there.any():
        return None
    later = table["t_boot"][int(np.argmax(there)) :]
    later = later[np.isfinite(later)]
    return float(later[0]) if len(later) else None


def _measure(estimated: Series, kind: str, what: str, begin: float, end: float) -> FlightEvent:
    t = estimated["t"]
    back = None if kind in OWN else _back(estimated, end)
    until = end if kind in OWN else float(t[-1]) if back is None else end + back
    rows = (t >= begin) & (t <= max(until, begin))
    if not rows.any():
        rows = np.arange(len(t)) == int(np.argmin(np.abs(t - begin)))
    last = min(int(np.searchsorted(t, end)), len(t) - 1)
    alpha = float(np.mean(np.abs(estimated["alpha"][rows])))
    return FlightEvent(
        kind,
        what,
        begin,
        end,
        float(np.max(estimated["path_error"][rows])),
        float(estimated["path_error"][last]),
        float(np.max(np.abs(estimated["speed"][rows]))),
        back,
        alpha * (end - begin),
    )


def _back(estimated: Series, end: float) -> float | None:
    """s from ``end`` until the vehicle stays near the path and at its speed."""
    t, alpha = estimated["t"], np.abs(estimated["alpha"])
    there = (estimated["path_error"] <= BACK_PATH) & (np.abs(estimated["speed_error"]) <= BACK_SPEED * alpha)
    for index in np.flatnonzero(there & (t >= end)):
        rows = (t >= t[index]) & (t <= t[index] + BACK_FOR)
        if there[rows].all():
            return float(t[index]) - end
    return None


def _standing(estimated: Series) -> NDArray[np.bool_]:
    return (np.abs(estimated["speed"]) < STANDING_SHARE * np.abs(estimated["alpha"])) & (
        np.abs(estimated["ramp"]) > 0.99
    )


def _spans(estimated: Series, flags: NDArray[np.bool_], least: float) -> list[tuple[float, float]]:
    """(begin, end) of the longest stretches where ``flags`` hold, near ones told as one, in the order of time."""
    t = estimated["t"]
    spans: list[tuple[float, float]] = []
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(int)))
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        begin, end = float(t[first]), float(t[after - 1])
        if spans and begin - spans[-1][1] < MERGED_WITHIN:
            spans[-1] = (spans[-1][0], end)
        else:
            spans.append((begin, end))
    longest = sorted((span for span in spans if span[1] - span[0] >= least), key=lambda span: span[0] - span[1])
    return sorted(longest[:SPANS_MAX])
