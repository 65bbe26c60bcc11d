"""Files made in Python: a mission from a path, a speed and a heading; vehicles and worlds from their keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from companion.config.syntax.faults import ConfigError, Fault
from companion.library.files import MissionFile, VehicleFile, WorldFile
from companion.library.formulas import recorded

Formula = str | Callable[..., Any]
ALONG, AROUND = ("s",), ("x", "y", "z")
"""What speed and heading are functions of: arc length on a curve, the position on an implicit path."""


def new_mission(
    name: str, path: Mapping[str, Any], speed: Any, yaw: Any, frame: str, keys: Mapping[str, Any]
) -> MissionFile:
    """See ``public.new_mission``."""
    where = f"new_mission({name!r})"
    variables = AROUND if path.get("kind") == "implicit" else ALONG
    data: dict[str, Any] = {"mission": name, "frame": frame, "path": path}
    for key, given in (("speed", speed), ("yaw", yaw)):
        data[key] = recorded(given, variables, where, key)[0] if callable(given) else given
    return MissionFile.made(where, {**data, **keys})


def new_vehicle(name: str, keys: Mapping[str, Any]) -> VehicleFile:
    """See ``public.new_vehicle``."""
    return VehicleFile.made(f"new_vehicle({name!r})", {"name": name, **keys})


def new_world(name: str, keys: Mapping[str, Any]) -> WorldFile:
    """See ``public.new_world``."""
    return WorldFile.made(f"new_world({name!r})", {"name": name, **keys})


def implicit_path(
    h1: Formula, h2: Formula, near: Sequence[float] | None, constants: Mapping[str, float]
) -> dict[str, Any]:
    """See ``public.implicit_path``."""
    path: dict[str, Any] = {"kind": "implicit"}
    for key, h in (("h1", h1), ("h2", h2)):
        path[key] = recorded(h, AROUND, "implicit_path", key)[0] if callable(h) else h
    if near is not None:
        path["near"] = list(near)
    return {**path, "constants": dict(constants)} if constants else path


def curve_path(position: Callable[..., Any], u: Sequence[float], closed: bool) -> dict[str, Any]:
    """See ``public.curve_path``."""
    made = recorded(position, ("u",), "curve_path", "position")
    if len(made) != 3:
        message = f"returns {len(made)} values; expected three, (x, y, z)"
        raise ConfigError([Fault("curve_path", 0, "position", message)])
    return {"kind": "expression", **dict(zip("xyz", made, strict=True)), "u": list(u), "closed": closed}


def path_through(points: Sequence[Sequence[float]], closed: bool, corner_tolerance: float | None) -> dict[str, Any]:
    """See ``public.path_through``."""
    path: dict[str, Any] = {"kind": "spline", "points": [list(point) for point in points], "closed": closed}
    return path if corner_tolerance is None else {**path, "kind": "polyline", "corner_tolerance": corner_tolerance}
