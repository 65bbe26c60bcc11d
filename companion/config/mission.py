"""Mission files: the path, and speed and yaw along it, in the words of whoever flies it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator

from companion.calculus.expression import CONSTANTS, FUNCTIONS
from companion.calculus.expression import parse as parse_expression
from companion.config.document import Document, parse
from companion.config.faults import ConfigError, Fault
from companion.config.places import find, read
from companion.config.schema import Strict, validate
from companion.frames import Vec3
from companion.law.gains import Gains, Level, default_gains, from_poles, poles_of
from companion.mission import GlobalOrigin, Mission, Origin, Start
from companion.paths.implicit import VARIABLES, ImplicitPath
from companion.paths.placement import Placement
from companion.paths.tracing import PathError
from companion.profiles import (
    ConstantSpeed,
    ConstantYaw,
    LookAt,
    Speed,
    SpeedExpression,
    TangentYaw,
    Yaw,
    YawExpression,
)

Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Point = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Place = Annotated[list[float], Field(min_length=3, max_length=3)]
Numbers = Annotated[list[float], Field(min_length=1, max_length=4)]


class ImplicitModel(Strict):
    """A path given as in the paper: the points where h1 = h2 = 0."""

    kind: Literal["implicit"]
    """the kind of path"""
    constants: dict[str, float] = Field(default_factory=dict)
    """names for numbers in the expressions, e.g. {r: 10}"""
    h1: str
    """an expression in x, y, z and the constants that is zero on the path"""
    h2: str
    """an expression in x, y, z and the constants that is zero on the path"""
    near: Point | None = None
    """a point [x, y, z] near the part of h1 = h2 = 0 that is meant, in m"""

    @field_validator("constants")
    @classmethod
    def _names_of_their_own(cls, constants: dict[str, float]) -> dict[str, float]:
        for name in constants:
            if not name.isidentifier() or name in (*VARIABLES, "s", *CONSTANTS, *FUNCTIONS):
                raise ValueError(f"{name!r} cannot name a constant; expected a word that means nothing else here")
        return constants

    @field_validator("h1", "h2")
    @classmethod
    def _parses(cls, text: str, info: ValidationInfo) -> str:
        if "constants" in info.data:
            parse_expression(text, (*VARIABLES, *info.data["constants"]))
        return text


class LookAtModel(Strict):
    """Always face one point."""

    look_at: Point
    """the point [x, y, z] to face, in m"""


class TangentModel(Strict):
    """Face along the path."""

    tangent: Annotated[float, Field(ge=-360.0, le=360.0)]
    """degrees to add to the heading of travel"""


class PolesModel(Strict):
    """Where the roots of the error dynamics lie."""

    path: Numbers | None = None
    """the roots for h1 and h2, negative: 4 at motors, 3 at rates"""
    speed: Numbers | None = None
    """the roots for h3, negative: 3 at motors, 2 at rates"""
    yaw: Numbers | None = None
    """the roots for h4, negative: 2 at motors, 1 at rates"""

    @field_validator("path", "speed", "yaw")
    @classmethod
    def _stable(cls, poles: list[float] | None) -> list[float] | None:
        if poles is not None and max(poles) >= 0.0:
            raise ValueError(f"{poles} is not stable; expected negative numbers")
        return poles


class GainsModel(Strict):
    """How hard errors are driven out: poles, or the gains themselves."""

    poles: PolesModel | None = None
    """the roots of the error dynamics, e.g. {path: [-2, -2, -2, -2], speed: [-2, -2, -2], yaw: [-2, -2]}"""
    h1: Numbers | None = None
    """gains k0, k1, .. of h1: as many as its order at the level flown"""
    h2: Numbers | None = None
    """gains k0, k1, .. of h2: as many as its order at the level flown"""
    h3: Numbers | None = None
    """gains k0, k1, .. of h3: as many as its order at the level flown"""
    h4: Numbers | None = None
    """gains k0, k1, .. of h4: as many as its order at the level flown"""


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
    rates_dps: Annotated[list[Annotated[float, Field(ge=-2000, le=2000)]], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0]
    )
    """body rates [roll, pitch, yaw], in degrees per second"""


def _form(value: Any) -> str:
    """Which of the forms below a speed or a yaw has."""
    if isinstance(value, bool) or value is None:
        return "a number"
    if isinstance(value, int | float):
        return "a number"
    if isinstance(value, str):
        return "an expression"
    if isinstance(value, dict) and "look_at" in value:
        return "a point to face"
    return "a mapping"


class MissionModel(Strict):
    """A mission file."""

    mission: Annotated[str, Field(min_length=1, max_length=80)]
    """the mission's name"""
    vehicle: str | None = None
    """the vehicle it was written for: a name in configs/vehicles or a path; --vehicle overrides it"""
    frame: Literal["ned", "enu"]
    """ned: x north, y east, z down; enu: x east, y north, z up"""
    origin: Literal["local", "takeoff", "home"] | Annotated[list[float], Field(min_length=3, max_length=3)] | None = (
        None
    )
    """what the coordinates count from: local, takeoff, home, or [latitude, longitude, altitude above sea level]"""
    rotate_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    """turns the mission's axes clockwise seen from above, in degrees; headings stay compass headings"""
    path: Annotated[ImplicitModel, Field()]
    """the path, of one kind"""
    speed: Annotated[
        Annotated[Annotated[float, Field(ge=-100.0, le=100.0)], Tag("a number")] | Annotated[str, Tag("an expression")],
        Discriminator(_form),
    ]
    """speed along the path: a number in m/s or an expression in x, y, z; its sign is the direction"""
    yaw: Annotated[
        Annotated[Annotated[float, Field(ge=-360.0, le=360.0)], Tag("a number")]
        | Annotated[str, Tag("an expression")]
        | Annotated[LookAtModel, Tag("a point to face")]
        | Annotated[TangentModel, Tag("a mapping")],
        Discriminator(_form),
    ] = 0.0
    """heading: degrees clockwise from north, an expression, tangent, {tangent: offset} or {look_at: [x, y, z]}"""
    gains: GainsModel = Field(default_factory=GainsModel)
    """the gains; the level's own where absent"""
    laps: Annotated[float, Field(gt=0.0, le=10000.0)] | None = None
    """how many times around; until told to stop where absent"""
    start: StartModel | None = None
    """the state a simulated flight begins in; simulation only"""

    @field_validator("speed", "yaw")
    @classmethod
    def _parses(cls, given: Any, info: ValidationInfo) -> Any:
        path = info.data.get("path")
        if isinstance(given, str) and given != "tangent":
            parse_expression(given, None if path is None else (*VARIABLES, *path.constants))
        return given

    @field_validator("speed")
    @classmethod
    def _moves(cls, speed: Any) -> Any:
        if isinstance(speed, float) and abs(speed) < SPEED_MIN:
            raise ValueError(f"{speed:g} never moves; expected at least {SPEED_MIN:g} m/s either way")
        return speed


