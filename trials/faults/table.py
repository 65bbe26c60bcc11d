"""The deck, flown, as one table: what happened, how it must end, how it ended, how low, how steep, what was said."""

from __future__ import annotations

import math
import multiprocessing
import random
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

from companion.plain_text import printable
from companion.vehicle import OutputLevel
from trials.faults.case import LEVELS, Case
from trials.faults.course import Flight
from trials.faults.deck import DECK, GROUPS
from trials.faults.deck.seen import SEEN
from trials.faults.flying import fly
from trials.faults.real_time import fly_over_udp
from trials.faults.verdict import commands_after_the_last_word, end_in_words, wrong

HEAD = (
    "| what happens | must end | ended | lowest, m | steepest, deg | commands | said |\n|---|---|---|---|---|---|---|\n"
)
PAGE = """# Faults

Every fault that was ever seen or thought of, each as a flight in lockstep against the stand-in, from a hover on a circle
of 5 m at 10 m height and 3 m/s unless it says otherwise. Made by `python -m bench.faults`; each row is a case of
`trials/faults/deck`, whose world keys `docs/worlds.md` explains. Three figures are those at rates, attitude and motors;
one stands for all of them. What is refused before the flight by rules in which the level has no say is shown at rates.

*Must end*: flown as if nothing had happened; held (given up with a reason, the vehicle in Hold); refused (nothing armed,
no mode asked for); the operator's (over, and the vehicle does what he said); PX4's failsafe (over, and what PX4 does about
lost setpoints decides); ended (over with a reason, where nothing is left to hold); disarmed (the same, and it is
disarmed). *Lowest* is the true height while the vehicle was in OFFBOARD or Hold after the fault, of the height it flew at
then; *steepest* the true tilt in that time. *Commands* are those for a mode, arming or a place that the companion sent
after it had heard the operator's last word (one state after the status that shows it); a dash where he said nothing. A
difference from how it must be stands in bold.

"""
UDP = """## Over UDP, in real time

Of every kind that was seen one case, and some others, drawn by a seed: the daemon's own loop and socket, the vehicle a
process of its own. Made by `python -m bench.faults --udp`.

"""


OTHERS = 8
"""Flights over UDP beside those of what was seen."""
BEHIND = 0.2
"""s that the plant's time may slip behind before it is told."""


class Row(NamedTuple):
    """One flight of the table. ``commands``: after the operator's last word; ``wrong``: what is not as it must be.
    ``udp``: flown over UDP in real time."""

    name: str
    level: OutputLevel
    ended: str
    lowest: float
    of: float
    steepest: float
    commands: int | None
    said: str
    wrong: tuple[str, ...]
    udp: bool = False


def flown(case: Case, level: OutputLevel) -> Row:
    """Fly a case at a level."""
    try:
        return _row(fly(case, level))
    except Exception:
        return _failed(case, level)


def _failed(case: Case, level: OutputLevel) -> Row:
    """The row of a flight that the exception at hand has ended."""
    line = traceback.format_exc().strip().splitlines()[-1]
    return Row(case.name, level, "an exception", math.inf, 0.0, 0.0, None, "", (line,))


def _row(flight: Flight) -> Row:
    return Row(
        flight.case.name, flight.level, end_in_words(flight), flight.lowest, flight.height_then,
        math.degrees(flight.steepest), commands_after_the_last_word(flight), flight.sentence or "",
        tuple(wrong(flight)),
    )  # fmt: skip


def flown_over_udp(case: Case, level: OutputLevel) -> Row:
    """Fly a case at a level over UDP, in real time."""
    try:
        flight, behind = fly_over_udp(case, level)
    except Exception:
        return _failed(case, level)._replace(udp=True)
    if behind > BEHIND:
        print(f"{case.name}, {level.value}: the plant slipped {behind:.1f} s behind: the machine is busy")
    return _row(flight)._replace(udp=True)


def over_udp() -> list[Planned]:
    """What is flown over UDP, drawn by a seed: of every kind that was seen one case, and some others."""
    rng = random.Random("over UDP")
    named = {case.name: case for case in DECK}
    cases = [named[rng.choice(names)] for names in SEEN.values()]
    cases += rng.sample([case for case in DECK if case not in cases], OTHERS)
    return [(case, rng.choice(case.levels)) for case in cases]


Planned = tuple[Case, OutputLevel]


def flights_of(cases: Iterable[Case], levels: Iterable[OutputLevel]) -> list[Planned]:
    """Every case at every one of these levels that it is for."""
    return [(case, level) for level in levels for case in cases if level in case.levels]


