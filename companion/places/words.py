"""Where a path runs, in words: the height sign is where people crash."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from companion.frames import Vec3
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.origins import PlaceError, VehicleLocation, home_in, placed

SAMPLES = 2000
"""points of the path its extent is taken from."""
LOW = 1.0
"""m over the ground under which a height is worth a warning."""
FAR = 2000.0
"""m from the vehicle beyond which a distance is worth a warning."""
SEEN = 0.05
"""m: a height below is written as 0.0 (half of the last digit)."""
KILOMETRES = 9999.5
"""m from which on a distance is told in km: four digits are read as metres."""
HIGH = 120.0
"""m over the ground, the height that many countries' rules end at."""


@dataclass(frozen=True, slots=True)
class PlaceWords:
    """``lines``: where a path runs, sentences for the pilot. ``warnings``: what is likely not meant."""

    lines: tuple[str, ...]
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join([*self.lines, *(f"WARNING: {warning}" for warning in self.warnings)])


@dataclass(frozen=True, slots=True)
class _Reference:
    """What places are told from: its name, and the point in the coordinates of the mission's table."""

    name: str
    point_n: Vec3
    is_ground: bool


def words_of_place(mission: Mission, default: Origin, where: VehicleLocation | None = None) -> PlaceWords:
    """Where ``mission`` runs: from what it counts from, or from a vehicle where one says ``where`` it is.

    ``default``: what the mission counts from where its file does not say. PlaceError: it cannot be placed there.
    """
    origin = mission.origin or default
    if where is not None:
        mission = placed(mission, default, where)
    reference = _from_mission(mission, origin) if where is None else _from_vehicle(mission, origin, where)
    table = mission.table
    points = table.samples(SAMPLES)[1] - np.array(reference.point_n)
    first = _vector(table.at(0.0 if mission.direction > 0.0 else table.length)[0], reference.point_n)
    heights = -points[:, 2]
    low, high = _seen(float(heights.min())), _seen(float(heights.max()))
    lines = [f"the path runs {_heights(low, high)} {reference.name}"]
    if isinstance(origin, GlobalOrigin) and not origin.above_home:
        lines.append(f"that is {_span(*_above_sea(mission, origin))} m above sea level")
    lines.append(f"it begins {_begin(first)}")
    south, west = -points[:, :2].min(axis=0)
    north, east = points[:, :2].max(axis=0)
    lines.append(
        f"it lies {_extent(north, 'north', south, 'south')}, {_extent(east, 'east', west, 'west')} of that point"
    )
    warnings = _of_height(mission, reference, low, high)
    distance = math.hypot(first[0], first[1])
    if where is not None and distance > FAR:
        warnings.append(f"it begins {distance / 1000.0:.1f} km away; is it for another place?")
    return PlaceWords(tuple(lines), tuple(warnings))


def _of_height(mission: Mission, reference: _Reference, low: float, high: float) -> list[str]:
    if not reference.is_ground:
        return []
    if low == high == 0.0:
        return [f"the whole path is on the ground, at the height of {reference.name}: give it a height to fly at"]
    if high <= 0.0:
        example = "" if mission.from_plan or mission.placement.enu else ", so 10 m up is z = -10"
        below = f"{_heights(low, high)} {reference.name}"
        return [f"the whole path is {below}, under the ground: {mission.up_in_words}{example}"]
    if low < 0.0:
        return [f"the path goes down to {-low:.1f} m BELOW {reference.name}: into the ground, where that is level"]
    if low == 0.0:
        return [f"the path comes down to the height of {reference.name}: to the ground, where that is level"]
    if low < LOW:
        return [f"the path comes down to {low:.1f} m above {reference.name}"]
    if high > HIGH:
        return [f"the path rises to {high:.0f} m above {reference.name}; in many countries 120 m is the most allowed"]
    return []


def _from_mission(mission: Mission, origin: Origin | GlobalOrigin) -> _Reference:
    point = mission.placement.origin_n
    if isinstance(origin, GlobalOrigin):
        place = f"{origin.latitude:.6f}, {origin.longitude:.6f}"
        if origin.above_home:
            return _Reference(f"home, seen from {place}", (point[0], point[1], point[2] + origin.altitude), True)
        return _Reference(f"the mission's origin ({place}, {origin.altitude:.1f} m above sea level)", point, True)
    name = {
        Origin.LOCAL: "the origin of the vehicle's local frame, where its estimator started",
        Origin.TAKEOFF: "the take-off point",
        Origin.HOME: "home",
    }[origin]
    return _Reference(name, point, True)


def _from_vehicle(mission: Mission, origin: Origin | GlobalOrigin, where: VehicleLocation) -> _Reference:
    if where.on_ground:
        return _Reference("the ground where the vehicle stands", where.p_n, True)
    try:
        return _Reference("home", home_in(where), True)
    except PlaceError:
        return _Reference("the origin of the vehicle's local frame", (0.0, 0.0, 0.0), False)


def _above_sea(mission: Mission, origin: GlobalOrigin) -> tuple[float, float]:
    rise = mission.placement.origin_n[2] - mission.table.samples(SAMPLES)[1][:, 2]
    return origin.altitude + float(rise.min()), origin.altitude + float(rise.max())


def _vector(to: Vec3, begin: Vec3) -> Vec3:
    return (to[0] - begin[0], to[1] - begin[1], to[2] - begin[2])


def _seen(height: float) -> float:
    """A height, 0 where it is written as 0.0: that is neither above nor below."""
    return height if abs(height) >= SEEN else 0.0


def _span(low: float, high: float) -> str:
    return f"{low:z.1f}" if high - low < SEEN else f"{low:z.1f} to {high:z.1f}"


def _heights(low: float, high: float) -> str:
    if low == high == 0.0:
        return "at the height of"
    if low >= 0.0:
        return f"{_span(low, high)} m above"
    if high <= 0.0:
        return f"{_span(-high, -low)} m BELOW"
    return f"between {-low:.1f} m BELOW and {high:.1f} m above"


def _height(height: float) -> str:
    return f"{abs(height):.1f} m {'up' if _seen(height) >= 0.0 else 'DOWN'}"


def _begin(first: Vec3) -> str:
    if math.hypot(*first) < SEEN:
        return "at that point"
    return f"{_height(-first[2])}, {_away(first)}"


def _away(to: Vec3) -> str:
    north, east = to[0], to[1]
    parts = []
    if abs(north) >= 0.5:
        parts.append(f"{_metres(abs(north))} {'north' if north > 0.0 else 'south'}")
    if abs(east) >= 0.5:
        parts.append(f"{_metres(abs(east))} {'east' if east > 0.0 else 'west'}")
    return f"{' and '.join(parts)} of that point" if parts else "straight above that point"


def _extent(ahead: float, forward: str, behind: float, backward: str) -> str:
    """From where to where along one axis; on one side of the point, or across it."""
    if behind < 0.5:
        return f"{_range(max(-behind, 0.0), max(ahead, 0.0))} {forward}"
    if ahead < 0.5:
        return f"{_range(max(-ahead, 0.0), behind)} {backward}"
    return f"{_metres(behind)} {backward} to {_metres(ahead)} {forward}"


def _range(near: float, far: float) -> str:
    if far - near < 0.5:
        return _metres(far)
    begin, end = _metres(near), _metres(far)
    unit = f" {end.split()[1]}"
    return f"{begin.removesuffix(unit)} to {end}"


def _metres(distance: float) -> str:
    return f"{distance:z.0f} m" if distance < KILOMETRES else f"{distance / 1000.0:.1f} km"
