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
from companion.mavlink_common import (
    MAV_FRAME_BODY_FRD,
    MAV_FRAME_BODY_NED,
    MAV_FRAME_LOCAL_NED,
    MAV_MODE_FLAG_SAFETY_ARMED,
    MAV_STATE_ACTIVE,
    MAV_STATE_CRITICAL,
    MAV_STATE_STANDBY,
)
from companion.vehicle import Fact, FrameOrigin, Home, Landed, Mode, VehicleState, VehicleStatus

HEARTBEAT = message("HEARTBEAT")
ODOMETRY = message("ODOMETRY")
CURRENT_MODE = message("CURRENT_MODE")
EXTENDED_SYS_STATE = message("EXTENDED_SYS_STATE")
BATTERY_STATUS = message("BATTERY_STATUS")
ESTIMATOR_STATUS = message("ESTIMATOR_STATUS")
HOME_POSITION = message("HOME_POSITION")
GPS_GLOBAL_ORIGIN = message("GPS_GLOBAL_ORIGIN")


READY_STATES = (MAV_STATE_STANDBY, MAV_STATE_ACTIVE, MAV_STATE_CRITICAL)
"""MAV_STATE of a vehicle that would accept arming, or has."""

CURRENT_MODE_LASTS = 1.5
HEARTBEAT_LASTS = 2.5
EXTENDED_SYS_STATE_LASTS = 2.5
BATTERY_STATUS_LASTS = 10.0
ESTIMATOR_STATUS_LASTS = 5.0
"""s after which what a message said is no longer known: thirty periods of what is asked for (20 Hz), one of the 1 Hz
heartbeat lost; for the others at least two of PX4's slowest default (engineering choice)."""

POSITION_MAX = 1e5
"""m from the local origin: a float32 resolves 8 mm there (engineering choice)."""
SPEED_MAX = 200.0
"""m/s: several times what a multirotor reaches (engineering choice)."""
RATE_MAX = 70.0
"""rad/s: 4000 deg/s, the widest range of the gyros that PX4 has drivers for."""
STAMP_MAX = 1 << 52
"""us: 142 years, which covers a clock since boot and one since 1970; beyond, a double does not resolve 1 us."""
ALTITUDE_MAX = 1e5
"""m above mean sea level (engineering choice)."""


