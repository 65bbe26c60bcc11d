"""``export``: a mission as a plan that a ground station draws, and as a table."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

from companion.cli.check import check_sortie
from companion.cli.output import Output
from companion.cli.terminal import say
from companion.cli.writing import writable, write
from companion.config.plan.source import plan_of
from companion.config.syntax.faults import ConfigError, Fault
from companion.geodesy import NO_HOME_GIVEN, LocalFrame
from companion.library.faults import Faults
from companion.library.orders import given_home, read_sortie
from companion.library.simulation import at_home
from companion.mission import GlobalOrigin, Mission
from companion.places.drawn import waypoint_plan
from companion.places.listed import COLUMNS, rows_along
from companion.plans.items import Plan
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
    given = faults.collect(lambda: given_home(home)) or NO_HOME_GIVEN
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, Output.AUTO, given=given))
    at = Home() if home is None else Home(*given)  # type: ignore[arg-type]
    if plan is None and table is None:
        faults.add(Fault("--plan", 0, "", "missing; expected a file to write, here or with --csv"))
    for option, file in (("--plan", plan), ("--csv", table)):
        if file is not None:
            faults.collect(lambda option=option, file=file: writable(option, file, force))  # type: ignore[misc]
    faults.raise_any()
    assert sortie is not None
    known = _knows_home(sortie.mission)
    if table is not None and not known:
        message = f"missing; {mission} does not say how high its home lies, and the table has heights above the sea"
        raise ConfigError([Fault("--home", 0, "", message)])
    own = None if plan is None else plan_of(mission, given)
    if plan is not None and own is not None:
        _write_plan(plan, own, "the plan's own, all written out")
        if table is None:
            return
    sortie, _ = check_sortie(sortie)
    placed, world = at_home(sortie.mission, World(home=at))
    frame = LocalFrame(world.home.latitude, world.home.longitude, world.home.altitude)
    if home is None and not isinstance(placed.origin, GlobalOrigin):
        say(f"note: home is taken to be {frame.latitude}, {frame.longitude}, {frame.altitude} m; --home says another")
    if plan is not None and own is None:
        found = waypoint_plan(placed, frame, tolerance)
        if not known and found.home is not None:
            found = replace(found, home=found.home._replace(altitude=None))
        _write_plan(plan, found, f"the legs within {tolerance:g} m of the path")
        if len(found.items) > MANY:
            say(f"note: not every autopilot takes more than {MANY} items; a larger --tolerance needs fewer")
    if table is not None:
        _write_table(table, placed, frame, spacing)


def _write_plan(file: Path, found: Plan, how: str) -> None:
    write(file, plan_text(found))
    say(f"{file}: {len(found.items)} items, {how}")


def _write_table(file: Path, placed: Mission, frame: LocalFrame, spacing: float) -> None:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    rows = 0
    for row in rows_along(placed, frame, spacing):
        writer.writerow(f"{value:.{DIGITS.get(name, 6)}f}" for name, value in zip(COLUMNS, row, strict=True))
        rows += 1
    write(file, out.getvalue())
    say(f"{file}: {rows} rows, {placed.table.length:.2f} m")


def _knows_home(mission: Mission) -> bool:
    """Whether it is known how high home lies, where the mission's heights count from there."""
    origin, home = mission.origin, mission.home
    relative = isinstance(origin, GlobalOrigin) and origin.above_home
    return not relative or (home is not None and home.altitude is not None)
