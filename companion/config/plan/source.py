"""Finding and reading the plan of a mission of kind plan; and a plan given in the place of a mission file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from companion.config.mission.path_keys import PlanModel
from companion.config.plan.polygons import is_polygon
from companion.config.plan.qgroundcontrol import plan_from
from companion.config.plan.to_mission import PlannedPath, prepare_plan
from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.syntax.file_lookup import read
from companion.geodesy import GivenHome
from companion.paths.placement import Placement
from companion.paths.tracing import PathError
from companion.plans.items import Plan, PlanError

SUFFIXES = (".plan", ".waypoints", ".mission")
"""Of ground stations' files; the last is an older one of QGroundControl's, which is refused as what it is."""
BEGINS = b"QGC WPL"
"""What a file of waypoints begins with."""


def is_plan(name: str) -> bool:
    """Whether a file is a plan and not a mission: by its name, or by its first line, for waypoint files are often
    called .txt."""
    if Path(name).suffix.lower() in SUFFIXES or is_polygon(name):
        return True
    try:
        with Path(name).open("rb") as file:
            return file.read(len(BEGINS) + 3).removeprefix(b"\xef\xbb\xbf").startswith(BEGINS)
    except (OSError, ValueError):
        return False


def mission_text(plan: Path) -> str:
    """The mission file that flies a plan as it is: its speeds at most, its headings, its corners rounded by a metre."""
    name, file = json.dumps(plan.stem[:80]), json.dumps(plan.name)
    return f"mission: {name}\nframe: ned\npath: {{kind: plan, file: {file}}}\nspeed: plan\nyaw: plan\n"


def parse_plan_text(text: str, file: str) -> Document:
    """The mission file in ``text``; faults of one that stands for a plan are told at the plan's top."""
    document = parse(text, file)
    if is_plan(file):
        return Document(file, document.data, dict.fromkeys(document.lines, 1))
    return document


def plan_path(document: Document, file: str, beside: Path | None) -> Path:
    """Where the plan ``file`` of a mission lies: seen from the mission file, or in ``beside`` by its last name."""
    return Path(document.file).parent / file if beside is None else beside / Path(file).name


def read_plan(
    document: Document, model: PlanModel, placement: Placement, beside: Path | None, given: GivenHome
) -> PlannedPath:
    """What a mission of kind plan flies. ``given``: of home, beside it. ConfigError with its every fault."""
    path = plan_path(document, model.file, beside)
    if not path.is_file():
        raise ConfigError([document.fault(("path", "file"), f"{path}: no such file; expected a .plan or a .waypoints")])
    plan, lines = plan_from(read(path), str(path))
    plan = replace(plan, home=given.over(plan.home))
    try:
        return prepare_plan(plan, model.corner_tolerance, model.smooth, placement, given.altitude, lines.line)
    except PlanError as error:
        raise ConfigError([lines.fault(problem.key, problem.message) for problem in error.problems]) from None
    except (ValueError, ArithmeticError, PathError) as error:
        raise ConfigError([Fault(str(path), 1, "", f"the path {error}")]) from None


def plan_of(name: str, given: GivenHome) -> Plan | None:
    """The plan that ``name`` is, with ``given`` of its home; None where it is a mission file. ConfigError with every
    fault."""
    if not is_plan(name):
        return None
    plan, _ = plan_from(read(Path(name)), name)
    return replace(plan, home=given.over(plan.home))


def attached(text: str, file: str) -> tuple[str, str] | None:
    """Name and text of the plan that a mission file needs beside it; None where it needs none, or cannot be read."""
    try:
        document = parse(text, file)
    except ConfigError:
        return None  # said where the mission is read
    path = document.data.get("path") if isinstance(document.data, dict) else None
    named = path.get("file") if isinstance(path, dict) and path.get("kind") == "plan" else None
    if not isinstance(named, str):
        return None
    found = plan_path(document, named, None)
    return (found.name, read(found)) if found.is_file() else None
