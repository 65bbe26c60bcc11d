"""What a plan has cameras, gimbals, grippers and servos do where it comes to a waypoint.

These are requests to the payload. None of them flies, arms or changes a mode.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.mavlink_common import (
    MAV_CMD_DO_DIGICAM_CONFIGURE,
    MAV_CMD_DO_DIGICAM_CONTROL,
    MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
    MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
    MAV_CMD_DO_GRIPPER,
    MAV_CMD_DO_MOUNT_CONFIGURE,
    MAV_CMD_DO_MOUNT_CONTROL,
    MAV_CMD_DO_REPEAT_RELAY,
    MAV_CMD_DO_REPEAT_SERVO,
    MAV_CMD_DO_SET_ACTUATOR,
    MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL,
    MAV_CMD_DO_SET_RELAY,
    MAV_CMD_DO_SET_SERVO,
    MAV_CMD_DO_TRIGGER_CONTROL,
    MAV_CMD_IMAGE_START_CAPTURE,
    MAV_CMD_IMAGE_STOP_CAPTURE,
    MAV_CMD_SET_CAMERA_FOCUS,
    MAV_CMD_SET_CAMERA_MODE,
    MAV_CMD_SET_CAMERA_ZOOM,
    MAV_CMD_VIDEO_START_CAPTURE,
    MAV_CMD_VIDEO_STOP_CAPTURE,
)

PAYLOAD = frozenset({
    MAV_CMD_DO_SET_RELAY, MAV_CMD_DO_REPEAT_RELAY, MAV_CMD_DO_SET_SERVO, MAV_CMD_DO_REPEAT_SERVO,
    MAV_CMD_DO_SET_ACTUATOR, MAV_CMD_DO_GRIPPER, MAV_CMD_DO_DIGICAM_CONFIGURE, MAV_CMD_DO_DIGICAM_CONTROL,
    MAV_CMD_DO_MOUNT_CONFIGURE, MAV_CMD_DO_MOUNT_CONTROL, MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL, MAV_CMD_DO_TRIGGER_CONTROL, MAV_CMD_SET_CAMERA_MODE, MAV_CMD_SET_CAMERA_ZOOM,
    MAV_CMD_SET_CAMERA_FOCUS, MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
    MAV_CMD_IMAGE_START_CAPTURE, MAV_CMD_IMAGE_STOP_CAPTURE, MAV_CMD_VIDEO_START_CAPTURE, MAV_CMD_VIDEO_STOP_CAPTURE,
})  # fmt: skip
"""The commands that are sent on at their place."""
ONE_PHOTO = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
"""The parameters of MAV_CMD_DO_DIGICAM_CONTROL for one picture."""
PHOTOS_MAX = 20_000
"""of one trigger distance: a flight of hours, and more is a mistake."""
CORNER_SHARE = 0.25
"""Of a trigger distance: what a rounded corner may take off a line without its last picture being lost."""


class PayloadCommand(NamedTuple):
    """One command for the payload: MAV_CMD, its seven parameters (0 where the plan says null), its item's number."""

    command: int
    params: tuple[float, ...]
    number: int


class PlacedCommand(NamedTuple):
    """A command and the arc length (m) at which it is sent."""

    s: float
    command: PayloadCommand


def placed_along(stops: list[tuple[float, tuple[PayloadCommand, ...]]], length: float) -> list[PlacedCommand]:
    """The commands in the order of the path. ``stops``: arc lengths (m) of the waypoints, with what the payload does
    at each. A trigger distance becomes a picture every so many metres, until it is set to 0 or the path ends.
    ValueError: so many pictures are no survey."""
    found: list[PlacedCommand] = []
    trigger: tuple[float, PayloadCommand] | None = None

    def shoot(until: float) -> None:
        if trigger is None:
            return
        begin, order = trigger
        every = order.params[0]
        first = 0 if order.params[2] == 1.0 else 1  # at once, too
        count = int((until - begin) / every + CORNER_SHARE)
        if count > PHOTOS_MAX:
            raise ValueError(f"takes {count} pictures from item {order.number} on; expected {PHOTOS_MAX} at most")
        photo = PayloadCommand(MAV_CMD_DO_DIGICAM_CONTROL, ONE_PHOTO, order.number)
        found.extend(PlacedCommand(min(begin + every * i, until), photo) for i in range(first, count + 1))

    for s, commands in stops:
        for command in commands:
            if command.command != MAV_CMD_DO_SET_CAM_TRIGG_DIST:
                found.append(PlacedCommand(s, command))
                continue
            shoot(s)
            trigger = (s, command) if command.params[0] > 0.0 else None
    shoot(length)
    return sorted(found, key=lambda placed: placed.s)
