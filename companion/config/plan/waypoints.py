"""The older text format of waypoints, QGC WPL 110 and 120: a line an item, twelve fields between tabs -> plans."""

from __future__ import annotations

import math
from pathlib import Path

from companion.config.syntax.document import Document
from companion.config.syntax.faults import ConfigError, Fault, Key
from companion.geodesy import Home
from companion.mavlink_common import MAV_CMD_NAV_WAYPOINT
from companion.plans.areas import areas_among
from companion.plans.items import AMSL_FRAMES, Item, Plan, PlanError

HOME_LINE: Key = ("home line",)
"""Where home stands in such a file: its first item, where that is one."""
FAULTS_MAX = 50
"""faults told of one file: more are the same one again."""


def is_waypoints(text: str, file: str) -> bool:
    """Whether a file is of this format, by its name or by its first line."""
    return Path(file).suffix.lower() == ".waypoints" or text.removeprefix("\ufeff").startswith("QGC WPL")


def waypoints_from(text: str, file: str) -> tuple[Plan, Document]:
    """The plan in a file's ``text``, and the document that knows its lines. ConfigError with every fault."""
    lines = text.removeprefix("\ufeff").splitlines()
    header = lines[0].split() if lines else []
    if header[:2] != ["QGC", "WPL"] or header[2:] not in (["110"], ["120"]):
        raise ConfigError([Fault(file, 1, "", 'expected the first line "QGC WPL 110"')])
    faults: list[Fault] = []
    where: dict[Key, int] = {(): 1}
    items: list[Item] = []
    for number, line in enumerate(lines[1:], 2):
        if not line.strip() or line.startswith("#"):
            continue
        fields = line.split()
        try:
            values = [float(field) for field in fields]
            index, command, frame = (int(fields[i]) for i in (0, 3, 2))
        except (ValueError, IndexError):
            faults.append(Fault(file, number, "", "expected numbers between tabs: index, current, frame, command, ..."))
            continue
        if len(values) != 12 or any(map(math.isinf, values)):
            faults.append(Fault(file, number, "", f"{len(values)} fields; expected 12, all finite"))
            continue
        key: Key = ("item", index)
        where[key] = number
        items.append(Item(command, frame, tuple(values[4:11]), index, key))
    if faults:
        raise ConfigError(faults[:FAULTS_MAX])
    first = items[0] if items else None
    home, home_key, notes = None, Key(), tuple[str, ...]()
    if header[2] == "110" and first is not None and _is_home(first):
        latitude, longitude, altitude = first.params[4:7]
        known = (latitude, longitude) != (0.0, 0.0) and all(map(math.isfinite, first.params[4:7]))
        home = Home(latitude, longitude, altitude or None) if known else None
        home_key = HOME_LINE
        where[HOME_LINE] = where[first.key]
        notes = ("the first line is taken for home, as QGroundControl does",)
        items = items[1:]
    document = Document(file, None, where)
    try:
        fence, items = areas_among(items)
    except PlanError as error:
        raise ConfigError([document.fault(problem.key, problem.message) for problem in error.problems]) from None
    return Plan(tuple(items), home, fence=fence, notes=notes, home_key=home_key, items_key=()), document


def _is_home(first: Item) -> bool:
    """Whether the first item of a file stands for home: a waypoint above the sea, on the ground, or nothing at all."""
    if first.number == first.command == 0 and not any(first.params[4:7]):
        return True
    return first.command == MAV_CMD_NAV_WAYPOINT and (first.frame in AMSL_FRAMES or first.params[6] == 0.0)
