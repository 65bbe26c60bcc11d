"""A plan -> the text of a .plan, as QGroundControl writes it."""

from __future__ import annotations

import json
import math
from typing import Any

from companion.mavlink_common import (
    MAV_AUTOPILOT_PX4,
    MAV_TYPE_QUADROTOR,
)
from companion.plans.items import AMSL_FRAMES, RELATIVE_FRAMES, FenceArea, Item, Plan

CRUISE_SPEED = 15.0
"""m/s, for fixed wings; QGroundControl asks for it."""
RELATIVE_MODE, AMSL_MODE = 1, 2
"""QGroundControl's AltitudeMode."""


def plan_text(plan: Plan) -> str:
    """The file; read again it is the same plan, but for its notes."""
    home = [0.0, 0.0, 0.0] if plan.home is None else [*plan.home[:2], plan.home.altitude or 0.0]
    polygons = [_polygon(area) for area in plan.fence if area.radius is None]
    circles = [_circle(area) for area in plan.fence if area.radius is not None]
    whole = {
        "fileType": "Plan",
        "geoFence": {"circles": circles, "polygons": polygons, "version": 2},
        "groundStation": "QGroundControl",
        "mission": {
            "cruiseSpeed": CRUISE_SPEED,
            "firmwareType": MAV_AUTOPILOT_PX4,
            "globalPlanAltitudeMode": RELATIVE_MODE,
            "hoverSpeed": 5.0 if plan.speed is None else plan.speed,
            "items": [_item(item) for item in plan.items],
            "plannedHomePosition": home,
            "vehicleType": MAV_TYPE_QUADROTOR,
            "version": 2,
        },
        "rallyPoints": {"points": [list(place[:3]) for place in plan.rally], "version": 2},
        "version": 1,
    }
    return json.dumps(whole, indent=4) + "\n"


def _item(item: Item) -> dict[str, Any]:
    given: dict[str, Any] = {
        "autoContinue": True,
        "command": item.command,
        "doJumpId": item.number,
        "frame": item.frame,
        "params": [None if math.isnan(value) else value for value in item.params],
        "type": "SimpleItem",
    }
    if item.frame in AMSL_FRAMES | RELATIVE_FRAMES:
        mode = RELATIVE_MODE if item.frame in RELATIVE_FRAMES else AMSL_MODE
        given = {"AMSLAltAboveTerrain": None, "Altitude": item.params[6], "AltitudeMode": mode, **given}
    return given


def _polygon(area: FenceArea) -> dict[str, Any]:
    return {"inclusion": area.inside, "polygon": [list(corner) for corner in area.corners], "version": 1}


def _circle(area: FenceArea) -> dict[str, Any]:
    return {"circle": {"center": list(area.corners[0]), "radius": area.radius}, "inclusion": area.inside, "version": 1}
