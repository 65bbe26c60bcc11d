"""``export``: a mission as a plan that a ground station draws, and as a table."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from companion.cli.check import looked_at
from companion.cli.orders import Faults, read_sortie
from companion.cli.output import Output
from companion.cli.simulate import at_home
from companion.cli.terminal import say
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.world.world import home_from
from companion.geodesy import LocalFrame
from companion.mission import GlobalOrigin
from companion.places.drawn import drawn
from companion.places.listed import COLUMNS, listed
from companion.plans.writing import plan_text
from companion.world import Home, World

MANY = 500
"""Items that every PX4 takes."""
DIGITS = {"latitude_deg": 9, "longitude_deg": 9}


def export(
    mission: str, vehicle: str | None, plan: Path | None, table: Path | None, home: str | None, tolerance: float,
    spacing: float, force: bool,
) -> None:  # fmt: skip
    """Write the files. ConfigError: with every reason why they cannot be."""
    faults = Faults()
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, Output.AUTO))
    at = faults.collect(lambda: Home() if home is None else home_from(home, "--home"))
    if plan is None and table is None:
        faults.add(Fault("--plan", 0, "", "missing; expected a file to write, here or with --csv"))
    for option, file in (("--plan", plan), ("--csv", table)):
        if file is not None:
            faults.collect(lambda option=option, file=file: writable(option, file, force))  # type: ignore[misc]
    faults.raise_any()
    assert sortie is not None and at is not None
    sortie, _ = looked_at(sortie)
    placed, world = at_home(sortie.mission, World(home=at))
    frame = LocalFrame(world.home.latitude, world.home.longitude, world.home.altitude)
    if home is None and not isinstance(placed.origin, GlobalOrigin):
        say(f"note: home is taken to be {frame.latitude}, {frame.longitude}, {frame.altitude} m; --home says another")
    if plan is not None:
        found = drawn(placed, frame, tolerance)
        write(plan, plan_text(found))
        say(f"{plan}: {len(found.items)} items, the legs within {tolerance:g} m of the path")
        if len(found.items) > MANY:
            say(f"note: not every autopilot takes more than {MANY} items; a larger --tolerance needs fewer")
    if table is not None:
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        rows = 0
        for row in listed(placed, frame, spacing):
            writer.writerow(f"{value:.{DIGITS.get(name, 6)}f}" for name, value in zip(COLUMNS, row, strict=True))
            rows += 1
        write(table, out.getvalue())
        say(f"{table}: {rows} rows, {placed.table.length:.2f} m")


def writable(option: str, file: Path, force: bool) -> None:
    """ConfigError: the file is there already, or cannot be written where it is to be."""
    if file.exists() and (file.is_dir() or not force):
        message = f"{file}: is a folder" if file.is_dir() else f"{file}: exists already; --force writes over it"
        raise ConfigError([Fault(option, 0, "", message)])
    if not file.parent.is_dir():
        raise ConfigError([Fault(option, 0, "", f"{file.parent}: no such folder")])


def write(file: Path, text: str) -> None:
    """ConfigError: it cannot be written."""
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError([Fault(str(file), 0, "", f"cannot be written: {error.strerror}")]) from None
