"""Where a mission's coordinates stand in the vehicle's local NED frame.

A mission counts in ``ned`` (x north, y east, z down) or ``enu`` (x east, y north, z up), from an origin, turned by an
angle. This is the only place that knows of ENU; everything behind it is the vehicle's local NED.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.calculus.scalar import Scalar
from companion.frames import Vec3


@dataclass(frozen=True, slots=True)
class Placement:
    """``origin_n``: the mission's origin in the vehicle's local frame, m. ``turn``: rad, the mission's axes turned
    clockwise seen from above. ``enu``: the mission counts east, north, up."""

    origin_n: Vec3 = (0.0, 0.0, 0.0)
    turn: float = 0.0
    enu: bool = False

    def to_local(self, point: tuple[Scalar, Scalar, Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """A point of the mission, in the vehicle's local NED frame; floats or any other scalars."""
        x, y, z = self.turned(point)
        return (x + self.origin_n[0], y + self.origin_n[1], z + self.origin_n[2])

    def turned(self, vector: tuple[Scalar, Scalar, Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """A direction of the mission, in NED."""
        x, y, z = vector
        north, east, down = (y, x, -z) if self.enu else (x, y, z)
        if self.turn == 0.0:
            return (north, east, down)
        c, s = math.cos(self.turn), math.sin(self.turn)
        return (north * c - east * s, north * s + east * c, down)

    def to_mission(self, p_n: tuple[Scalar, Scalar, Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """A point of the vehicle's local NED frame, in the mission's coordinates; floats or any other scalars."""
        x, y, z = (p - o if o else p for p, o in zip(p_n, self.origin_n, strict=True))
        if self.turn != 0.0:
            c, s = math.cos(self.turn), math.sin(self.turn)
            x, y = x * c + y * s, y * c - x * s
        return (y, x, -z) if self.enu else (x, y, z)
