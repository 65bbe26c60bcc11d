"""``check``: what a mission will ask of a vehicle, before anything flies."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from companion.cli.orders import Sortie, read_sortie
from companion.cli.output import Output
from companion.cli.terminal import busy, say
from companion.config.syntax.faults import ConfigError, Fault
from companion.feasibility import report as feasibility
from companion.feasibility.document import as_document
from companion.feasibility.report import Report
from companion.feasibility.words import headline, in_words
from companion.mission import Origin
from companion.places.words import place_words
from companion.plain_text import printable_lines

FEASIBLE, NOT_FEASIBLE = 0, 1
PICTURES = (".png", ".svg", ".pdf")


def check(mission: str, vehicle: str | None, *, as_json: bool, plot: Path | None) -> int:
    """Look at a mission and say what would happen; the exit code. ConfigError: it cannot be looked at."""
    if plot is not None:
        _plottable(plot)
    sortie, found = looked_at(read_sortie(mission, vehicle, Output.AUTO))
    places = place_words(sortie.mission, Origin.TAKEOFF)
    if as_json:
        print(json.dumps(as_document(found, places.lines, places.warnings), indent=2))
        say(headline(found))
        for warning in places.warnings:
            say(f"warning: {warning}")
    else:
        print(printable_lines(in_words(found, places.lines, places.warnings)))
    if plot is not None:
        from companion.feasibility.picture import picture

        try:
            picture(found).savefig(plot)
        except OSError as error:
            raise ConfigError([Fault(str(plot), 0, "", f"cannot be written: {error.strerror}")]) from None
        say(f"picture: {plot}")
    return FEASIBLE if found.feasible else NOT_FEASIBLE


def looked_at(sortie: Sortie) -> tuple[Sortie, Report]:
    """What the mission asks of the vehicle; and the sortie with its speed known, where that was ``auto``. What of its
    file is not flown is said. ConfigError: it cannot be looked at."""
    for note in sortie.mission.notes:
        say(f"note: {note}")
    try:
        with busy(f"checking {sortie.mission.name}"):
            found = feasibility.check(sortie.mission, sortie.vehicle)
    except (ValueError, ArithmeticError) as error:
        raise ConfigError([Fault(sortie.mission_source.name, 1, "path", str(error))]) from None
    return dataclasses.replace(sortie, mission=found.mission), found


def _plottable(plot: Path) -> None:
    if plot.suffix.lower() not in PICTURES:
        raise ConfigError([Fault("--plot", 0, "", f"{plot.name}: expected a file ending in {', '.join(PICTURES)}")])
    if not plot.parent.is_dir():
        raise ConfigError([Fault("--plot", 0, "", f"{plot.parent}: no such directory")])
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        message = "a picture needs matplotlib; install it with: pip install 'companion[report]'"
        raise ConfigError([Fault("--plot", 0, "", message)]) from None
