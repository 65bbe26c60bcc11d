"""Where a vehicle may be: polygons and circles to stay inside of, or outside of; as PX4 holds them, all at once.

Plane coordinates in m: of a mission, or north and east in a vehicle's local frame (``Fence.moved``).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from companion.frames import Vec3

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Polygon:
    """``corners``: three or more, in order. ``inside``: whether one must stay inside of it, or outside."""

    corners: tuple[Point, ...]
    inside: bool = True

    def margin(self, x: float, y: float) -> float:
        """m to its edge; positive where one may be."""
        within = False
        nearest = math.inf
        ax, ay = self.corners[-1]
        for bx, by in self.corners:
            if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
                within = not within
            dx, dy = bx - ax, by - ay
            squared = dx * dx + dy * dy
            along = ((x - ax) * dx + (y - ay) * dy) / squared if squared > 0.0 else 0.0
            along = min(max(along, 0.0), 1.0)
            nearest = min(nearest, math.hypot(x - ax - along * dx, y - ay - along * dy))
            ax, ay = bx, by
        return nearest if within is self.inside else -nearest

    @property
    def words(self) -> str:
        """What it is, for people."""
        return f"the polygon of {len(self.corners)} corners to stay {'inside' if self.inside else 'out'} of"


@dataclass(frozen=True, slots=True)
class Circle:
    """``inside``: whether one must stay inside of it, or outside."""

    center: Point
    radius: float
    inside: bool = True

    def margin(self, x: float, y: float) -> float:
        """m to its edge; positive where one may be."""
        left = self.radius - math.hypot(x - self.center[0], y - self.center[1])
        return left if self.inside else -left

    @property
    def words(self) -> str:
        """What it is, for people."""
        return f"the circle of {self.radius:.0f} m to stay {'inside' if self.inside else 'out'} of"


Area = Polygon | Circle


@dataclass(frozen=True, slots=True)
class Fence:
    """Every one of ``areas`` must be kept."""

    areas: tuple[Area, ...]

    def margin(self, p: Vec3) -> float:
        """m from ``p`` to the nearest edge, seen from above; negative: ``p`` is where one must not be."""
        return self.nearest(p)[0]

    def nearest(self, p: Vec3) -> tuple[float, Area | None]:
        """The margin at ``p``, and the area that leaves no more; inf and None where there is none."""
        found: tuple[float, Area | None] = (math.inf, None)
        for area in self.areas:
            margin = area.margin(p[0], p[1])
            if margin < found[0]:
                found = (margin, area)
        return found

    def moved(self, to: Callable[[Vec3], Vec3]) -> Fence:
        """The fence in other coordinates, reached by a shift, a turn or a reflection (``Placement.to_local``)."""

        def point(at: Point) -> Point:
            x, y, _ = to((*at, 0.0))
            return (x, y)

        areas: list[Area] = []
        for area in self.areas:
            if isinstance(area, Polygon):
                areas.append(Polygon(tuple(map(point, area.corners)), area.inside))
            else:
                areas.append(Circle(point(area.center), area.radius, area.inside))
        return Fence(tuple(areas))
