"""``check``: what a mission will ask of a vehicle, before anything flies."""

from __future__ import annotations

import json
from pathlib import Path

from companion.cli.output import Output
from companion.cli.terminal import busy, say
from companion.config.syntax.faults import ConfigError, Fault
from companion.feasibility.document import as_document
from companion.feasibility.report import Report
from companion.feasibility.words import headline, in_words
from companion.frames import Vec3
from companion.geodesy import NO_HOME_GIVEN
from companion.library.checking import checked, in_world
from companion.library.faults import Faults
from companion.library.orders import Sortie, given_home, read_sortie, read_world
from companion.mission import Origin
from companion.places.words import words_of_place
from companion.plain_text import printable_lines

FEASIBLE = 0
"""Exit code: the vehicle can fly it."""
NOT_FEASIBLE = 1
"""Exit code: it cannot."""
PICTURES = (".png", ".svg", ".pdf")


def check(
    mission: str, vehicle: str | None, output: Output, world: str | None, *, as_json: bool, plot: Path | None,
    home: str | None = None,
) -> int:  # fmt: skip
    """Look at a mission and say what would happen; the exit code. ConfigError: it cannot be looked at.

    ``world``: also with its wind, the gusts on top, and its true machine; None: in still air, as the vehicle file says.
    """
    if plot is not None:
        plottable(plot)
    faults = Faults()
    simulated = None if world is None else faults.collect(lambda: read_world(world, 0))
    given = faults.collect(lambda: given_home(home, None if simulated is None else simulated.world)) or NO_HOME_GIVEN
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, output, direct=True, given=given))
    faults.raise_any()
    assert sortie is not None
    sortie, air = in_world(sortie, None if simulated is None else simulated.world)
    sortie, found = check_sortie(sortie, (0.0, 0.0, 0.0) if air is None else air.wind_n)
    places = words_of_place(sortie.mission, Origin.TAKEOFF)
    if as_json:
        document = as_document(found, places.lines, places.warnings)
        if air is not None:
            document["world"] = {"name": world, "wind_mps": list(air.wind_n), "words": air.words}
        print(json.dumps(document, indent=2))
        say(headline(found))
        for warning in places.warnings:
            say(f"warning: {warning}")
    else:
        print(printable_lines(in_words(found, places.lines, places.warnings, None if air is None else air.words)))
    if plot is not None:
        from companion.feasibility.picture import picture

        try:
            picture(found).savefig(plot)
        except OSError as error:
            raise ConfigError([Fault(str(plot), 0, "", f"cannot be written: {error.strerror}")]) from None
        say(f"picture: {plot}")
    return FEASIBLE if found.feasible else NOT_FEASIBLE


def check_sortie(sortie: Sortie, wind_n: Vec3 = (0.0, 0.0, 0.0)) -> tuple[Sortie, Report]:
    """What the mission asks of the vehicle; and the sortie with its speed known, where that was ``auto``. What of its
    file is not flown is said. ConfigError: it cannot be looked at."""
    for note in sortie.mission.notes:
        say(f"note: {note}")
    with busy(f"checking {sortie.mission.name}"):
        return checked(sortie, wind_n)


def plottable(plot: Path) -> None:
    """ConfigError: no picture can be drawn there."""
    if plot.suffix.lower() not in PICTURES:
        raise ConfigError([Fault("--plot", 0, "", f"{plot.name}: expected a file ending in {', '.join(PICTURES)}")])
    if not plot.parent.is_dir():
        raise ConfigError([Fault("--plot", 0, "", f"{plot.parent}: no such directory")])
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        message = "a picture needs matplotlib; install it with: pip install 'px4-path-companion[report]'"
        raise ConfigError([Fault("--plot", 0, "", message)]) from None
