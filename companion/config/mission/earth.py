"""Latitude and longitude in mission files -> the mission's own metres, by PX4's projection about its origin.

Wherever a point may stand, ``{lat: 47.3977, lon: 8.5456, above_home: 10}`` may stand too, or ``amsl`` for metres above
mean sea level. They are turned into ``[x, y, z]`` before anything else looks at the file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from companion.config.syntax.document import Document
from companion.config.syntax.faults import ConfigError, Fault, Key
from companion.config.syntax.units import unit_hint
from companion.geodesy import LocalFrame
from companion.mission import GlobalOrigin
from companion.paths.placement import Placement

HEIGHTS = ("above_home", "amsl")
LIMITS = {"lat": 89.0, "lon": 180.0, "above_home": 10_000.0, "amsl": 10_000.0}
"""degrees and m beyond which a place is none."""
WORDS = {"lat": "latitude", "lon": "longitude", "above_home": "height", "amsl": "height"}
EXAMPLE = "{lat: 47.3977, lon: 8.5456, above_home: 10}"


def localised(document: Document) -> tuple[Document, GlobalOrigin | None]:
    """The document with its places as points in m, and the origin on the earth they are counted from; the document as
    it is, and None, where it has no places and its origin is none. ConfigError with every fault."""
    if not isinstance(document.data, dict):
        return document, None
    data = dict(document.data)
    given = data.pop("origin", None)
    places = list(_places(data, ()))
    faults: list[Fault] = []
    origin = _origin(document, given, places, faults)
    for key, place in places:
        _check(document, key, place, "fence" not in key, faults)
    if places and origin is None and not faults:
        message = (
            "the file gives places in latitude and longitude; expected origin: [lat, lon, altitude above sea level]"
        )
        faults.append(document.fault(("origin",), f"{message}, or none"))
    if origin is not None and not faults:
        faults += _heights(document, origin, places)
    if faults:
        raise ConfigError(faults)
    if origin is None:
        return document, None
    turn = data.get("rotate_deg", 0.0)
    turn = math.radians(turn) if isinstance(turn, int | float) else 0.0
    to_mission = Placement(turn=turn, enu=data.get("frame") == "enu").to_mission
    frame = LocalFrame(origin.latitude, origin.longitude, origin.altitude)
    points = {}
    for key, place in places:
        height = place.get("above_home", place.get("amsl", origin.altitude))
        point = to_mission(frame.to_local(place["lat"], place["lon"], height))
        points[key] = list(point[:2] if "fence" in key else point)
    return Document(document.file, _replaced(data, (), points), document.lines), origin


def _places(data: Any, key: Key) -> Iterator[tuple[Key, dict[str, Any]]]:
    if isinstance(data, dict):
        if "lat" in data or "lon" in data:
            yield key, data
            return
        for name, value in data.items():
            yield from _places(value, (*key, name))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _places(value, (*key, index))


def _replaced(data: Any, key: Key, points: dict[Key, list[float]]) -> Any:
    if key in points:
        return points[key]
    if isinstance(data, dict):
        return {name: _replaced(value, (*key, name), points) for name, value in data.items()}
    if isinstance(data, list):
        return [_replaced(value, (*key, index), points) for index, value in enumerate(data)]
    return data


def _origin(
    document: Document, given: Any, places: list[tuple[Key, dict[str, Any]]], faults: list[Fault]
) -> GlobalOrigin | None:
    """The origin on the earth; where the file names none, the ground under its first place."""
    if isinstance(given, list) and len(given) == 3 and all(map(_is_number, given)):
        place = dict(zip(("lat", "lon", "amsl"), given, strict=True))
    elif isinstance(given, dict):
        place = given
    elif given is None and places:
        first = places[0][1]
        if "amsl" in first:
            message = "missing; heights above sea level need origin: [lat, lon, height of the ground above sea level]"
            faults.append(document.fault(("origin",), message))
            return None
        place = {"lat": first.get("lat"), "lon": first.get("lon"), "above_home": 0.0}
    else:
        return None
    before = len(faults)
    _check(document, ("origin",), place, True, faults)
    if len(faults) > before:
        return None
    above_home = "above_home" in place
    return GlobalOrigin(place["lat"], place["lon"], place["above_home" if above_home else "amsl"], above_home)


def _check(document: Document, key: Key, place: dict[str, Any], height: bool, faults: list[Fault]) -> None:
    for name in place:
        if name not in LIMITS:
            faults.append(document.fault((*key, name), f"unknown key; expected a place such as {EXAMPLE}"))
            return
    heights = [name for name in HEIGHTS if name in place]
    for name in ("lat", "lon", *heights):
        value, most = place.get(name), LIMITS[name]
        if not _is_number(value) or not abs(value or 0.0) <= most:
            wrong = f"{value!r} is no {WORDS[name]}{unit_hint((name,), value, most)}"
            wrong += f"; expected a number from -{most:g} to {most:g}"
            what = f"missing; expected a place such as {EXAMPLE}" if value is None else wrong
            faults.append(document.fault((*key, name), what))
    if len(heights) != (1 if height else 0):
        wanted = "one of above_home and amsl, in m" if height else "no height in a fence"
        faults.append(document.fault(key, f"{' and '.join(heights) or 'no height'}; expected {wanted}"))


def _heights(document: Document, origin: GlobalOrigin, places: list[tuple[Key, dict[str, Any]]]) -> list[Fault]:
    wanted = "above_home" if origin.above_home else "amsl"
    return [
        document.fault(key, f"its height counts from elsewhere than the origin's; expected {wanted}")
        for key, place in places
        if "fence" not in key and wanted not in place
    ]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
