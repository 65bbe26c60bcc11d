"""How PX4 takes each command as a mission item (its parse_mavlink_mission_item), a row a command."""

from __future__ import annotations

from typing import NamedTuple

from companion import mavlink_common as mav

ALL = 0x7F
"""All seven parameters, one bit each."""


class Row(NamedTuple):
    """``takes``: the parameters it takes, one bit each; another that is given is refused.

    ``with_place``, ``without_place``: it is taken in a global frame; in MAV_FRAME_MISSION.
    ``flown_to``: its place is somewhere to fly to.
    ``kept``: which of the first four parameters are kept where it has a place, those of ``flags`` as yes or no; the
    others come back as 0. ``has_yaw``: the fourth is a heading, and is kept.
    """

    takes: int = ALL
    with_place: bool = False
    without_place: bool = False
    flown_to: bool = False
    kept: tuple[int, ...] = ()
    flags: tuple[int, ...] = ()
    has_yaw: bool = False


ITEMS: dict[int, Row] = {
    mav.MAV_CMD_NAV_WAYPOINT: Row(0x7B, with_place=True, flown_to=True, kept=(0, 1), has_yaw=True),
    mav.MAV_CMD_NAV_LOITER_UNLIM: Row(0x7C, with_place=True, flown_to=True, kept=(2,), has_yaw=True),
    mav.MAV_CMD_NAV_LOITER_TIME: Row(0x7F, with_place=True, flown_to=True, kept=(0, 1, 2, 3), flags=(1, 3)),
    mav.MAV_CMD_NAV_RETURN_TO_LAUNCH: Row(0x00, without_place=True),
    mav.MAV_CMD_NAV_LAND: Row(0x7B, with_place=True, flown_to=True, kept=(0, 1), has_yaw=True),
    mav.MAV_CMD_NAV_TAKEOFF: Row(0x79, with_place=True, flown_to=True, has_yaw=True),
    mav.MAV_CMD_NAV_LOITER_TO_ALT: Row(0x7B, with_place=True, flown_to=True, kept=(0, 1, 3), flags=(0, 3)),
    mav.MAV_CMD_NAV_ROI: Row(0x77, with_place=True, without_place=True),
    mav.MAV_CMD_NAV_VTOL_TAKEOFF: Row(0x78, with_place=True, flown_to=True, has_yaw=True),
    mav.MAV_CMD_NAV_VTOL_LAND: Row(0x7C, with_place=True, flown_to=True, has_yaw=True),
    mav.MAV_CMD_NAV_DELAY: Row(0x0F, without_place=True),
    mav.MAV_CMD_CONDITION_DELAY: Row(0x01, without_place=True),
    mav.MAV_CMD_CONDITION_DISTANCE: Row(0x01),
    mav.MAV_CMD_DO_SET_MODE: Row(0x07),
    mav.MAV_CMD_DO_JUMP: Row(0x03, without_place=True),
    mav.MAV_CMD_DO_CHANGE_SPEED: Row(0x07, without_place=True),
    mav.MAV_CMD_DO_SET_HOME: Row(0x7F, without_place=True),
    mav.MAV_CMD_DO_SET_ACTUATOR: Row(without_place=True),
    mav.MAV_CMD_DO_LAND_START: Row(0x70, without_place=True),
    mav.MAV_CMD_DO_SET_ROI_LOCATION: Row(0x70, with_place=True),
    mav.MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET: Row(0x01, without_place=True),
    mav.MAV_CMD_DO_SET_ROI_NONE: Row(0x01, without_place=True),
    mav.MAV_CMD_DO_CONTROL_VIDEO: Row(without_place=True),
    mav.MAV_CMD_DO_SET_ROI: Row(0x07, with_place=True, without_place=True),
    mav.MAV_CMD_DO_DIGICAM_CONFIGURE: Row(without_place=True),
    mav.MAV_CMD_DO_DIGICAM_CONTROL: Row(without_place=True),
    mav.MAV_CMD_DO_MOUNT_CONFIGURE: Row(without_place=True),
    mav.MAV_CMD_DO_MOUNT_CONTROL: Row(without_place=True),
    mav.MAV_CMD_DO_SET_CAM_TRIGG_DIST: Row(0x0F, without_place=True),
    mav.MAV_CMD_DO_GRIPPER: Row(0x03, without_place=True),
    mav.MAV_CMD_DO_AUTOTUNE_ENABLE: Row(0x03, with_place=True, without_place=True),
    mav.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL: Row(0x07, without_place=True),
    mav.MAV_CMD_DO_SET_MISSION_CURRENT: Row(0x00),
    mav.MAV_CMD_OBLIQUE_SURVEY: Row(without_place=True),
    mav.MAV_CMD_COMPONENT_ARM_DISARM: Row(0x03, with_place=True, without_place=True),
    mav.MAV_CMD_INJECT_FAILURE: Row(0x0F),
    mav.MAV_CMD_SET_CAMERA_MODE: Row(0x03, without_place=True),
    mav.MAV_CMD_SET_CAMERA_FOCUS: Row(0x07, without_place=True),
    mav.MAV_CMD_SET_CAMERA_SOURCE: Row(0x07, without_place=True),
    mav.MAV_CMD_DO_SET_GLOBAL_ORIGIN: Row(0x00),
    mav.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW: Row(without_place=True),
    mav.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE: Row(without_place=True),
    mav.MAV_CMD_IMAGE_START_CAPTURE: Row(0x0F, without_place=True),
    mav.MAV_CMD_IMAGE_STOP_CAPTURE: Row(0x01, without_place=True),
    mav.MAV_CMD_DO_TRIGGER_CONTROL: Row(0x0F, without_place=True),
    mav.MAV_CMD_VIDEO_START_CAPTURE: Row(0x07, without_place=True),
    mav.MAV_CMD_VIDEO_STOP_CAPTURE: Row(0x03, without_place=True),
    mav.MAV_CMD_DO_VTOL_TRANSITION: Row(0x03, without_place=True),
    mav.MAV_CMD_CONDITION_GATE: Row(0x00, with_place=True),
    mav.MAV_CMD_NAV_FENCE_RETURN_POINT: Row(0x70, with_place=True),
    mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: Row(0x31, with_place=True, kept=(0,)),
    mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: Row(0x31, with_place=True, kept=(0,)),
    mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: Row(0x31, with_place=True, kept=(0,)),
    mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: Row(0x31, with_place=True, kept=(0,)),
    mav.MAV_CMD_NAV_RALLY_POINT: Row(0x70, with_place=True),
    mav.MAV_CMD_DO_WINCH: Row(0x0F, without_place=True),
}
"""By MAV_CMD. A command that is not here is no mission item, and takes all parameters."""
NOT_AN_ITEM = Row()
FENCE_AND_RALLY = frozenset({
    mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, mav.MAV_CMD_NAV_RALLY_POINT,
})  # fmt: skip
"""Items that are no part of a mission."""