SPEED_MIN = 0.05
"""m/s; a speed given over displacement that comes to zero never leaves it again."""
PATH_POLE_MIN = {Level.MOTORS: 1.5, Level.RATES: 1.0}
"""Slower poles are not gentler but unsafe: small gains make large errors, where the law is far from linear."""
POLE_MAX = 15.0
LOOK_AT_MIN = 0.5
CHECK_SAMPLES = 400


def load_mission(name: str, level: Level | None) -> Mission:
    """The mission of a name in configs/missions or a path, with gains for ``level``, its curve traced and its speed
    checked. ConfigError with every fault."""
    path = find(name, "missions")
    return mission_from(parse(read(path), str(path)), level)


def bare_mission_from(document: Document, level: Level) -> Mission:
    """The mission for ``companion law``: gains are taken as given, and the curve need not close."""
    model = validate(document, MissionModel)
    faults: list[Fault] = []
    mission = _mission(model, _gains(document, model.gains, level, faults, check=False))
    if faults:
        raise ConfigError(faults)
    return mission


def mission_from(document: Document, level: Level | None) -> Mission:
    """The mission a document describes. ConfigError with every fault."""
    model = validate(document, MissionModel)
    faults: list[Fault] = []
    gains = None if level is None else _gains(document, model.gains, level, faults, check=True)
    mission = _mission(model, gains)
    if isinstance(mission.path, ImplicitPath) and mission.path.near is None:
        faults.append(document.fault(("path", "near"), "missing; expected a point [x, y, z] near the path, in m"))
    else:
        faults += _along(document, mission)
    if faults:
        raise ConfigError(faults)
    return mission


