"""SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT as PX4 reads them: places, velocities, accelerations and mixtures.

What a mask leaves out, and what is not a number, is not asked for. A message that asks for nothing is told of in words
and does not count as a setpoint.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from companion.frames import Matrix3, Quaternion, Vec3, euler_from_rotation, rotation_matrix, to_world
from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Value, message
from companion.mavlink_common import (
    MAV_FRAME_BODY_NED,
    MAV_FRAME_GLOBAL_INT,
    MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
    MAV_FRAME_GLOBAL_TERRAIN_ALT_INT,
    MAV_FRAME_LOCAL_NED,
)
from sim_bridge.control.position import NOTHING, Axes

LOCAL, GLOBAL = message("SET_POSITION_TARGET_LOCAL_NED"), message("SET_POSITION_TARGET_GLOBAL_INT")
FORCE = 1 << 9
"""POSITION_TARGET_TYPEMASK: the acceleration is a force."""
IGNORE_HEADING = 1 << 10
"""POSITION_TARGET_TYPEMASK: no heading is asked for."""
IGNORE_HEADING_RATE = 1 << 11
"""POSITION_TARGET_TYPEMASK: no rate of heading is asked for."""
FARTHEST = 1e6
"""m, m/s, m/s^2: nothing beyond is arithmetic worth doing."""


@dataclass(frozen=True, slots=True)
class TrajectorySetpoint:
    """Place (m), velocity (m/s), acceleration (m/s^2) in NED, heading (rad) and its rate (rad/s); None: not asked."""

    position: Axes
    velocity: Axes
    acceleration: Axes
    heading: float | None
    heading_rate: float

    @property
    def can_be_flown(self) -> bool:
        """Whether every axis has something, and north and east always the same things."""
        kinds = (self.position, self.velocity, self.acceleration)
        complete = all(any(kind[axis] is not None for kind in kinds) for axis in range(3))
        return complete and all((kind[0] is None) is (kind[1] is None) for kind in kinds)

    def climbs_from(self, down: float) -> bool:
        """Whether it asks a vehicle that stands at ``down`` (m, NED) to leave the ground."""
        z, vz, az = self.position[2], self.velocity[2], self.acceleration[2]
        if z is not None and z < down:
            return True
        return (vz is not None and vz < 0.0) or (az is not None and az < 0.0)

    def sinks(self, down: float) -> bool:
        """Whether it asks a vehicle at ``down`` (m, NED) to go down."""
        z, vz = self.position[2], self.velocity[2]
        return (z is not None and z > down) or (z is None and vz is not None and vz > 0.0)


def local_target(frame: Frame, q_nb: Quaternion) -> TrajectorySetpoint | str:
    """What a SET_POSITION_TARGET_LOCAL_NED asks a vehicle of attitude ``q_nb`` for, or the text it is refused with."""
    said = frame.format.named(frame.values)
    mask, kind = said["type_mask"], said["coordinate_frame"]
    position, velocity, acceleration = (
        _axes(said, names, mask >> shift) for names, shift in (("x y z", 0), ("vx vy vz", 3), ("afx afy afz", 6))
    )
    if kind == MAV_FRAME_BODY_NED:
        position = NOTHING
        velocity = _turned(velocity, said, "vx vy vz", mask >> 3, _level_only(q_nb))
        acceleration = _turned(acceleration, said, "afx afy afz", mask >> 6, rotation_matrix(q_nb))
    elif kind != MAV_FRAME_LOCAL_NED:
        return f"SET_POSITION_TARGET_LOCAL_NED coordinate frame {kind} unsupported\t"
    if position == velocity == acceleration == NOTHING:
        return "SET_POSITION_TARGET_LOCAL_NED invalid\t"
    if acceleration != NOTHING and mask & FORCE:
        return "SET_POSITION_TARGET_LOCAL_NED force not supported\t"
    return TrajectorySetpoint(position, velocity, acceleration, *_headings(said, mask))


def global_target(
    frame: Frame, place_of: Callable[[float, float, float, int], Vec3 | None]
) -> TrajectorySetpoint | str | None:
    """The same of a SET_POSITION_TARGET_GLOBAL_INT; None: nothing, and nothing is said of it.

    ``place_of``: latitude, longitude (degrees), altitude (m) and frame to a place in NED; None: not known.
    """
    said = frame.format.named(frame.values)
    mask, kind = said["type_mask"], said["coordinate_frame"]
    position: Axes = NOTHING
    if not mask & 7:
        if kind not in (MAV_FRAME_GLOBAL_INT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, MAV_FRAME_GLOBAL_TERRAIN_ALT_INT):
            return f"SET_POSITION_TARGET_GLOBAL_INT invalid coordinate frame {kind}\t"
        place = place_of(said["lat_int"] * 1e-7, said["lon_int"] * 1e-7, said["alt"], kind)
        if place is None:
            return None
        position = place
    velocity, acceleration = _axes(said, "vx vy vz", mask >> 3), _axes(said, "afx afy afz", mask >> 6)
    if position == velocity == acceleration == NOTHING:
        return None
    if acceleration != NOTHING and mask & FORCE:
        return "SET_POSITION_TARGET_GLOBAL_INT force not supported\t"
    return TrajectorySetpoint(position, velocity, acceleration, *_headings(said, mask))


def _axes(said: Mapping[str, Value], names: str, ignored: int) -> Axes:
    """Three fields, None where ignored or no number."""
    x, y, z = (
        None if ignored >> i & 1 or not math.isfinite(said[name]) else max(-FARTHEST, min(FARTHEST, said[name]))
        for i, name in enumerate(names.split())
    )
    return (x, y, z)


def _turned(axes: Axes, said: Mapping[str, Value], names: str, ignored: int, rotation: Matrix3) -> Axes:
    """Three numbers of the body's frame in NED; all of them or none."""
    x, y, z = axes
    if ignored & 7 or x is None or y is None or z is None:
        return NOTHING
    return to_world(rotation, (x, y, z))


def _level_only(q_nb: Quaternion) -> Matrix3:
    heading = euler_from_rotation(rotation_matrix(q_nb))[0]
    c, s = math.cos(heading), math.sin(heading)
    return (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def _headings(said: Mapping[str, Value], mask: int) -> tuple[float | None, float]:
    heading, rate = said["yaw"], said["yaw_rate"]
    wanted = None if mask & IGNORE_HEADING or not math.isfinite(heading) else math.remainder(heading, math.tau)
    turns = 0.0 if mask & IGNORE_HEADING_RATE or not math.isfinite(rate) else max(-10.0, min(10.0, rate))
    return wanted, turns
