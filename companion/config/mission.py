"""Mission files: the path, and speed and yaw along it, in the words of whoever flies it."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from companion.calculus.expression import parse as parse_expression
from companion.config.along import faults_along
from companion.config.curves import curve_from, implicit_from, triple
from companion.config.document import Document, parse
from companion.config.faults import ConfigError, Fault
from companion.config.gains import GainsModel, gains_from
from companion.config.path_keys import ImplicitModel, PathModel, PlanModel, Point
from companion.config.places import find, read
from companion.config.profile_keys import (
    SPEED_MIN,
    AutoSpeedModel,
    LookAtModel,
    SpeedModel,
    SpeedTableModel,
    YawModel,
    YawTableModel,
)
from companion.config.profiles import Profiles, known_names
from companion.config.schema import Strict, validate
from companion.law.gains import Level
from companion.mission import GlobalOrigin, Mission, Origin, Path, Repeat, Start
from companion.paths.implicit import ImplicitPath
from companion.paths.placement import Placement

Three = Annotated[list[Annotated[float, Field(ge=-2000, le=2000)]], Field(min_length=3, max_length=3)]


class StartModel(Strict):
    """The state a simulated flight begins in."""

    position: Point
    """where, [x, y, z] in m"""
    velocity: Annotated[list[Annotated[float, Field(ge=-100, le=100)]], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0]
    )
    """how fast, [x, y, z] in m/s"""
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    """heading clockwise from north, in degrees"""
    pitch_deg: Annotated[float, Field(ge=-89.0, le=89.0)] = 0.0
    """pitch, nose up, in degrees"""
    roll_deg: Annotated[float, Field(ge=-179.0, le=179.0)] = 0.0
    """roll, right side down, in degrees"""
    rates_dps: Three = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """body rates [roll, pitch, yaw], in degrees per second"""


class MissionModel(Strict):
    """A mission file."""

    mission: Annotated[str, Field(min_length=1, max_length=80)]
    """the mission's name"""
    vehicle: str | None = None
    """the vehicle it was written for: a name in configs/vehicles or a path; --vehicle overrides it"""
    frame: Literal["ned", "enu"]
    """ned: x north, y east, z down; enu: x east, y north, z up; all in m"""
    origin: Literal["local", "takeoff", "home"] | Annotated[list[float], Field(min_length=3, max_length=3)] | None = (
        None
    )
    """what the coordinates count from: local, takeoff, home, or [latitude, longitude, altitude above sea level] in
    degrees and m"""
    rotate_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    """turns the mission's axes clockwise seen from above, in degrees; headings stay compass headings"""
    path: PathModel
    """the path, of one kind"""
    speed: SpeedModel
    """speed along the path: a number in m/s, an expression in x, y, z or s, {table: [[s, speed], ..]} or auto; its sign
    is the direction"""
    yaw: YawModel = 0.0
    """heading: degrees clockwise from north, an expression, tangent, {tangent: offset}, {look_at: [x, y, z]} or
    {table: [[s, degrees], ..]}"""
    gains: GainsModel = Field(default_factory=GainsModel)
    """the gains; the level's own where absent"""
    laps: Annotated[float, Field(gt=0.0, le=10000.0)] | None = None
    """how many times around, no unit; until told to stop where absent"""
    repeat: Literal["back-and-forth"] | None = None
    """what an open path does at its end: back-and-forth turns round; it ends there where absent"""
    start: StartModel | None = None
    """the state a simulated flight begins in; simulation only"""

    @field_validator("speed", "yaw")
    @classmethod
    def _parses(cls, given: Any, info: ValidationInfo) -> Any:
        path = info.data.get("path")
        word = {"speed": "auto", "yaw": "tangent"}[info.field_name or ""]
        if isinstance(given, str) and given != word:
            parse_expression(given, None if path is None else known_names(path))
        return given

    @field_validator("speed")
    @classmethod
    def _moves(cls, speed: Any) -> Any:
        if isinstance(speed, float) and abs(speed) < SPEED_MIN:
            raise ValueError(f"{speed:g} never moves; expected at least {SPEED_MIN:g} m/s either way")
        return speed