def _mission(model: MissionModel, gains: Gains | None) -> Mission:
    constants = model.path.constants
    names = (*VARIABLES, *constants)
    near = model.path.near or (model.start.position if model.start is not None else None)
    placement = Placement(turn=math.radians(model.rotate_deg), enu=model.frame == "enu")
    path = ImplicitPath(
        h1=parse_expression(model.path.h1, names),
        h2=parse_expression(model.path.h2, names),
        near=None if near is None else _triple(near),
        constants=constants,
        placement=placement,
    )
    look_at = _triple(model.yaw.look_at) if isinstance(model.yaw, LookAtModel) else None
    mission = Mission(
        name=model.mission,
        path=path,
        speed=_speed(model.speed, names, constants),
        yaw=_yaw(model.yaw, names, constants),
        gains=gains,
        laps=model.laps,
        start=None if model.start is None else _start(model.start),
        origin=_origin(model.origin),
        vehicle=model.vehicle,
        look_at=look_at,
    )
    return mission.placed((0.0, 0.0, 0.0))


def _speed(given: Any, names: Sequence[str], constants: Mapping[str, float]) -> Speed:
    return (
        SpeedExpression(parse_expression(given, names), constants)
        if isinstance(given, str)
        else ConstantSpeed(float(given))
    )


def _yaw(given: Any, names: Sequence[str], constants: Mapping[str, float]) -> Yaw:
    if isinstance(given, LookAtModel):
        return LookAt(_triple(given.look_at))
    if isinstance(given, TangentModel):
        return TangentYaw(math.radians(given.tangent))
    if given == "tangent":
        return TangentYaw()
    if isinstance(given, str):
        return YawExpression(parse_expression(given, names), constants)
    return ConstantYaw(math.radians(given))


def _origin(given: str | list[float] | None) -> Origin | GlobalOrigin | None:
    if given is None:
        return None
    return Origin(given) if isinstance(given, str) else GlobalOrigin(*given)


def _start(model: StartModel) -> Start:
    roll, pitch, yaw = map(math.radians, model.rates_dps)
    return Start(
        position=_triple(model.position),
        velocity=_triple(model.velocity),
        heading=math.radians(model.heading_deg),
        pitch=math.radians(model.pitch_deg),
        roll=math.radians(model.roll_deg),
        rates_b=(roll, pitch, yaw),
    )


def _triple(values: Sequence[float]) -> Vec3:
    x, y, z = values
    return (float(x), float(y), float(z))


def _gains(document: Document, model: GainsModel, level: Level, faults: list[Fault], *, check: bool) -> Gains | None:
    """The gains of a file at a level; what is wrong with them goes into ``faults``."""
    counts = dict(zip(("h1", "h2", "h3", "h4"), level.degrees, strict=True))
    default = default_gains(level)
    chosen: dict[str, tuple[float, ...]] = {}
    poles = model.poles
    for output, count in counts.items():
        kind = {"h1": "path", "h2": "path", "h3": "speed", "h4": "yaw"}[output]
        listed: list[float] | None = getattr(model, output)
        rooted: list[float] | None = getattr(poles, kind) if poles is not None else None
        if listed is not None and rooted is not None:
            message = f"given together with poles.{kind}; expected one of the two"
            faults.append(document.fault(("gains", output), message))
        elif listed is not None and len(listed) != count:
            message = f"{len(listed)} numbers; expected {count} at the level of {level.name.lower()}, or poles"
            faults.append(document.fault(("gains", output), message))
        elif rooted is not None and len(rooted) != count:
            message = f"{len(rooted)} numbers; expected {count} at the level of {level.name.lower()}"
            faults.append(document.fault(("gains", "poles", kind), message))
        else:
            chosen[output] = (
                tuple(listed) if listed is not None else from_poles(rooted) if rooted else getattr(default, output)
            )
            if check:
                key = ("gains", output) if listed is not None else ("gains", "poles", kind)
                faults += _speed_of_gains(document, key, chosen[output], kind, level)
    return Gains(**chosen) if len(chosen) == len(counts) else None