@dataclass(slots=True)
class Telemetry:
    """What one vehicle says. ``home``, ``origin``: None until it has said. ``refused``: states that could not be used,
    by reason. ``own_mode``: a flight mode of our own, which counts as OFFBOARD; None: there is none."""

    status: VehicleStatus = field(default_factory=VehicleStatus)
    home: Home | None = None
    origin: FrameOrigin | None = None
    refused: dict[str, int] = field(default_factory=dict)
    own_mode: Mode | None = None

    _now: float = 0.0

    def receive(self, frame: Frame, now: float) -> VehicleState | None:
        """Take a frame of the vehicle in, at ``now`` s by our clock. The state, where the frame brings one."""
        self._now = now
        reader = _READERS.get(frame.format.id)
        return None if reader is None else reader(self, frame)

    def _mode(self, custom_mode: int) -> Mode:
        """The mode. Our own one is what OFFBOARD is else: the mode in which the vehicle flies on our setpoints."""
        mode = mode_of(custom_mode)
        return Mode.OFFBOARD if mode is self.own_mode else mode

    def _heartbeat(self, frame: Frame) -> None:
        custom_mode, _, _, base_mode, system_status, _ = frame.values
        armed = bool(base_mode & MAV_MODE_FLAG_SAFETY_ARMED)
        mode, before, now = self._mode(custom_mode), self.status.mode, self._now
        self.status = self.status._replace(
            armed=Fact(armed, now, HEARTBEAT_LASTS),
            mode=Fact(mode, now, HEARTBEAT_LASTS),
            # whose intention a new mode is, only CURRENT_MODE says
            intended=self.status.intended if before is not None and mode is before.value else None,
            ready=Fact(system_status in READY_STATES, now, HEARTBEAT_LASTS),
            failsafe=Fact(system_status == MAV_STATE_CRITICAL, now, HEARTBEAT_LASTS),
            was_armed=self.status.was_armed or armed,
        )

    def _current_mode(self, frame: Frame) -> None:
        custom_mode, intended, _ = frame.values
        self.status = self.status._replace(
            mode=Fact(self._mode(custom_mode), self._now, CURRENT_MODE_LASTS),
            intended=Fact(self._mode(intended), self._now, CURRENT_MODE_LASTS),
        )

    def _extended_state(self, frame: Frame) -> None:
        landed = frame.values[1]
        place = Landed(landed) if landed in range(len(Landed)) else Landed.UNDEFINED
        self.status = self.status._replace(landed=Fact(place, self._now, EXTENDED_SYS_STATE_LASTS))

    def _battery(self, frame: Frame) -> None:
        remaining = frame.values[17]
        if frame.values[14] == 0 and 0 <= remaining <= 100:  # the first battery; -1 is not known
            self.status = self.status._replace(battery=Fact(0.01 * remaining, self._now, BATTERY_STATUS_LASTS))

    def _estimator(self, frame: Frame) -> None:
        self.status = self.status._replace(estimator=Fact(frame.values[9], self._now, ESTIMATOR_STATUS_LASTS))

    def _home(self, frame: Frame) -> None:
        latitude, longitude, altitude, x, y, z = frame.values[:6]
        if _is_on_earth(latitude, longitude, altitude) and math.hypot(x, y, z) <= POSITION_MAX:
            self.home = Home(latitude * 1e-7, longitude * 1e-7, altitude * 1e-3, (x, y, z))

    def _global_origin(self, frame: Frame) -> None:
        latitude, longitude, altitude = frame.values[:3]
        if not _is_on_earth(latitude, longitude, altitude):
            self._refuse("GPS_GLOBAL_ORIGIN that is no place on earth")
            return
        self.origin = FrameOrigin(latitude * 1e-7, longitude * 1e-7, altitude * 1e-3)

    def _odometry(self, frame: Frame) -> VehicleState | None:
        (time_usec, x, y, z, qw, qx, qy, qz, vx, vy, vz, p, q, r) = frame.values[:14]
        frame_id, child_frame_id, resets = frame.values[-5:-2]  # before estimator_type and quality
        if frame_id != MAV_FRAME_LOCAL_NED:
            self._refuse(f"ODOMETRY in frame {frame_id}, expected LOCAL_NED (1)")
            return None
        if not math.isfinite(x + y + z + qw + qx + qy + qz + vx + vy + vz + p + q + r):
            self._refuse("ODOMETRY that is not finite")
            return None
        impossible = (
            "stamped later than 142 years" if time_usec >= STAMP_MAX
            else f"further than {1e-3 * POSITION_MAX:g} km from its origin"
            if x * x + y * y + z * z > POSITION_MAX * POSITION_MAX
            else f"faster than {SPEED_MAX:g} m/s" if vx * vx + vy * vy + vz * vz > SPEED_MAX * SPEED_MAX
            else f"turning faster than {RATE_MAX:g} rad/s" if p * p + q * q + r * r > RATE_MAX * RATE_MAX
            else None
        )  # fmt: skip
        if impossible is not None:
            self._refuse(f"ODOMETRY {impossible}")
            return None
        if abs(qw * qw + qx * qx + qy * qy + qz * qz - 1.0) > 0.1:
            self._refuse("ODOMETRY without an attitude")
            return None
        attitude = normalised((qw, qx, qy, qz))
        velocity = (vx, vy, vz)
        if child_frame_id in (MAV_FRAME_BODY_FRD, MAV_FRAME_BODY_NED):  # PX4 up to 1.13
            velocity = to_world(rotation_matrix(attitude), velocity)
        elif child_frame_id != MAV_FRAME_LOCAL_NED:
            self._refuse(f"ODOMETRY with velocity in frame {child_frame_id}, expected LOCAL_NED or BODY_FRD")
            return None
        return VehicleState(time_usec * 1e-6, (x, y, z), velocity, attitude, (p, q, r), resets)

    def _refuse(self, reason: str) -> None:
        self.refused[reason] = self.refused.get(reason, 0) + 1


def _is_on_earth(latitude: int, longitude: int, altitude: int) -> bool:
    """Whether degrees * 1e7 and mm are a place near the earth's surface."""
    return abs(latitude) <= 900_000_000 and abs(longitude) <= 1_800_000_000 and abs(altitude) <= 1e3 * ALTITUDE_MAX


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
