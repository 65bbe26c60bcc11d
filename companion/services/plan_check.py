"""A plan read twice: by us, and by MAVSDK's own reader. Where they differ, one of them would fly something else."""

from __future__ import annotations

import math
from typing import Any

from companion.mavlink_common import MAV_FRAME_MISSION
from companion.plans.items import Plan

SCANS = ("CorridorScan", "StructureScan")
"""What MAVSDK's reader leaves out."""


def differences(plan: Plan, text: str, theirs: Any) -> list[str]:
    """What a person should know of how ``plan``, read from ``text``, differs from MAVSDK's import of the same text; a
    single line of agreement where it does not."""
    if any(f'"{scan}"' in text for scan in SCANS):
        return ["plan: MAVSDK reads no corridor and no structure scans; ours alone was read"]
    found = []
    if len(plan.items) != len(theirs.mission_items):
        found.append(f"plan: we read {len(plan.items)} items, MAVSDK {len(theirs.mission_items)}")
    for number, (ours, other) in enumerate(zip(plan.items, theirs.mission_items, strict=False), 1):
        scale = 1.0 if ours.frame == MAV_FRAME_MISSION else 1e7
        mine = (ours.command, ours.frame, round(ours.params[4] * scale), round(ours.params[5] * scale))
        same_height = ours.params[6] == other.z or abs(ours.params[6] - other.z) < 1e-3 or math.isnan(other.z)
        if mine != (other.command, other.frame, other.x, other.y) or not same_height:
            found.append(f"plan: item {number} (command {ours.command}) is read otherwise by MAVSDK")
    corners = sum(len(area.corners) for area in plan.fence)
    if corners != len(theirs.geofence_items):
        found.append(f"plan: we read {corners} fence items, MAVSDK {len(theirs.geofence_items)}")
    return found or [f"plan: MAVSDK reads the same {len(plan.items)} items"]
