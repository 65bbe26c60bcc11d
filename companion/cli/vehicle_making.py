"""``vehicle from`` and ``from-log``: a vehicle file of what PX4 says of itself, and of a log."""

from __future__ import annotations

import datetime
from pathlib import Path

from companion.cli.check import plottable
from companion.cli.finish import BAD_INPUT, COMPLETED, NO_VEHICLE, refuse
from companion.cli.terminal import busy, say, tell, warn
from companion.cli.writing import writable, write
from companion.config.json_schemas import editor_line
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.syntax.file_lookup import find, read
from companion.config.vehicle import vehicle_from
from companion.identification.description import Description, of_file
from companion.identification.from_log import Findings, better_log, identify, simulator_words, with_findings, words_of
from companion.identification.parameters import describe_parameters
from companion.identification.quadrotor import refuse_others
from companion.identification.ulog import Log
from companion.identification.ulog import read as read_log
from companion.services.vehicle import NoVehicleHeardError, ServiceError, connect_vehicle


def from_px4(url: str, file: Path, mass: float | None, arm: float | None, force: bool) -> int:
    """Ask the vehicle at ``url`` and write ``file``; the exit code."""
    writable("FILE", file, force)
    try:
        with connect_vehicle(url) as vehicle:
            say("reading its parameters")
            values, identity = vehicle.parameters(), vehicle.identity()
    except NoVehicleHeardError as error:
        say(str(error))
        return NO_VEHICLE
    except ServiceError as error:
        return refuse(str(error), as_json=False, what="nothing written")
    origin = (f"Made by companion vehicle from on {datetime.date.today()}, of {identity}.",)
    return keep(describe_parameters(values, name=file.stem, origin=origin, mass=mass, arm=arm), file)


def from_log(
    log_file: Path,
    file: Path,
    vehicle: str | None,
    mass: float | None,
    arm: float | None,
    plot: Path | None,
    force: bool,
) -> int:
    """Read a log and write ``file``; the exit code. ``vehicle``: what is updated; None: ``file``, where it is there,
    else what PX4's parameters say."""
    writable("FILE", file, force)
    if plot is not None:
        plottable(plot)
    known = vehicle if vehicle is not None else str(file) if file.exists() else None
    try:
        with log_file.open("rb") as opened:
            log = read_log(opened, log_file.name)
    except OSError as error:
        raise ConfigError([Fault("LOG", 0, "", f"{log_file}: cannot be read: {error.strerror}")]) from None
    base = _base(log, file, known, mass, arm)
    with busy(f"fitting {log_file.name}"):
        found = identify(log)
    simulated = simulator_words(log)
    for line in (*simulated, *words_of(found)):
        tell(f"  {line}")
    advice = better_log(found)
    for line in advice:
        tell(f"a better log: {line}")
    if not advice:
        tell("every value could be taken from the log")
    made = f"Made by companion vehicle from-log on {datetime.date.today()}, of {log_file.name}: {log.identity}."
    code = keep(with_findings(base, found, (made, *simulated)), file)
    if plot is not None:
        _draw(found, plot)
    return code


def _base(log: Log, file: Path, known: str | None, mass: float | None, arm: float | None) -> Description:
    """What the log's findings are written over. CompanionError: the log is of another kind of vehicle; ConfigError: the
    file that is known has faults."""
    refuse_others(log.parameters)
    if known is None:
        return describe_parameters(log.parameters, name=file.stem, mass=mass, arm=arm)
    for option, given in (("--mass", mass), ("--arm", arm)):
        if given is not None:
            raise ConfigError([Fault(option, 0, "", f"{known} says it already; change it there")])
    source = find(known, "vehicles")
    text = read(source)
    document = parse(text, str(source))
    vehicle_from(document)  # every fault of it
    return of_file(document.data, document.lines, text)


def _draw(found: Findings, plot: Path) -> None:
    from companion.identification.picture import picture

    try:
        picture(found).savefig(plot)
    except OSError as error:
        raise ConfigError([Fault(str(plot), 0, "", f"cannot be written: {error.strerror}")]) from None
    say(f"picture: {plot}")


def keep(found: Description, file: Path) -> int:
    """Write a vehicle file and say what is open; the exit code. What would not load is never written over anything."""
    text = editor_line("vehicle.schema.json") + found.text
    old = file.exists()
    try:
        vehicle_from(parse(text, f"new {file}" if old else str(file)))
    except ConfigError as error:
        if old:
            warn(f"{file} is left as it was; what was to be written cannot all be true:\n{error}")
        else:
            write(file, text)
            warn(f"{file}: written, but it cannot all be true; correct it before it is flown:\n{error}")
        return BAD_INPUT
    write(file, text)
    tell(f"{file}: written")
    if found.unmeasured:
        tell(f"to be measured by you: {', '.join(found.unmeasured)} (marked MEASURE in the file)")
    tell(f"next: companion check circle_r5 --vehicle {file}")
    return COMPLETED
