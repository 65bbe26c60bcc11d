"""A mission: what is to be flown, as values. The file it comes from is ``config.mission``'s business."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace

from companion.calculus.scalar import Scalar
from companion.frames import Vec3
from companion.law.gains import Gains
from companion.law.implicit import Position, Specification
from companion.paths.arc import ArcTable
from companion.paths.curve import Curve
from companion.paths.implicit import ImplicitPath
from companion.paths.placement import Placement
from companion.profiles import ConstantSpeed, ConstantYaw, LookAt, Speed, Yaw, YawExpression

Path = ImplicitPath | Curve


class Origin(enum.Enum):
    """What a mission's coordinates are counted from."""

    LOCAL = "local"
    TAKEOFF = "takeoff"
    HOME = "home"


@dataclass(frozen=True, slots=True)
class GlobalOrigin:
    """A place on the earth: degrees, and metres above mean sea level."""

    latitude: float
    longitude: float
    altitude: float


@dataclass(frozen=True, slots=True)
class Start:
    """A state to begin a simulated flight in, in the mission's frame: m, m/s, rad, rad/s."""

    position: Vec3
    velocity: Vec3 = (0.0, 0.0, 0.0)
    heading: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    rates_b: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Mission:
    """``path``: where. ``speed``, ``yaw``: alpha and beta along it. ``gains``: for the level that is flown, None where
    the level is not known. ``laps``: how many times around, None for until told. ``origin``: None where the file does
    not say. ``look_at``: the point of ``yaw: look_at`` in the mission's coordinates."""

    name: str
    path: Path
    speed: Speed
    yaw: Yaw
    gains: Gains | None = None
    laps: float | None = None
    start: Start | None = None
    origin: Origin | GlobalOrigin | None = None
    vehicle: str | None = None
    look_at: Vec3 | None = None

    def placed(self, origin_n: Vec3) -> Mission:
        """The mission with its origin at ``origin_n`` of the vehicle's local frame."""
        placement = replace(self.path.placement, origin_n=origin_n)
        yaw = self.yaw
        if self.look_at is not None:
            x, y, z = placement.to_local(self.look_at)
            yaw = LookAt((x, y, z))
        return replace(self, path=replace(self.path, placement=placement), yaw=yaw)

    @property
    def placement(self) -> Placement:
        """Where its coordinates stand in the vehicle's local frame."""
        return self.path.placement

    @property
    def table(self) -> ArcTable:
        """The path over its arc length, in the vehicle's local frame. PathError: it is no path."""
        return self.path.table

    def alpha(self, s: float) -> float:
        """m/s, the speed at arc length ``s``. ValueError, ArithmeticError: not defined there."""
        if isinstance(self.path, Curve) or isinstance(self.speed, ConstantSpeed):
            return self.speed.at(s)[0]
        return float(self.speed.value(self.path.variables(self.table.at(s)[0])))

    def beta(self, s: float) -> float:
        """rad, the heading at arc length ``s``. ValueError, ArithmeticError: not defined there."""
        if isinstance(self.yaw, ConstantYaw | YawExpression) and isinstance(self.path, Curve):
            return self.yaw.at(s)[0]
        point, (x, y, z), _ = self.table.at(s)
        forward = 1.0 if self.alpha(s) >= 0.0 else -1.0
        travel = (x * forward, y * forward, z * forward)
        variables = self.path.variables(point) if isinstance(self.path, ImplicitPath) else {}
        return float(self.yaw.value(variables, point, travel))

    def specification(self, direction: float) -> Specification:
        """What the law of an implicit path needs to know. ``direction``: any number with the sign of the speed."""
        path = self.path
        assert isinstance(path, ImplicitPath)
        forward = 1.0 if direction >= 0.0 else -1.0

        def alpha(p_n: Position) -> Scalar:
            return self.speed.value(path.variables(p_n))

        def beta(p_n: Position, mu: Position) -> Scalar:
            travel = (mu[0] * forward, mu[1] * forward, mu[2] * forward)
            return self.yaw.value(path.variables(p_n), p_n, travel)

        return Specification(path.h, alpha, beta)
