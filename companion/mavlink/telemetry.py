"""Frames -> VehicleState and VehicleStatus.

Only what the autopilot itself sends counts: PX4 forwards other components' heartbeats between its links, and taking a
ground station's heartbeat for the vehicle's makes it look disarmed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.frames import normalised, rotation_matrix, to_world
from companion.mavlink.codec import Frame
from companion.mavlink.dialect import message
from companion.mavlink.modes import mode_of
from companion.vehicle import FrameOrigin, Home, Landed, VehicleState, VehicleStatus

HEARTBEAT = message("HEARTBEAT")
ODOMETRY = message("ODOMETRY")
CURRENT_MODE = message("CURRENT_MODE")
EXTENDED_SYS_STATE = message("EXTENDED_SYS_STATE")
BATTERY_STATUS = message("BATTERY_STATUS")
ESTIMATOR_STATUS = message("ESTIMATOR_STATUS")
HOME_POSITION = message("HOME_POSITION")
GPS_GLOBAL_ORIGIN = message("GPS_GLOBAL_ORIGIN")

LOCAL_NED = 1
BODY_NED_OLD = 8
BODY_FRD = 12
ARMED_FLAG = 0x80
STANDBY, ACTIVE, CRITICAL = 3, 4, 5


@dataclass(slots=True)
class Telemetry:
    """What one vehicle says. ``home``, ``origin``: None until it has said. ``refused``: states that could not be used,
    by reason."""

    status: VehicleStatus = field(default_factory=VehicleStatus)
    home: Home | None = None
    origin: FrameOrigin | None = None
    refused: dict[str, int] = field(default_factory=dict)

    def receive(self, frame: Frame) -> VehicleState | None:
        """Take a frame of the vehicle in. The state, where the frame brings one."""
        reader = _READERS.get(frame.format.id)
        return None if reader is None else reader(self, frame)

    def _heartbeat(self, frame: Frame) -> None:
        custom_mode, _, _, base_mode, system_status, _ = frame.values
        armed = bool(base_mode & ARMED_FLAG)
        mode = mode_of(custom_mode)
        self.status = self.status._replace(
            armed=armed,
            mode=mode,
            # whose intention a new mode is, only CURRENT_MODE says
            intended=self.status.intended if mode is self.status.mode else None,
            ready=system_status in (STANDBY, ACTIVE, CRITICAL),
            failsafe=system_status == CRITICAL,
        )

    def _current_mode(self, frame: Frame) -> None:
        custom_mode, intended, _ = frame.values
        self.status = self.status._replace(mode=mode_of(custom_mode), intended=mode_of(intended))

    def _extended_state(self, frame: Frame) -> None:
        landed = frame.values[1]
        known = landed in range(len(Landed))
        self.status = self.status._replace(landed=Landed(landed) if known else Landed.UNDEFINED)

    def _battery(self, frame: Frame) -> None:
        remaining = frame.values[17]
        if frame.values[14] == 0 and 0 <= remaining <= 100:  # the first battery; -1 is not known
            self.status = self.status._replace(battery=0.01 * remaining)

    def _estimator(self, frame: Frame) -> None:
        self.status = self.status._replace(estimator=frame.values[9])

    def _home(self, frame: Frame) -> None:
        latitude, longitude, altitude, x, y, z = frame.values[:6]
        if math.isfinite(x + y + z):
            self.home = Home(latitude * 1e-7, longitude * 1e-7, altitude * 1e-3, (x, y, z))

    def _global_origin(self, frame: Frame) -> None:
        latitude, longitude, altitude = frame.values[:3]
        self.origin = FrameOrigin(latitude * 1e-7, longitude * 1e-7, altitude * 1e-3)

    def _odometry(self, frame: Frame) -> VehicleState | None:
        (time_usec, x, y, z, qw, qx, qy, qz, vx, vy, vz, p, q, r) = frame.values[:14]
        frame_id, child_frame_id, resets = frame.values[-5:-2]
        if frame_id != LOCAL_NED:
            self._refuse(f"ODOMETRY in frame {frame_id}, expected LOCAL_NED (1)")
            return None
        if not math.isfinite(x + y + z + qw + qx + qy + qz + vx + vy + vz + p + q + r):
            self._refuse("ODOMETRY that is not finite")
            return None
        if abs(qw * qw + qx * qx + qy * qy + qz * qz - 1.0) > 0.1:
            self._refuse("ODOMETRY without an attitude")
            return None
        attitude = normalised((qw, qx, qy, qz))
        velocity = (vx, vy, vz)
        if child_frame_id in (BODY_FRD, BODY_NED_OLD):  # PX4 up to 1.13
            velocity = to_world(rotation_matrix(attitude), velocity)
        elif child_frame_id != LOCAL_NED:
            self._refuse(f"ODOMETRY with velocity in frame {child_frame_id}, expected LOCAL_NED or BODY_FRD")
            return None
        return VehicleState(time_usec * 1e-6, (x, y, z), velocity, attitude, (p, q, r), resets)

    def _refuse(self, reason: str) -> None:
        self.refused[reason] = self.refused.get(reason, 0) + 1


_READERS: dict[int, Callable[[Telemetry, Frame], VehicleState | None]] = {
    HEARTBEAT.id: Telemetry._heartbeat,
    CURRENT_MODE.id: Telemetry._current_mode,
    EXTENDED_SYS_STATE.id: Telemetry._extended_state,
    ODOMETRY.id: Telemetry._odometry,
    BATTERY_STATUS.id: Telemetry._battery,
    ESTIMATOR_STATUS.id: Telemetry._estimator,
    HOME_POSITION.id: Telemetry._home,
    GPS_GLOBAL_ORIGIN.id: Telemetry._global_origin,
}
WANTED = frozenset(_READERS)
"""The messages telemetry reads."""
