"""A plan: mission items as MAVLink knows them, the planned home, the fence, the rally points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from companion.fence import Circle, Fence, Polygon
from companion.frames import Vec3
from companion.geodesy import Home, LocalFrame
from companion.mavlink_common import (
    MAV_CMD_NAV_DELAY,
    MAV_CMD_NAV_GUIDED_ENABLE,
    MAV_CMD_NAV_LAST,
    MAV_CMD_NAV_LOITER_TIME,
    MAV_CMD_NAV_LOITER_TO_ALT,
    MAV_CMD_NAV_LOITER_TURNS,
    MAV_CMD_NAV_LOITER_UNLIM,
    MAV_CMD_NAV_ROI,
    MAV_CMD_NAV_SPLINE_WAYPOINT,
    MAV_CMD_NAV_VTOL_LAND,
    MAV_CMD_NAV_VTOL_TAKEOFF,
    MAV_CMD_NAV_WAYPOINT,
    MAV_FRAME_GLOBAL,
    MAV_FRAME_GLOBAL_INT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
    MAV_FRAME_GLOBAL_TERRAIN_ALT,
    MAV_FRAME_GLOBAL_TERRAIN_ALT_INT,
)

Key = tuple[str | int, ...]
"""Where something stands in the plan's file."""

AMSL_FRAMES = frozenset({MAV_FRAME_GLOBAL, MAV_FRAME_GLOBAL_INT})
RELATIVE_FRAMES = frozenset({MAV_FRAME_GLOBAL_RELATIVE_ALT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT})
TERRAIN_FRAMES = frozenset({MAV_FRAME_GLOBAL_TERRAIN_ALT, MAV_FRAME_GLOBAL_TERRAIN_ALT_INT})

MOVES = frozenset(
    {
        MAV_CMD_NAV_WAYPOINT,
        MAV_CMD_NAV_LOITER_UNLIM,
        MAV_CMD_NAV_LOITER_TURNS,
        MAV_CMD_NAV_LOITER_TIME,
        MAV_CMD_NAV_LOITER_TO_ALT,
        MAV_CMD_NAV_SPLINE_WAYPOINT,
    }
)
"""Items that say where to fly and are flown as waypoints."""
NOT_FOR_A_QUADROTOR = {MAV_CMD_NAV_VTOL_TAKEOFF: "a VTOL's take-off", MAV_CMD_NAV_VTOL_LAND: "a VTOL's landing"}
"""In words."""

FLY_NOWHERE = frozenset({MAV_CMD_NAV_ROI, MAV_CMD_NAV_GUIDED_ENABLE, MAV_CMD_NAV_DELAY})
"""Below MAV_CMD_NAV_LAST, and no place to fly to all the same."""


class Place(NamedTuple):
    """A place on the earth: degrees, and m above mean sea level (``amsl``) or above home."""

    latitude: float
    longitude: float
    altitude: float
    amsl: bool

    def seen_from(self, home: LocalFrame) -> Vec3:
        """North, east, down in m from ``home``."""
        north, east, _ = home.to_local(self.latitude, self.longitude, 0.0)
        return (north, east, (home.altitude if self.amsl else 0.0) - self.altitude)


def flies_somewhere(command: int) -> bool:
    """Whether a MAV_CMD moves the vehicle: a waypoint, a take-off, a landing, a return."""
    return command < MAV_CMD_NAV_LAST and command not in FLY_NOWHERE


class Item(NamedTuple):
    """A mission item: MAV_CMD, MAV_FRAME, seven parameters (nan where the plan says null; the last three are latitude,
    longitude and altitude), and the ``number`` a jump calls it by. ``key``: where it stands in the file."""

    command: int
    frame: int
    params: tuple[float, ...]
    number: int
    key: Key


@dataclass(frozen=True, slots=True)
class FenceArea:
    """An area of a fence: a polygon's corners, or a circle's centre and radius (m), in degrees of latitude and
    longitude. ``inside``: whether one must stay inside of it."""

    corners: tuple[tuple[float, float], ...]
    radius: float | None
    inside: bool


@dataclass(frozen=True, slots=True)
class Plan:
    """What a ground station wrote. ``home``: the planned home, None where it is not known. ``speed``:
    m/s to fly at until told otherwise, None where the file does not say. ``rally``: how many rally points it has.
    ``notes``: what a pilot should know of how it was read. ``home_key``, ``items_key``: where home and the items stand
    in the file."""

    items: tuple[Item, ...]
    home: Home | None = None
    speed: float | None = None
    fence: tuple[FenceArea, ...] = ()
    rally: tuple[Place, ...] = ()
    notes: tuple[str, ...] = ()
    home_key: Key = ("mission", "plannedHomePosition")
    items_key: Key = ("mission", "items")


class Problem(NamedTuple):
    """Why a plan cannot be flown: what is wrong, and where in its file."""

    key: Key
    message: str


class PlanError(Exception):
    """A plan that cannot be flown: every reason."""

    def __init__(self, problems: list[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("; ".join(problem.message for problem in problems))


def fence_in(areas: tuple[FenceArea, ...], to_plane: Callable[[float, float], Vec3]) -> Fence | None:
    """The fence in plane coordinates, ``to_plane`` giving those of a latitude and longitude; None for none."""

    def point(at: tuple[float, float]) -> tuple[float, float]:
        x, y, _ = to_plane(*at)
        return (x, y)

    if not areas:
        return None
    return Fence(
        tuple(
            Polygon(tuple(map(point, area.corners)), area.inside)
            if area.radius is None
            else Circle(point(area.corners[0]), area.radius, area.inside)
            for area in areas
        )
    )
