"""Mission files: the path, and speed and yaw along it, in the words of whoever flies it."""

from __future__ import annotations

import difflib
import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from companion.calculus.expression import CONSTANTS
from companion.calculus.expression import parse as parse_expression
from companion.config.mission.along import faults_along
from companion.config.mission.curves import curve_from, implicit_from, triple
from companion.config.mission.earth import localised
from companion.config.mission.fence_keys import FenceModel, fence_from
from companion.config.mission.gains import GainsModel, GainsOrAuto, gains_from
from companion.config.mission.path_keys import ImplicitModel, OriginModel, PathModel, PlanModel, Point
from companion.config.mission.profile_keys import (
    SPEED_MIN,
    AutoSpeedModel,
    Degrees,
    LookAtModel,
    SpeedModel,
    SpeedTableModel,
    YawModel,
    YawTableModel,
)
from companion.config.mission.profiles import Profiles, constant_in_degrees, known_names
from companion.config.plan.source import is_plan, mission_text, parse_plan_text, read_plan
from companion.config.plan.to_mission import PlannedPath
from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError, Fault, Key
from companion.config.syntax.file_lookup import find, read
from companion.config.syntax.schema import Strict, validate
from companion.fence import Fence
from companion.frames import Heading, Vec3
from companion.geodesy import NO_HOME_GIVEN, GivenHome
from companion.law.gains import Level
from companion.mission import GlobalOrigin, Mission, Origin, Repeat, Start
from companion.mission import Path as MissionPath
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
    heading_deg: Degrees = 0.0
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
    origin: OriginModel = None
    """what the coordinates count from: local (the vehicle's own frame), takeoff, home, or [latitude, longitude,
    altitude above sea level] in degrees and m"""
    rotate_deg: Degrees = 0.0
    """turns the mission's axes clockwise seen from above, in degrees; headings stay compass headings"""
    path: PathModel
    """the path, of one kind"""
    speed: SpeedModel
    """speed along the path: a number in m/s, an expression in x, y, z or s, {table: [[s, speed], ..]} or auto; its sign
    is the direction"""
    yaw: YawModel = 0.0
    """heading: degrees clockwise from north, an expression, tangent, {tangent: offset}, {look_at: [x, y, z]} or
    {table: [[s, degrees], ..]}"""
    heading: Literal["projected", "twist"] = "projected"
    """which heading of a leaning vehicle yaw is: projected (of its nose seen from above) or twist (of its nose once it
    is swung upright), which steep flight holds without turning hard"""
    gains: GainsOrAuto = Field(default_factory=GainsModel)
    """the gains, or auto: chosen for the vehicle before the flight; auto where absent"""
    laps: Annotated[float, Field(gt=0.0, le=10000.0)] | None = None
    """how many times around, no unit; until told to stop where absent"""
    repeat: Literal["back-and-forth"] | None = None
    """what an open path does at its end: back-and-forth turns round; it ends there where absent"""
    fence: Annotated[list[FenceModel], Field(max_length=100)] = Field(default_factory=list)
    """where the vehicle may be: a list of areas to stay inside of or out of"""
    start: StartModel | None = None
    """the state a simulated flight begins in; simulation only"""

    @field_validator("speed", "yaw")
    @classmethod
    def _parses(cls, given: Any, info: ValidationInfo) -> Any:
        path = info.data.get("path")
        word = {"speed": "auto", "yaw": "tangent"}[info.field_name or ""]
        if given == "plan" and path is not None and path.kind != "plan":
            raise ValueError(f"'plan' means what the plan says, and the path is no plan but of kind {path.kind}")
        if isinstance(given, str) and given.isidentifier() and path is not None and given not in (word, "plan"):
            known = known_names(path)
            if given not in (*known, *CONSTANTS):
                close = difflib.get_close_matches(given, [word, *known], 1)
                hint = f"did you mean {close[0]}?" if close else f"expected {word}, a number, or an expression"
                raise ValueError(f"{given!r} is not known; {hint}")
        if isinstance(given, str) and given not in (word, "plan"):
            parse_expression(given, None if path is None else known_names(path))
            if info.field_name == "yaw":
                constant_in_degrees(given)
        return given

    @field_validator("speed")
    @classmethod
    def _moves(cls, speed: Any) -> Any:
        if isinstance(speed, float) and abs(speed) < SPEED_MIN:
            raise ValueError(f"{speed:g} never moves; expected at least {SPEED_MIN:g} m/s either way")
        return speed


def load_mission(name: str, level: Level | None, given: GivenHome = NO_HOME_GIVEN) -> Mission:
    """The mission of a name in configs/missions or a path, with gains for ``level``, its curve traced and its speed
    checked. ``given``: of home, beside the file. ConfigError with every fault."""
    path = find(name, "missions")
    if is_plan(name):
        return mission_from(parse_plan_text(mission_text(path), str(path)), level, given=given)
    return mission_from(parse(read(path), str(path)), level, given=given)


