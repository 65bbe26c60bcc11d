"""A mission: what is to be flown, as values. The file it comes from is ``config.mission``'s business."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace

from companion.calculus.scalar import Scalar
from companion.frames import Vec3
from companion.law.gains import Gains
from companion.law.implicit import Position, Specification
from companion.paths.implicit import ImplicitPath
from companion.paths.placement import Placement
from companion.profiles import LookAt, Speed, Yaw


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
    path: ImplicitPath
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

    def speed_at(self, p_n: Vec3) -> float:
        """alpha, m/s, at a point of the local frame. ValueError, ArithmeticError: not defined there."""
        return float(self.speed.value(self.path.variables(p_n)))

    def yaw_at(self, p_n: Vec3, mu: Vec3) -> float:
        """beta, rad, at a point with unit tangent ``mu``. ValueError, ArithmeticError: not defined there."""
        return float(self.specification(self.speed_at(p_n)).beta(p_n, mu))

    def specification(self, direction: float) -> Specification:
        """What the law needs to know. ``direction``: any number with the sign of the speed."""
        forward = 1.0 if direction >= 0.0 else -1.0

        def alpha(p_n: Position) -> Scalar:
            return self.speed.value(self.path.variables(p_n))

        def beta(p_n: Position, mu: Position) -> Scalar:
            travel = (mu[0] * forward, mu[1] * forward, mu[2] * forward)
            return self.yaw.value(self.path.variables(p_n), p_n, travel)

        return Specification(self.path.h, alpha, beta)
