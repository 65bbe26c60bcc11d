"""``check``: what a mission will ask of a vehicle, before anything flies."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import NamedTuple

from companion.cli.orders import Faults, Sortie, home_told, read_sortie, read_world
from companion.cli.output import Output
from companion.cli.terminal import busy, say
from companion.config.syntax.faults import ConfigError, Fault
from companion.feasibility import report as feasibility
from companion.feasibility.document import as_document
from companion.feasibility.report import Report
from companion.feasibility.words import headline, in_words
from companion.frames import Vec3
from companion.geodesy import NOTHING_TOLD
from companion.mission import Origin
from companion.places.words import place_words
from companion.plain_text import printable_lines
from companion.vehicle import Vehicle
from companion.world import World
from companion.world.machine import Deviations
from companion.world.words import air_in_words

GUSTS_RECKONED = 2.0
"""Standard deviations of the gusts on top of the mean wind (engineering choice: 5 % of the gusts are stronger)."""
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
        _plottable(plot)
    faults = Faults()
    simulated = None if world is None else faults.collect(lambda: read_world(world, 0))
    told = faults.collect(lambda: home_told(home, None if simulated is None else simulated.world)) or NOTHING_TOLD
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, output, direct=True, told=told))
    faults.raise_any()
    assert sortie is not None
    air = None if simulated is None else air_of(simulated.world, height=-sortie.mission.table.at(0.0)[0][2])
    if simulated is not None:
        sortie = dataclasses.replace(sortie, vehicle=as_it_is(sortie.vehicle, simulated.world.truth))
    sortie, found = looked_at(sortie, (0.0, 0.0, 0.0) if air is None else air.wind_n)
    places = place_words(sortie.mission, Origin.TAKEOFF)
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


class Air(NamedTuple):
    """The steady wind that is reckoned with, m/s, and where it comes from, in words."""

    wind_n: Vec3
    words: str


def air_of(world: World, height: float) -> Air:
    """The mean wind with twice the standard deviation of its gusts on top, at a height over the ground (m)."""
    mean = math.hypot(*world.wind_n)
    gusts = 0.0 if world.gusts is None else GUSTS_RECKONED * world.gusts.at(height).sigma[0]
    words = f"{world.name}: {air_in_words(world)}"
    if mean == 0.0 or gusts == 0.0:
        return Air(world.wind_n, words)
    x, y, z = (component * (mean + gusts) / mean for component in world.wind_n)
    return Air((x, y, z), f"{words}; looked at with {mean + gusts:.1f} m/s, the mean and twice the gusts")


def as_it_is(vehicle: Vehicle, truth: Deviations) -> Vehicle:
    """The vehicle with the true mass, inertia, drag and thrust of a world."""
    rotors = tuple(
        dataclasses.replace(rotor, thrust_max=rotor.thrust_max * truth.thrust_scale) for rotor in vehicle.rotors
    )
    return dataclasses.replace(
        vehicle,
        mass=vehicle.mass if truth.mass is None else truth.mass,
        inertia=vehicle.inertia if truth.inertia is None else truth.inertia,
        drag=vehicle.drag if truth.drag is None else truth.drag,
        rotors=rotors,
    )


def looked_at(sortie: Sortie, wind_n: Vec3 = (0.0, 0.0, 0.0)) -> tuple[Sortie, Report]:
    """What the mission asks of the vehicle; and the sortie with its speed known, where that was ``auto``. What of its
    file is not flown is said. ConfigError: it cannot be looked at."""
    for note in sortie.mission.notes:
        say(f"note: {note}")
    try:
        with busy(f"checking {sortie.mission.name}"):
            found = feasibility.check(sortie.mission, sortie.vehicle, wind_n=wind_n)
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