def load_mission(name: str, level: Level | None) -> Mission:
    """The mission of a name in configs/missions or a path, with gains for ``level``, its curve traced and its speed
    checked. ConfigError with every fault."""
    path = find(name, "missions")
    return mission_from(parse(read(path), str(path)), level)


def bare_mission_from(document: Document, level: Level) -> Mission:
    """The mission for ``companion law``: gains are taken as given, and the curve need not close."""
    model = validate(document, MissionModel)
    if not isinstance(model.path, ImplicitModel):
        message = f"{model.path.kind} has no h1 and h2; companion law expects kind: implicit"
        raise ConfigError([document.fault(("path", "kind"), message)])
    faults = [
        document.fault((key,), "is given over arc length; companion law expects a number or an expression in x, y, z")
        for key in ("speed", "yaw")
        if isinstance(getattr(model, key), SpeedTableModel | YawTableModel | AutoSpeedModel)
        or getattr(model, key) == "auto"
    ]
    mission = _mission(document, model, level, faults, check=False)
    if faults or mission is None:
        raise ConfigError(faults)
    return mission


def mission_from(document: Document, level: Level | None) -> Mission:
    """The mission a document describes. ConfigError with every fault."""
    model = validate(document, MissionModel)
    faults: list[Fault] = []
    mission = _mission(document, model, level, faults, check=True)
    if mission is not None and isinstance(mission.path, ImplicitPath) and mission.path.near is None:
        faults.append(document.fault(("path", "near"), "missing; expected a point [x, y, z] near the path, in m"))
    elif mission is not None:
        faults += faults_along(document, mission)
    if faults or mission is None:
        raise ConfigError(faults)
    return mission


def _mission(
    document: Document, model: MissionModel, level: Level | None, faults: list[Fault], *, check: bool
) -> Mission | None:
    gains = None if level is None else gains_from(document, model.gains, level, faults, check=check)
    placement = Placement(turn=math.radians(model.rotate_deg), enu=model.frame == "enu")
    path: Path | None
    if isinstance(model.path, ImplicitModel):
        path = implicit_from(model.path, None if model.start is None else model.start.position, placement)
    elif isinstance(model.path, PlanModel):
        path = None
        faults.append(document.fault(("path", "kind"), "plan is not read yet"))
    else:
        path = curve_from(document, model.path, placement, faults)
        if gains is not None and gains.h1 != gains.h2:
            message = "differ from those of h1; on a curve one set serves every direction across it"
            faults.append(document.fault(("gains", "h2"), message))
    if path is None:
        return None
    profiles = Profiles(document, model.path, path, faults)
    speed, yaw = profiles.speed(model.speed), profiles.yaw(model.yaw)
    if speed is None or yaw is None:
        return None
    mission = Mission(
        name=model.mission,
        path=path,
        speed=speed,
        yaw=yaw,
        gains=gains,
        laps=model.laps,
        start=None if model.start is None else _start(model.start),
        origin=_origin(model.origin),
        vehicle=model.vehicle,
        look_at=triple(model.yaw.look_at) if isinstance(model.yaw, LookAtModel) else None,
        repeat=None if model.repeat is None else Repeat(model.repeat),
    )
    if mission.repeat is not None and mission.closed:
        faults.append(document.fault(("repeat",), "the path is closed; expected an open one to fly back and forth"))
    return mission.placed((0.0, 0.0, 0.0))


def _origin(given: str | list[float] | None) -> Origin | GlobalOrigin | None:
    if given is None:
        return None
    return Origin(given) if isinstance(given, str) else GlobalOrigin(given[0], given[1], given[2])


def _start(model: StartModel) -> Start:
    roll, pitch, yaw = map(math.radians, model.rates_dps)
    return Start(
        position=triple(model.position),
        velocity=triple(model.velocity),
        heading=math.radians(model.heading_deg),
        pitch=math.radians(model.pitch_deg),
        roll=math.radians(model.roll_deg),
        rates_b=(roll, pitch, yaw),
    )
