"""PX4's streams: what each link sends by default, and how often the source of a message is renewed.

Measured on PX4's simulation by asking for every message; the figures are those its MESSAGE_INTERVAL tells.
"""

from __future__ import annotations

import math
from typing import NamedTuple

STEP_US = 4_000
"""The period of PX4's gyro and attitude in simulation, and of its sending."""
ESTIMATOR_US = 8_000
"""The period of PX4's estimator in simulation: what caps position and odometry."""
UNLIMITED = math.inf
"""As often as the source is renewed."""
OFF = None


class Row(NamedTuple):
    """Default rates (Hz) to a companion and to a ground station, and the period of the source (us)."""

    onboard: float | None
    ground_station: float | None
    source_us: int = STEP_US


TABLE: dict[str, Row] = {
    "ACTUATOR_OUTPUT_STATUS": Row(OFF, OFF),
    "ALTITUDE": Row(10, 1),
    "ATTITUDE": Row(100, 50),
    "ATTITUDE_QUATERNION": Row(50, 50),
    "ATTITUDE_TARGET": Row(10, 50, ESTIMATOR_US),
    "AUTOPILOT_STATE_FOR_GIMBAL_DEVICE": Row(OFF, OFF),
    "AUTOPILOT_VERSION": Row(OFF, OFF),
    "BATTERY_STATUS": Row(0.5, 0.5, 10_000),
    "CURRENT_MODE": Row(0.5, 0.5),
    "DISTANCE_SENSOR": Row(10, 0.5, 20_000),
    "ESC_INFO": Row(10, 1),
    "ESC_STATUS": Row(10, 1),
    "ESTIMATOR_SENSOR_FUSION_STATUS": Row(1, 0.5, ESTIMATOR_US),
    "ESTIMATOR_STATUS": Row(1, 0.5, ESTIMATOR_US),
    "EXTENDED_SYS_STATE": Row(5, 1),
    "FLIGHT_INFORMATION": Row(OFF, OFF),
    "GLOBAL_POSITION_INT": Row(50, 50, ESTIMATOR_US),
    "GNSS_INTEGRITY": Row(1, 1, 125_000),
    "GPS_GLOBAL_ORIGIN": Row(1, 1),
    "GPS_RAW_INT": Row(UNLIMITED, 5, 125_000),
    "HEARTBEAT": Row(1, 1),
    "HIGHRES_IMU": Row(50, OFF),
    "HIL_ACTUATOR_CONTROLS": Row(OFF, OFF),
    "HIL_STATE_QUATERNION": Row(OFF, OFF),
    "HOME_POSITION": Row(0.5, 0.5),
    "LINK_NODE_STATUS": Row(1, 1),
    "LOCAL_POSITION_NED": Row(30, 50, ESTIMATOR_US),
    "ODOMETRY": Row(30, OFF, ESTIMATOR_US),
    "OPEN_DRONE_ID_BASIC_ID": Row(OFF, OFF, 500_000),
    "OPEN_DRONE_ID_LOCATION": Row(1, 1),
    "OPEN_DRONE_ID_SYSTEM": Row(1, 1, 125_000),
    "ORBIT_EXECUTION_STATUS": Row(5, 2),
    "PING": Row(1, 0.1),
    "POSITION_TARGET_GLOBAL_INT": Row(10, 1),
    "POSITION_TARGET_LOCAL_NED": Row(10, 50, ESTIMATOR_US),
    "PROTOCOL_VERSION": Row(OFF, OFF),
    "SCALED_IMU": Row(OFF, OFF),
    "SCALED_PRESSURE": Row(1, 1, 50_000),
    "SERVO_OUTPUT_RAW": Row(10, 50),
    "STORAGE_INFORMATION": Row(OFF, OFF),
    "SYSTEM_TIME": Row(1, OFF),
    "SYS_STATUS": Row(5, 1, 10_000),
    "TIMESYNC": Row(10, OFF),
    "TIME_ESTIMATE_TO_TARGET": Row(1, 1, 2_000_000),
    "VFR_HUD": Row(10, 4, ESTIMATOR_US),
    "VIBRATION": Row(0.5, 0.1, 100_000),
}
"""The messages that are sent."""

SILENT: dict[int, Row] = {
    25: Row(1, 1), 62: Row(10, 1), 65: Row(20, 20), 69: Row(OFF, OFF), 76: Row(UNLIMITED, UNLIMITED),
    106: Row(10, 10), 112: Row(UNLIMITED, OFF), 116: Row(OFF, OFF), 124: Row(UNLIMITED, 1), 129: Row(OFF, OFF),
    137: Row(OFF, OFF), 143: Row(OFF, OFF), 149: Row(OFF, OFF), 192: Row(OFF, OFF), 225: Row(2, 2), 231: Row(10, 0.5),
    233: Row(OFF, OFF), 235: Row(OFF, OFF), 246: Row(UNLIMITED, UNLIMITED), 250: Row(10, 1), 251: Row(10, 1),
    253: Row(OFF, 20), 254: Row(10, 1), 263: Row(UNLIMITED, UNLIMITED), 265: Row(10, 10), 280: Row(OFF, OFF),
    281: Row(0.5, 0.5), 283: Row(OFF, OFF), 284: Row(5, 5), 285: Row(5, 5), 296: Row(OFF, 5), 330: Row(10, 1),
    339: Row(5, 2), 350: Row(10, 1), 361: Row(5, 5), 371: Row(1, 1), 372: Row(OFF, OFF),
    395: Row(OFF, OFF), 397: Row(OFF, OFF), 435: Row(0.3, 0.3), 12918: Row(1, 1), 12920: Row(1, 0.1),
}  # fmt: skip
"""Streams that PX4 has, whose intervals can be set and asked for, and that never have anything to send here."""
