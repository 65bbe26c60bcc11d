"""``vehicle from``: a vehicle file of what PX4 says of itself."""

from __future__ import annotations

import datetime
from pathlib import Path

from companion.cli.export import writable, write
from companion.cli.finish import COMPLETED, NO_VEHICLE, refuse
from companion.cli.terminal import say, tell, warn
from companion.config.json_schemas import editor_line
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.config.vehicle import vehicle_from
from companion.identification.description import Description
from companion.identification.parameters import described
from companion.services.vehicle import ServiceError, connected


def from_px4(url: str, file: Path, mass: float | None, arm: float | None, force: bool) -> int:
    """Ask the vehicle at ``url`` and write ``file``; the exit code."""
    writable("FILE", file, force)
    with connected(url) as vehicle:
        if vehicle is None:
            say(f"no vehicle: no autopilot was heard on {url} within 10 s; is it on, and does it send here?")
            return NO_VEHICLE
        say("reading its parameters")
        try:
            values, identity = vehicle.parameters(), vehicle.identity()
        except ServiceError as error:
            return refuse(str(error), as_json=False, what="nothing written")
    origin = (f"Made by companion vehicle from on {datetime.date.today()}, of {identity}.",)
    return keep(described(values, name=file.stem, origin=origin, mass=mass, arm=arm), file)


def keep(found: Description, file: Path) -> int:
    """Write a vehicle file and say what is open; the exit code."""
    text = editor_line("vehicle.schema.json") + found.text
    write(file, text)
    tell(f"{file}: written")
    if found.unmeasured:
        tell(f"to be measured by you: {', '.join(found.unmeasured)} (marked MEASURE in the file)")
    try:
        vehicle_from(parse(text, str(file)))
    except ConfigError as error:
        warn(f"the file holds what cannot all be true; correct it before it is flown:\n{error}")
        return COMPLETED
    tell(f"next: companion check circle_r5 --vehicle {file}")
    return COMPLETED
