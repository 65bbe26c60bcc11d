"""PX4's own position control, told everything: position, velocity and acceleration setpoints over MAVLink at 90 Hz."""

from __future__ import annotations

import math

from companion.frames import euler_from_rotation, rotation_matrix, tilt
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import Value, message
from companion.mavlink.modes import Mode
from companion.mavlink_common import (
    MAV_CMD_DO_SET_MODE,
    MAV_COMP_ID_AUTOPILOT1,
    MAV_COMP_ID_ONBOARD_COMPUTER,
    MAV_FRAME_LOCAL_NED,
)
from companion.vehicle import Vehicle
from companion.world import Start, World
from sim_bridge.bridge import Bridge
from trials.rivals.course import Course
from trials.rivals.figures import Sample

PERIOD = 1.0 / 90.0
STREAM_FIRST = 0.5
"""s of setpoints before OFFBOARD is asked for."""
USE_YAW = 0x800
"""Position, velocity, acceleration and yaw are used, the yaw rate is not."""


def fly(
    course: Course, vehicle: Vehicle, world: World, seconds: float, seed: int = 0, believed: bool = False
) -> list[Sample]:
    """The track from the beginning of the timetable on: the true one, or as the vehicle believes."""
    first = course.at(0.0)
    bridge = Bridge(vehicle, world, seed=seed, start=Start.hover(first.p_n), endpoints=1)
    encoder = Encoder(1, MAV_COMP_ID_ONBOARD_COMPUTER)
    track: list[Sample] = []
    due = begun = bridge.now
    while bridge.now - begun < STREAM_FIRST + seconds:
        bridge.step()
        bridge.datagrams()
        t = bridge.now - begun - STREAM_FIRST
        if bridge.now >= due:
            due += PERIOD
            bridge.receive(encoder.message(message("SET_POSITION_TARGET_LOCAL_NED"), **_setpoint(course, max(t, 0.0))))
        if -PERIOD <= t < 0.0:
            bridge.receive(encoder.message(message("COMMAND_LONG"), **_offboard()))
        if t >= 0.0:
            track.append(sample(t, bridge, believed))
    return track


def sample(t: float, bridge: Bridge, believed: bool) -> Sample:
    """The plant's state as a sample of a track."""
    seen = bridge.autopilot.estimate if believed else bridge.truth
    r_nb = rotation_matrix(seen.q_nb)
    return Sample(t, seen.p_n, seen.v_n, euler_from_rotation(r_nb)[0], tilt(r_nb))


def _setpoint(course: Course, t: float) -> dict[str, Value]:
    moment = course.at(t)
    fields: dict[str, Value] = {
        "coordinate_frame": MAV_FRAME_LOCAL_NED,
        "type_mask": USE_YAW,
        "yaw": 0.0,
        "yaw_rate": math.nan,
    }
    for names, values in (
        (("x", "y", "z"), moment.p_n),
        (("vx", "vy", "vz"), moment.v_n),
        (("afx", "afy", "afz"), moment.a_n),
    ):
        fields |= dict(zip(names, values, strict=True))
    return {**fields, "target_system": 1, "target_component": MAV_COMP_ID_AUTOPILOT1}


def _offboard() -> dict[str, Value]:
    return {
        "command": MAV_CMD_DO_SET_MODE, "param1": 1.0, "param2": float(Mode.OFFBOARD.main), "param3": float(Mode.OFFBOARD.sub),
        "target_system": 1, "target_component": MAV_COMP_ID_AUTOPILOT1,
    }  # fmt: skip
