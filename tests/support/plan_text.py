"""Plans as QGroundControl writes them, made up for the tests."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

HOME = (47.397742, 8.545594, 488.0)
NORTH, EAST = 1.0 / 111194.93, 1.0 / 75270.0
"""Degrees of a metre, near enough, at HOME."""


def item(command: int, *params: float | None, frame: int = 2) -> dict[str, Any]:
    """A simple item; its number is set by ``plan``."""
    padded = [*params, *[0] * (7 - len(params))]
    return {
        "autoContinue": True,
        "command": command,
        "doJumpId": 0,
        "frame": frame,
        "params": padded,
        "type": "SimpleItem",
    }


def waypoint(north: float, east: float, height: float, *, hold: float = 0, yaw: float | None = None, frame: int = 3,
             command: int = 16) -> dict[str, Any]:  # fmt: skip
    """A waypoint so many metres from home; ``frame`` 3 counts heights from there, 0 from the sea."""
    place = (HOME[0] + north * NORTH, HOME[1] + east * EAST, height)
    found = item(command, hold, 0, 0, yaw, *place, frame=frame)
    return {"AMSLAltAboveTerrain": None, "Altitude": height, "AltitudeMode": 1 if frame == 3 else 2, **found}


def survey(*items: dict[str, Any], kind: str = "survey") -> dict[str, Any]:
    """A complex item with its simple items written out."""
    return {
        "TransectStyleComplexItem": {"CameraCalc": {"version": 2}, "Items": list(items), "version": 2},
        "complexItemType": kind,
        "type": "ComplexItem",
        "version": 5,
    }


def plan(
    *items: dict[str, Any], polygons: Any = (), circles: Any = (), rally: Any = (), **mission: Any
) -> dict[str, Any]:
    """The whole file as data."""
    number = 0
    for given in items:
        for simple in given.get("TransectStyleComplexItem", {}).get("Items", [given]):
            number += 1
            simple["doJumpId"] = number
    return {
        "fileType": "Plan",
        "geoFence": {"circles": list(circles), "polygons": list(polygons), "version": 2},
        "groundStation": "QGroundControl",
        "mission": {
            "cruiseSpeed": 15,
            "firmwareType": 12,
            "globalPlanAltitudeMode": 1,
            "hoverSpeed": 5,
            "items": list(items),
            "plannedHomePosition": list(HOME),
            "vehicleType": 2,
            "version": 2,
            **mission,
        },
        "rallyPoints": {"points": list(rally), "version": 2},
        "version": 1,
    }


def text(*items: dict[str, Any], **more: Any) -> str:
    """The whole file as QGroundControl writes it."""
    return json.dumps(plan(*items, **more), indent=4) + "\n"


def written(path: Path, *items: dict[str, Any], **more: Any) -> Path:
    """The file on disk."""
    path.write_text(text(*items, **more), encoding="utf-8")
    return path
