"""Fences and rally points that stand among the items of a plan, as Mission Planner and MAVProxy write them -> areas."""

from __future__ import annotations

from companion.mavlink_common import (
    MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    MAV_CMD_NAV_FENCE_RETURN_POINT,
    MAV_CMD_NAV_RALLY_POINT,
)
from companion.plans.items import FenceArea, Item, PlanError, Problem

VERTICES = {MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: True, MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False}
CIRCLES = {MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: True, MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: False}
OTHERS = frozenset({MAV_CMD_NAV_FENCE_RETURN_POINT, MAV_CMD_NAV_RALLY_POINT})
"""The autopilot's own business."""


def areas_among(items: list[Item]) -> tuple[tuple[FenceArea, ...], list[Item]]:
    """The areas of the fence, and the items that are no part of one. A polygon's corners follow each other, each with
    their count as its first parameter. PlanError: a corner is missing, or a circle has no radius."""
    areas: list[FenceArea] = []
    rest: list[Item] = []
    corners: list[Item] = []
    for item in items:
        if item.command in VERTICES:
            if corners and corners[0].command != item.command:
                raise PlanError([Problem(item.key, f"item {item.number}: the polygon before it lacks corners")])
            corners.append(item)
            if len(corners) >= max(corners[0].params[0], 3.0):
                points = tuple((corner.params[4], corner.params[5]) for corner in corners)
                areas.append(FenceArea(points, None, VERTICES[item.command]))
                corners = []
        elif item.command in CIRCLES:
            if not item.params[0] > 0.0:
                raise PlanError([Problem(item.key, f"item {item.number}: a circle without a radius")])
            areas.append(FenceArea(((item.params[4], item.params[5]),), item.params[0], CIRCLES[item.command]))
        elif item.command not in OTHERS:
            rest.append(item)
    if corners:
        said = f"item {corners[0].number}: a polygon of {corners[0].params[0]:g} corners, {len(corners)} are there"
        raise PlanError([Problem(corners[0].key, said)])
    return tuple(areas), rest
