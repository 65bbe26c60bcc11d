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
    25: Row(1, 1),  # GPS_STATUS
    62: Row(10, 1),  # NAV_CONTROLLER_OUTPUT
    65: Row(20, 20),  # RC_CHANNELS
    69: Row(OFF, OFF),  # MANUAL_CONTROL
    76: Row(UNLIMITED, UNLIMITED),  # COMMAND_LONG
    106: Row(10, 10),  # OPTICAL_FLOW_RAD
    112: Row(UNLIMITED, OFF),  # CAMERA_TRIGGER
    116: Row(OFF, OFF),  # SCALED_IMU2
    124: Row(UNLIMITED, 1),  # GPS2_RAW
    129: Row(OFF, OFF),  # SCALED_IMU3
    137: Row(OFF, OFF),  # SCALED_PRESSURE2
    143: Row(OFF, OFF),  # SCALED_PRESSURE3
    149: Row(OFF, OFF),  # LANDING_TARGET
    192: Row(OFF, OFF),  # MAG_CAL_REPORT
    225: Row(2, 2),  # EFI_STATUS
    231: Row(10, 0.5),  # WIND_COV
    233: Row(OFF, OFF),  # GPS_RTCM_DATA
    235: Row(OFF, OFF),  # HIGH_LATENCY2
    246: Row(UNLIMITED, UNLIMITED),  # ADSB_VEHICLE
    250: Row(10, 1),  # DEBUG_VECT
    251: Row(10, 1),  # NAMED_VALUE_FLOAT
    253: Row(OFF, 20),  # STATUSTEXT
    254: Row(10, 1),  # DEBUG
    263: Row(UNLIMITED, UNLIMITED),  # CAMERA_IMAGE_CAPTURED
    265: Row(10, 10),  # MOUNT_ORIENTATION
    280: Row(OFF, OFF),  # GIMBAL_MANAGER_INFORMATION
    281: Row(0.5, 0.5),  # GIMBAL_MANAGER_STATUS
    283: Row(OFF, OFF),  # GIMBAL_DEVICE_INFORMATION
    284: Row(5, 5),  # GIMBAL_DEVICE_SET_ATTITUDE
    285: Row(5, 5),  # GIMBAL_DEVICE_ATTITUDE_STATUS
    296: Row(OFF, 5),  # GLOBAL_POSITION_SENSOR
    330: Row(10, 1),  # OBSTACLE_DISTANCE
    339: Row(5, 2),  # RAW_RPM
    350: Row(10, 1),  # DEBUG_FLOAT_ARRAY
    361: Row(5, 5),  # FIGURE_EIGHT_EXECUTION_STATUS
    371: Row(1, 1),  # FUEL_STATUS
    372: Row(OFF, OFF),  # BATTERY_INFO
    395: Row(OFF, OFF),  # COMPONENT_INFORMATION
    397: Row(OFF, OFF),  # COMPONENT_METADATA
    435: Row(0.3, 0.3),  # AVAILABLE_MODES
    12918: Row(1, 1),  # OPEN_DRONE_ID_ARM_STATUS
    12920: Row(1, 0.1),  # HYGROMETER_SENSOR
}
"""Streams that PX4 has, whose intervals can be set and asked for, and that never have anything to send here."""
