"""A mission: what is to be flown, as values. The file it comes from is ``config.mission``'s business."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from typing import NamedTuple

from companion.calculus.scalar import Scalar
from companion.fence import Fence
from companion.frames import Heading, Vec3
from companion.geodesy import NO_HOME_GIVEN, GivenHome, Home
from companion.law.gains import Gains
from companion.law.implicit import Position, Specification
from companion.paths.arc import ArcTable
from companion.paths.curve import Curve
from companion.paths.implicit import ImplicitPath
from companion.paths.placement import Placement
from companion.profiles import (
    AutoSpeed,
    ConstantSpeed,
    ConstantYaw,
    LookAt,
    Speed,
    SpeedExpression,
    SpeedOverArc,
    Yaw,
    YawExpression,
    YawOverArc,
    YawProfile,
)

Path = ImplicitPath | Curve


class Origin(enum.Enum):
    """What a mission's coordinates are counted from."""

    LOCAL = "local"
    TAKEOFF = "takeoff"
    HOME = "home"


@dataclass(frozen=True, slots=True)
class GlobalOrigin:
    """A place on the earth: degrees, and metres above mean sea level (``above_home``: above the vehicle's home)."""

    latitude: float
    longitude: float
    altitude: float
    above_home: bool = False


class Repeat(enum.Enum):
    """What is done at the end of an open path."""

    BACK_AND_FORTH = "back-and-forth"


@dataclass(frozen=True, slots=True)
class Start:
    """A state to begin a simulated flight in, in the mission's frame: m, m/s, rad, rad/s."""

    position: Vec3
    velocity: Vec3 = (0.0, 0.0, 0.0)
    heading: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    rates_b: Vec3 = (0.0, 0.0, 0.0)


class PathAction(NamedTuple):
    """What the payload is to do at a place of the path: the arc length ``s`` in m, MAV_CMD and its seven parameters,
    the ``number`` of the plan's item."""

    s: float
    command: int
    params: tuple[float, ...]
    number: int


@dataclass(frozen=True)
class Mission:
    """What is to be flown."""

    name: str
    path: Path  # where
    speed: Speed  # alpha along it
    yaw: Yaw  # beta along it
    gains: Gains | None = None  # of the level that is flown; None where the level is not known
    laps: float | None = None  # how many times around; None: until told
    start: Start | None = None  # where the vehicle begins in a simulation
    origin: Origin | GlobalOrigin | None = None  # what it counts from; None where the file does not say
    vehicle: str | None = None  # the file it is made for
    heading: Heading = Heading.PROJECTED  # the kind that yaw gives
    look_at: Vec3 | None = None  # m, the point of yaw: look_at, in the mission's coordinates
    repeat: Repeat | None = None  # what follows the end of an open path; None: it ends there
    fence: Fence | None = None  # where the vehicle may be, in the mission's coordinates
    notes: tuple[str, ...] = ()  # what of the file is not flown, in sentences for the pilot
    home: Home | None = None  # where its file, or who reads it, says that home is
    given_home: GivenHome = NO_HOME_GIVEN  # what of that was told beside the file
    mixed_heights: bool = False  # heights above home and above the sea meet in it: its shape hangs on home's altitude
    actions: tuple[PathAction, ...] = ()  # of the payload, by arc length
    from_plan: bool = False  # its path is a ground station's plan, whose heights know no frame

    def placed(self, origin_n: Vec3, turn: float | None = None) -> Mission:
        """The mission with its origin at ``origin_n`` of the vehicle's local frame, its axes turned by ``turn`` (rad,
        clockwise seen from above; None: as they are)."""
        placement = self.path.placement
        placement = replace(placement, origin_n=origin_n, turn=placement.turn if turn is None else turn)
        yaw = self.yaw
        if self.look_at is not None:
            x, y, z = placement.to_local(self.look_at)
            yaw = LookAt((x, y, z))
        path = self.path
        moved = path.placed(placement) if isinstance(path, Curve) else replace(path, placement=placement)
        return replace(self, path=moved, yaw=yaw)

    @property
    def placement(self) -> Placement:
        """Where its coordinates stand in the vehicle's local frame."""
        return self.path.placement

    @property
    def up_in_words(self) -> str:
        """How its heights are meant, for who finds the path below the ground."""
        if self.from_plan:
            return "the plan has heights below home's: mend them, or home, in the ground station"
        return "z points up in frame: enu" if self.placement.enu else "z points down in frame: ned"

    @property
    def fence_n(self) -> Fence | None:
        """Where the vehicle may be, in its local frame; None: anywhere."""
        return None if self.fence is None else self.fence.moved(self.placement.to_local)

    @property
    def table(self) -> ArcTable:
        """The path over its arc length, in the vehicle's local frame. PathError: it is no path."""
        return self.path.table

    @property
    def closed(self) -> bool:
        """Whether the path goes round."""
        return not isinstance(self.path, Curve) or self.path.closed

    @property
    def direction(self) -> float:
        """+1 along mu, -1 against. ValueError, ArithmeticError: the speed is not defined."""
        if isinstance(self.speed, AutoSpeed):
            return self.speed.direction
        return 1.0 if self.alpha(0.5 * self.table.length) >= 0.0 else -1.0

    def alpha(self, s: float) -> float:
        """m/s, the speed at arc length ``s``. ValueError, ArithmeticError: not defined there."""
        speed, path = self.speed, self.path
        if isinstance(speed, SpeedExpression) and isinstance(path, ImplicitPath):
            return float(speed.value(path.variables(self.table.at(s)[0])))
        return speed.at(s)[0]

    def beta(self, s: float) -> float:
        """rad, the heading at arc length ``s``. ValueError, ArithmeticError: not defined there."""
        known = self.yaw_over_arc
        if known is not None:
            return known.at(s)[0]
        assert not isinstance(self.yaw, YawProfile)
        point, (x, y, z), _ = self.table.at(s)
        forward = self.direction
        travel = (x * forward, y * forward, z * forward)
        variables = self.path.variables(point) if isinstance(self.path, ImplicitPath) else {}
        return float(self.yaw.value(variables, point, travel))

    @property
    def speed_over_arc(self) -> SpeedOverArc | None:
        """alpha, where it is a function of arc length and known; None where it is one of the position, or ``auto``."""
        if isinstance(self.speed, AutoSpeed):
            return None
        return None if isinstance(self.speed, SpeedExpression) and isinstance(self.path, ImplicitPath) else self.speed

    @property
    def yaw_over_arc(self) -> YawOverArc | None:
        """beta, where it is a function of arc length alone; None where it is one of the position or of the path."""
        if isinstance(self.yaw, YawExpression):
            return self.yaw if isinstance(self.path, Curve) else None
        return self.yaw if isinstance(self.yaw, ConstantYaw | YawProfile) else None

    def specification(self, direction: float) -> Specification:
        """What the law of an implicit path needs to know. ``direction``: any number with the sign of the speed."""
        path = self.path
        assert isinstance(path, ImplicitPath)
        forward = 1.0 if direction >= 0.0 else -1.0

        def alpha(p_n: Position, mu: Position) -> Scalar:
            assert isinstance(self.speed, ConstantSpeed | SpeedExpression)  # others are given over arc length
            return self.speed.value(path.variables(p_n))

        def beta(p_n: Position, mu: Position) -> Scalar:
            travel = (mu[0] * forward, mu[1] * forward, mu[2] * forward)
            assert not isinstance(self.yaw, YawProfile)  # given over arc length
            return self.yaw.value(path.variables(p_n), p_n, travel)

        return Specification(path.h, alpha, beta, self.heading)
