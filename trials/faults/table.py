"""The deck, flown, as one table: what happened, how it must end, how it ended, how low, how steep, what was said."""

from __future__ import annotations

import math
import multiprocessing
import traceback
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from companion.plain_text import printable
from companion.vehicle import OutputLevel
from trials.faults.case import LEVELS, Case
from trials.faults.deck import DECK, GROUPS
from trials.faults.flying import fly
from trials.faults.verdict import commands_after_the_last_word, end_in_words, wrong

HEAD = (
    "| what happens | must end | ended | lowest, m | steepest, deg | commands | said |\n|---|---|---|---|---|---|---|\n"
)
PAGE = """# Faults

Every fault that was ever seen or thought of, each as a flight in lockstep against the stand-in, at {levels}, from a
hover on a circle of 5 m at 10 m height and 3 m/s unless it says otherwise. Made by
`python -m bench.faults`; each row is a case of `trials/faults/deck`, whose world keys `docs/worlds.md` explains.

*Must end*: flown as if nothing had happened; held (given up with a reason, the vehicle in Hold); refused (nothing armed,
no mode asked for); the operator's (over, and the vehicle does what he said); PX4's failsafe (over, and what PX4 does about
lost setpoints decides); ended (over with a reason, where nothing is left to hold). *Lowest* is the true height while the
vehicle was in OFFBOARD or Hold after the fault, of the height it flew at then; *steepest* the true tilt in that time.
*Commands* are those for a mode, arming or a place that the companion sent after it had heard the operator's last word
(one state after the status that shows it); a dash where he said nothing. A difference from how it must be stands in bold.

"""


class Row(NamedTuple):
    """One flight of the table. ``commands``: after the operator's last word; ``wrong``: what is not as it must be."""

    name: str
    level: OutputLevel
    ended: str
    lowest: float
    of: float
    steepest: float
    commands: int | None
    said: str
    wrong: tuple[str, ...]


def flown(case: Case, level: OutputLevel) -> Row:
    """Fly a case at a level."""
    try:
        flight = fly(case, level)
    except Exception:
        line = traceback.format_exc().strip().splitlines()[-1]
        return Row(case.name, level, "an exception", math.inf, 0.0, 0.0, None, "", (line,))
    return Row(
        case.name, level, end_in_words(flight), flight.lowest, flight.height_then, math.degrees(flight.steepest),
        commands_after_the_last_word(flight), flight.sentence or "", tuple(wrong(flight)),
    )  # fmt: skip


def rows(cases: Iterable[Case], levels: Iterable[OutputLevel], jobs: int) -> Iterator[Row]:
    """Fly every case at every level that it is for, on so many processes; in order."""
    flights = [(case, level) for case in cases for level in levels if level in case.levels]
    if jobs == 1:
        yield from (flown(*flight) for flight in flights)
        return
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        yield from pool.imap(_flown, flights)


def _flown(flight: tuple[Case, OutputLevel]) -> Row:
    return flown(*flight)


def page(found: Iterable[Row]) -> str:
    """The whole of docs/faults.md."""
    by_name: dict[str, list[Row]] = {}
    for row in found:
        by_name.setdefault(row.name, []).append(row)
    flights = sum(map(len, by_name.values()))
    not_right = sum(bool(row.wrong) for group in by_name.values() for row in group)
    levels = " / ".join(
        level.value for level in LEVELS if any(row.level is level for g in by_name.values() for row in g)
    )
    text = (
        PAGE.format(levels=levels)
        + f"{len(by_name)} of {len(DECK)} faults, {flights} flights, {flights - not_right} as they must be.\n"
    )
    for title, cases in GROUPS.items():
        lines = [_line(case, by_name[case.name]) for case in cases if case.name in by_name]
        if lines:
            text += f"\n## {title}\n\n{HEAD}{''.join(lines)}"
    return text


def _line(case: Case, group: list[Row]) -> str:
    group.sort(key=lambda row: LEVELS.index(row.level))
    ends = " or ".join(end.value for end in (case.end, *case.or_end))
    same = len({row.ended for row in group}) == 1 and not any(row.wrong for row in group)
    ended = group[0].ended if same else " / ".join(f"**{r.ended}**" if r.wrong else r.ended for r in group)
    lowest = " / ".join("-" if math.isinf(row.lowest) else f"{row.lowest:.1f}" for row in group)
    of = max(row.of for row in group)
    steepest = " / ".join(f"{row.steepest:.0f}" for row in group)
    commands = "-" if group[0].commands is None else " / ".join(str(row.commands) for row in group)
    said = printable(group[0].said).replace("|", "/")
    height = lowest if of < 1.0 or lowest.startswith("-") else f"{lowest} of {of:.1f}"
    return f"| {case.name} | {ends} | {ended} | {height} | {steepest} | {commands} | {said} |\n"


def cases_named(part: str) -> tuple[Case, ...]:
    """The cases of the deck whose name has ``part`` in it."""
    return tuple(case for case in DECK if part in case.name)