def rows(flights: Sequence[Planned], jobs: int) -> Iterator[Row]:
    """Fly them, on so many processes; in order."""
    if jobs == 1:
        yield from (flown(*flight) for flight in flights)
        return
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        yield from pool.imap(_flown, flights)


def _flown(flight: Planned) -> Row:
    return flown(*flight)


def page(found: Iterable[Row], commit: str) -> str:
    """The whole of docs/faults.md. ``commit``: at which they were flown."""
    flown = list(found)
    by_name: dict[str, dict[OutputLevel, Row]] = {}
    for row in flown:
        if not row.udp:
            by_name.setdefault(row.name, {})[row.level] = row
    flown_udp = {(row.name, row.level): row for row in flown if row.udp}
    flights = [row for group in by_name.values() for row in group.values()]
    right = sum(not row.wrong for row in flights)
    text = PAGE + (
        f"{len(by_name)} faults, {len(flights)} of {len(flights_of(DECK, LEVELS))} flights at commit {commit}, {right} as "
        f"they must be; over UDP {len(flown_udp)}, {sum(not row.wrong for row in flown_udp.values())} as they must be.\n"
    )
    text += "\n## What was seen\n\n| what | cases | flights as they must be | over UDP |\n|---|---|---|---|\n"
    text += "".join(_seen(what, names, flights, list(flown_udp.values())) for what, names in SEEN.items())
    for title, cases in GROUPS.items():
        lines = [
            _line(case, by_name[case.name], _only(case, by_name[case.name])) for case in cases if case.name in by_name
        ]
        if lines:
            text += f"\n## {title}\n\n{HEAD}{''.join(lines)}"
    lines = [
        _line(case, {level: flown_udp[case.name, level]}, f" (at {level.value})")
        for case in DECK for level in LEVELS if (case.name, level) in flown_udp
    ]  # fmt: skip
    return text + (f"\n{UDP}{HEAD}{''.join(lines)}" if lines else "")


def _seen(what: str, names: Sequence[str], flights: Sequence[Row], over_udp: Sequence[Row]) -> str:
    """Of what was once seen on a link: the cases that hold it, and how many of their flights are right."""
    cells = [what, "; ".join(names)]
    for group in (flights, over_udp):
        rights = [not row.wrong for row in group if row.name in names]
        cells.append(f"{sum(rights)} of {len(rights)}" if rights else "-")
    return f"| {' | '.join(cells)} |\n"


def _only(case: Case, group: dict[OutputLevel, Row]) -> str:
    """Where it was flown at some of its levels only, at which."""
    levels = ", ".join(level.value for level in LEVELS if level in group)
    return "" if set(group) == set(case.levels) else f" (so far at {levels})"


def _line(case: Case, group: dict[OutputLevel, Row], suffix: str = "") -> str:
    ends = " or ".join(end.value for end in (case.end, *case.or_end))
    of = max(row.of for row in group.values())
    lowest = _each(group, lambda row: "-" if math.isinf(row.lowest) else f"{row.lowest:.1f}")
    cells = (
        case.name + suffix,
        ends,
        _each(group, lambda row: f"**{row.ended}**" if row.wrong else row.ended),
        lowest if of < 1.0 or lowest == "-" else f"{lowest} of {of:.1f}",
        _each(group, lambda row: f"{row.steepest:.0f}"),
        _each(group, lambda row: "-" if row.commands is None else str(row.commands)),
        _said(group),
    )
    return f"| {' | '.join(cells)} |\n"


def _each(group: dict[OutputLevel, Row], words: Callable[[Row], str]) -> str:
    """What is told of each level, in their order; once where it is the same at all."""
    told = [words(group[level]) for level in LEVELS if level in group]
    return told[0] if len(set(told)) == 1 else " / ".join(told)


def _said(group: dict[OutputLevel, Row]) -> str:
    """The sentence; where a level says another one than the first, and not only another figure, that too."""
    told: dict[str, str] = {}
    for level in (level for level in LEVELS if level in group):
        said = printable(group[level].said).replace("|", "/")
        kind = "".join(letter for letter in said if not letter.isdigit())
        told.setdefault(kind, said if not told else f"*{level.value}:* {said or 'nothing'}")
    return " ".join(told.values())


def cases_named(part: str) -> tuple[Case, ...]:
    """The cases of the deck whose name has ``part`` in it."""
    return tuple(case for case in DECK if part in case.name)