def bare_mission_from(document: Document, level: Level) -> Mission:
    """The mission for ``companion law``: gains are taken as given, and the curve need not close."""
    document, origin = localised(document)
    model = validate(document, MissionModel)
    if not isinstance(model.path, ImplicitModel):
        message = f"{model.path.kind} has no h1 and h2; companion law expects kind: implicit"
        raise ConfigError([document.fault(("path", "kind"), message)])
    over_arc = [
        document.fault((key,), "is given over arc length; companion law expects a number or an expression in x, y, z")
        for key in ("speed", "yaw")
        if isinstance(getattr(model, key), SpeedTableModel | YawTableModel | AutoSpeedModel)
        or getattr(model, key) == "auto"
    ]
    reader = _Reader(document, model, origin or _origin(model.origin), None)
    reader.faults += over_arc
    mission = reader.mission(level, check=False)
    if reader.faults or mission is None:
        raise ConfigError(reader.faults)
    return mission


def mission_from(
    document: Document, level: Level | None, beside: Path | None = None, given: GivenHome = NO_HOME_GIVEN, *,
    simulated: bool = False,
) -> Mission:  # fmt: skip
    """The mission a document describes. ``beside``: the folder its plan lies in, if it has one; None: as it says.
    ``given``: of home, beside the file. ``simulated``: gains slower than advised are noted and
    not refused. ConfigError with every fault."""
    document, origin = localised(document)
    model = validate(document, MissionModel)
    reader = _Reader(document, model, origin or _origin(model.origin), beside, given)
    mission = reader.mission(level, check=True, simulated=simulated)
    faults = reader.faults
    if mission is not None and isinstance(mission.path, ImplicitPath) and mission.path.near is None:
        faults.append(document.fault(("path", "near"), "missing; expected a point [x, y, z] near the path, in m"))
    elif mission is not None:
        faults += faults_along(document, mission)
    if faults or mission is None:
        raise ConfigError(faults)
    return mission


class _Reader:
    """Makes the mission of one document; what is wrong with it goes into ``faults``."""

    def __init__(
        self, document: Document, model: MissionModel, origin: Origin | GlobalOrigin | None, beside: Path | None,
        given: GivenHome = NO_HOME_GIVEN,
    ) -> None:  # fmt: skip
        self._document, self._model, self._origin, self._beside, self._given = document, model, origin, beside, given
        self._placement = Placement(turn=math.radians(model.rotate_deg), enu=model.frame == "enu")
        self._plan: PlannedPath | None = None
        self.faults: list[Fault] = []

    def mission(self, level: Level | None, *, check: bool, simulated: bool = False) -> Mission | None:
        """The mission, its origin at the local frame's; None where there is none."""
        model, plan = self._model, None
        noted: list[str] | None = [] if simulated else None
        gains = None
        if level is not None:
            gains = gains_from(self._document, model.gains, level, self.faults, check=check, notes=noted)
        path = self._path()
        if path is None:
            return None
        if not isinstance(path, ImplicitPath) and gains is not None and gains.h1 != gains.h2:
            message = "differ from those of h1; on a curve one set serves every direction across it"
            self._fault(("gains", "h2"), message)
        plan = self._plan
        profiles = Profiles(self._document, model.path, path, self.faults, plan)
        yaw_given = model.yaw if plan is None or "yaw" in model.model_fields_set else "plan"
        speed, yaw = profiles.speed(model.speed), profiles.yaw(yaw_given)
        if speed is None or yaw is None:
            return None
        if isinstance(yaw_given, LookAtModel):
            look_at: Vec3 | None = triple(yaw_given.look_at)
        else:
            look_at = plan.look_at if plan is not None and yaw_given == "plan" else None
        mission = Mission(
            name=model.mission,
            path=path,
            speed=speed,
            yaw=yaw,
            gains=gains,
            laps=model.laps,
            start=None if model.start is None else _start(model.start),
            origin=plan.origin if plan is not None and self._origin is None else self._origin,
            vehicle=model.vehicle,
            heading=Heading(model.heading),
            look_at=look_at,
            repeat=None if model.repeat is None else Repeat(model.repeat),
            fence=_both(fence_from(model.fence), None if plan is None else plan.fence),
            notes=(*(() if plan is None else plan.notes), *(noted or ())),
            home=self._given.over(None) if plan is None else plan.home,
            given_home=self._given,
            mixed_heights=plan is not None and plan.mixed_heights,
            actions=() if plan is None else plan.actions,
            from_plan=plan is not None,
        )
        if mission.repeat is not None and mission.closed:
            self._fault(("repeat",), "the path is closed; expected an open one to fly back and forth")
        return mission.placed((0.0, 0.0, 0.0))

    def _path(self) -> MissionPath | None:
        model = self._model
        if isinstance(model.path, ImplicitModel):
            return implicit_from(model.path, None if model.start is None else model.start.position, self._placement)
        if not isinstance(model.path, PlanModel):
            return curve_from(self._document, model.path, self._placement, self.faults)
        if isinstance(self._origin, GlobalOrigin):
            message = "a plan counts from its own home; expected none, or local, takeoff or home to fly it from there"
            self._fault(("origin",), message)
        if model.rotate_deg != 0.0:
            self._fault(("rotate_deg",), "a plan is not turned; expected none")
        try:
            self._plan = read_plan(self._document, model.path, self._placement, self._beside, self._given)
        except ConfigError as error:
            self.faults += error.faults
            return None
        return self._plan.curve

    def _fault(self, key: Key, message: str) -> None:
        self.faults.append(self._document.fault(key, message))


def _both(first: Fence | None, second: Fence | None) -> Fence | None:
    if first is None or second is None:
        return first or second
    return Fence((*first.areas, *second.areas))


def _origin(given: str | list[float] | None) -> Origin | None:
    return Origin(given) if isinstance(given, str) else None


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