def _speed_of_gains(
    document: Document, key: tuple[str, ...], gains: tuple[float, ...], kind: str, level: Level
) -> list[Fault]:
    """Whether gains may be flown."""
    roots = poles_of(gains)
    slowest, fastest = min(-root.real for root in roots), max(abs(root) for root in roots)
    if slowest <= 1e-6:
        return [document.fault(key, f"{list(gains)} is not stable; expected roots with negative real parts")]
    least = PATH_POLE_MIN[level] if kind == "path" else 0.1
    if slowest < 0.99 * least:
        message = f"slowest root {-slowest:.3g}; expected {-least:g} or faster: slow gains let errors grow too large"
        return [document.fault(key, message)]
    if fastest > POLE_MAX:
        message = f"fastest root {-fastest:.3g}; expected {-POLE_MAX:g} or slower: the vehicle cannot follow it"
        return [document.fault(key, message)]
    return []


def _along(document: Document, mission: Mission) -> list[Fault]:
    """What only following the curve shows."""
    try:
        table = mission.table
    except PathError as error:
        return [document.fault(("path",), str(error))]
    faults: dict[str, Fault] = {}
    signs = set()
    for i in range(CHECK_SAMPLES):
        s = table.length * i / CHECK_SAMPLES
        p_n, tangent, _ = table.at(s)
        where = f"at {_mission_place(mission, p_n)}"
        try:
            speed = mission.alpha(s)
            signs.add(speed > 0.0)
            if not abs(speed) >= SPEED_MIN:
                message = f"{speed:.3g} m/s {where}; expected at least {SPEED_MIN:g} m/s everywhere, or it never leaves"
                faults.setdefault("speed", document.fault(("speed",), message))
        except (ValueError, ArithmeticError) as error:
            faults.setdefault("speed", document.fault(("speed",), f"is not defined {where}: {error}"))
        try:
            if isinstance(mission.yaw, TangentYaw) and math.hypot(*tangent[:2]) < 1e-3:
                faults.setdefault("yaw", document.fault(("yaw",), f"tangent has no heading {where}: it is vertical"))
            target = mission.yaw.target_n if isinstance(mission.yaw, LookAt) else (math.inf, math.inf, 0.0)
            if math.hypot(target[0] - p_n[0], target[1] - p_n[1]) < LOOK_AT_MIN:
                message = f"the path passes within {LOOK_AT_MIN:g} m of the point to face, {where}; no heading there"
                faults.setdefault("yaw", document.fault(("yaw",), message))
            if not math.isfinite(mission.beta(s)):
                faults.setdefault("yaw", document.fault(("yaw",), f"is not finite {where}"))
        except (ValueError, ArithmeticError) as error:
            faults.setdefault("yaw", document.fault(("yaw",), f"is not defined {where}: {error}"))
    if len(signs) > 1 and "speed" not in faults:
        message = "changes sign along the path; expected one direction: it would stop at zero and never leave"
        faults["speed"] = document.fault(("speed",), message)
    return list(faults.values())


def _mission_place(mission: Mission, p_n: Vec3) -> str:
    x, y, z = mission.placement.to_mission(p_n)
    return f"x {x:.2f}, y {y:.2f}, z {z:.2f}"
