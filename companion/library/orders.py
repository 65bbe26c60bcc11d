"""What a command line or a call asks for -> what is to be flown, or every fault at once."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

from companion.config.mission.mission import bare_mission_from, mission_from
from companion.config.plan.source import attached, is_plan, mission_text, parse_plan_text
from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.file_lookup import find, read
from companion.config.vehicle import vehicle_from
from companion.config.world.world import home_from, world_from
from companion.geodesy import NO_HOME_GIVEN, GivenHome
from companion.law.gains import Level, law_level
from companion.library.faults import Faults
from companion.library.output import Output
from companion.mission import Mission
from companion.record.circumstances import SimulatedWorld
from companion.record.folder import Source
from companion.record.place import refuse_used
from companion.vehicle import MotorInterface, OutputLevel, Vehicle
from companion.world import Home, World

DEFAULT_VEHICLE = "x500"
DOCUMENTS = 32
"""Number of parsed files that are kept: the flights of a study begin from the same few (engineering choice)."""
T = TypeVar("T")


@dataclass(frozen=True)
class Sortie:
    """A mission and a vehicle, read; and at which output level they fly together. ``auto``: the level was not asked
    for, so attitude may be flown in the place of rates."""

    mission: Mission
    vehicle: Vehicle
    level: OutputLevel
    mission_source: Source
    vehicle_source: Source
    auto: bool = False


def read_sortie(
    mission_name: str,
    vehicle_name: str | None,
    output: Output,
    *,
    direct: bool = False,
    given: GivenHome = NO_HOME_GIVEN,
) -> Sortie:
    """The mission and the vehicle of a command line.

    The vehicle is ``--vehicle``, else the mission's own, else x500. ``direct``: nothing is flown but a simulation, so
    ``--output motors`` treats the vehicle as if its file said ``motors: direct``, and gains slower than advised are
    noted. ``given``: of home, beside the mission's file. ConfigError with the faults of both files.
    """
    faults = Faults()
    mission = faults.collect(lambda: source_of(mission_name, "missions"))
    vehicle = faults.collect(lambda: vehicle_source(vehicle_name, mission))
    return sortie_from(mission, vehicle, output, direct=direct, given=given, faults=faults)


def sortie_from(
    mission_text: Source | None, vehicle_text: Source | None, output: Output, *, direct: bool = False,
    given: GivenHome = NO_HOME_GIVEN, faults: Faults | None = None,
) -> Sortie:  # fmt: skip
    """See ``read_sortie``. None: a file that could not be read, whose ``faults`` are known already."""
    faults = faults or Faults()
    vehicle = None
    if vehicle_text is not None:
        vehicle = faults.collect(lambda: vehicle_from(document_of(vehicle_text)))
    if vehicle is not None and direct and output is Output.MOTORS:
        vehicle = dataclasses.replace(vehicle, motors=MotorInterface.DIRECT)
    level = None if vehicle is None else output_level(output, vehicle)
    mission = None
    if mission_text is not None:
        law = None if level is None else law_level(level)
        mission = faults.collect(
            lambda: mission_from(mission_document(mission_text), law, given=given, simulated=direct)
        )
    faults.raise_any()
    assert mission is not None and vehicle is not None and level is not None
    assert mission_text is not None and vehicle_text is not None
    return Sortie(mission, vehicle, level, mission_text, vehicle_text, output is Output.AUTO)


def check_record(record: Path | None) -> None:
    """Look at the folder given to ``--record`` before anything is started. ConfigError: it is not empty."""
    if record is not None:
        refuse_used(record)


def read_bare(mission_name: str, vehicle_name: str | None, level: Level) -> tuple[Mission, Vehicle]:
    """The mission and the vehicle for ``companion law``. ConfigError with the faults of both files."""
    faults = Faults()
    mission = faults.collect(lambda: source_of(mission_name, "missions"))
    vehicle = faults.collect(lambda: source_of(vehicle_name or _usual_vehicle(mission), "vehicles"))
    return bare_from(mission, vehicle, level, faults)


def bare_from(
    mission_text: Source | None, vehicle_text: Source | None, level: Level, faults: Faults | None = None
) -> tuple[Mission, Vehicle]:
    """See ``read_bare``. None: a file that could not be read, whose ``faults`` are known already."""
    faults = faults or Faults()
    mission = vehicle = None
    if mission_text is not None:
        mission = faults.collect(lambda: bare_mission_from(mission_document(mission_text, plans=False), level))
    if vehicle_text is not None:
        vehicle = faults.collect(lambda: vehicle_from(document_of(vehicle_text)))
    faults.raise_any()
    assert mission is not None and vehicle is not None
    return mission, vehicle


def given_home(option: str | None, world: World | None = None) -> GivenHome:
    """What ``--home`` says; else how high the home of a simulated ``world`` lies, where that has one of its own.
    ConfigError with every fault."""
    if option is not None:
        home = home_from(option, "--home")
        return GivenHome(home.latitude, home.longitude, home.altitude)
    return NO_HOME_GIVEN if world is None or world.home == Home() else GivenHome(altitude=world.home.altitude)


def read_world(name: str, seed: int, home: str | None = None) -> SimulatedWorld:
    """The world of a command line, with its file as it is; its home where ``--home`` says. ConfigError with every
    fault."""
    return simulated_from(source_of(name, "worlds"), seed, home)


def simulated_from(source: Source, seed: int, home: str | None = None) -> SimulatedWorld:
    """See ``read_world``."""
    world = world_from(document_of(source))
    if home is not None:
        world = dataclasses.replace(world, home=home_from(home, "--home"))
    return SimulatedWorld(world, source.name, source.text, seed)


def output_level(output: Output, vehicle: Vehicle) -> OutputLevel:
    """``auto``: motors only where the vehicle declares direct motors, otherwise rates."""
    if output is Output.AUTO:
        return OutputLevel.MOTORS if vehicle.motors is MotorInterface.DIRECT else OutputLevel.RATES
    return OutputLevel(output.value)


def source_of(name: str, kind: str) -> Source:
    """The file of a name in configs/ or a path; ``kind``: missions, vehicles or worlds. ConfigError: there is none."""
    path = find(name, kind)
    if kind == "missions" and is_plan(name):
        return Source(str(path), mission_text(path), (path.name, read(path)))
    text = read(path)
    return Source(str(path), text, attached(text, str(path)) if kind == "missions" else None)


@lru_cache(maxsize=DOCUMENTS)
def document_of(source: Source) -> Document:
    """A file, parsed. One that was made in Python has keys, but no lines that anybody could look up. Not to be changed:
    it may be given again."""
    return _without_lines(source, parse(source.text, source.name))


@lru_cache(maxsize=DOCUMENTS)
def mission_document(source: Source, *, plans: bool = True) -> Document:
    """The same of a mission, which may stand for a plan where ``plans``."""
    read = parse_plan_text if plans else parse
    return _without_lines(source, read(source.text, source.name))


def _without_lines(source: Source, document: Document) -> Document:
    return dataclasses.replace(document, lines=dict.fromkeys(document.lines, 0)) if source.made else document


def vehicle_source(asked_for: str | None, mission: Source | None) -> Source:
    """The vehicle's file: the one that is asked for, else the mission's own, else x500. Where the mission file names
    one that is not there, the fault is the mission's."""
    name = asked_for or _usual_vehicle(mission)
    try:
        return source_of(name, "vehicles")
    except ConfigError as error:
        if asked_for is not None or mission is None or name == DEFAULT_VEHICLE:
            raise
        document = mission_document(mission)
        said = [document.fault(("vehicle",), f"{name!r}: {fault.message}") for fault in error.faults]
        raise ConfigError(said) from None


def _usual_vehicle(mission: Source | None) -> str:
    return (None if mission is None else _own_vehicle(mission)) or DEFAULT_VEHICLE


def _own_vehicle(mission: Source) -> str | None:
    """The vehicle a mission file names, if it can be read at all."""
    try:
        data = parse(mission.text, mission.name).data
    except ConfigError:
        return None
    name = data.get("vehicle") if isinstance(data, dict) else None
    return name if isinstance(name, str) else None
