"""What the vehicle says: one small function a message, from the autopilot to the values in wire order.

parts       what several messages are made of
motion      attitude, position, velocity, altitude, home
targets     what the vehicle wants: attitude and position targets, motor outputs
identity    who it is, what it can do, which mode it is in
health      sensors, estimator, battery, clocks
remote_id   Open Drone ID

The hot ones are written out in wire order; ``Format.values`` by name serves where ten times a second is enough.
"""

from __future__ import annotations

from companion.mavlink.dialect import BY_NAME, Format
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.messages import health, identity, motion, remote_id, targets
from sim_bridge.autopilot.messages.parts import Build, Values

__all__ = ["BUILDERS", "EDITIONS", "Build", "Values"]

BUILDERS: dict[int, tuple[Format, Build]] = {
    BY_NAME[name].id: (BY_NAME[name], build)
    for name, build in (
        ("ACTUATOR_OUTPUT_STATUS", targets.actuator_output_status),
        ("ALTITUDE", motion.altitude),
        ("ATTITUDE", motion.attitude),
        ("ATTITUDE_QUATERNION", motion.attitude_quaternion),
        ("ATTITUDE_TARGET", targets.attitude_target),
        ("AUTOPILOT_STATE_FOR_GIMBAL_DEVICE", health.autopilot_state_for_gimbal_device),
        ("AUTOPILOT_VERSION", identity.autopilot_version),
        ("BATTERY_STATUS", health.battery_status),
        ("COMPONENT_INFORMATION", identity.component_information),
        ("COMPONENT_METADATA", identity.component_metadata),
        ("CURRENT_MODE", identity.current_mode),
        ("DISTANCE_SENSOR", motion.distance_sensor),
        ("ESC_INFO", targets.esc_info),
        ("ESC_STATUS", targets.esc_status),
        ("ESTIMATOR_SENSOR_FUSION_STATUS", health.estimator_sensor_fusion_status),
        ("ESTIMATOR_STATUS", health.estimator_status),
        ("EXTENDED_SYS_STATE", health.extended_sys_state),
        ("FLIGHT_INFORMATION", identity.flight_information),
        ("GLOBAL_POSITION_INT", motion.global_position_int),
        ("GNSS_INTEGRITY", health.gnss_integrity),
        ("GPS_GLOBAL_ORIGIN", motion.gps_global_origin),
        ("GPS_RAW_INT", motion.gps_raw_int),
        ("HEARTBEAT", identity.heartbeat),
        ("HIGHRES_IMU", motion.highres_imu),
        ("HIL_ACTUATOR_CONTROLS", targets.hil_actuator_controls),
        ("HIL_STATE_QUATERNION", motion.hil_state_quaternion),
        ("HOME_POSITION", motion.home_position),
        ("LOCAL_POSITION_NED", motion.local_position_ned),
        ("MAG_CAL_REPORT", health.mag_cal_report),
        ("ODOMETRY", motion.odometry),
        ("OPEN_DRONE_ID_BASIC_ID", remote_id.basic_id),
        ("OPEN_DRONE_ID_LOCATION", remote_id.location),
        ("OPEN_DRONE_ID_SYSTEM", remote_id.system),
        ("PING", health.ping),
        ("ORBIT_EXECUTION_STATUS", targets.orbit_execution_status),
        ("POSITION_TARGET_GLOBAL_INT", targets.position_target_global_int),
        ("POSITION_TARGET_LOCAL_NED", targets.position_target_local_ned),
        ("PROTOCOL_VERSION", identity.protocol_version),
        ("SCALED_IMU", motion.scaled_imu),
        ("SCALED_PRESSURE", motion.scaled_pressure),
        ("SERVO_OUTPUT_RAW", targets.servo_output_raw),
        ("STORAGE_INFORMATION", identity.storage_information),
        ("SYSTEM_TIME", health.system_time),
        ("SYS_STATUS", health.sys_status),
        ("TIMESYNC", health.timesync),
        ("TIME_ESTIMATE_TO_TARGET", health.time_estimate_to_target),
        ("VFR_HUD", motion.vfr_hud),
        ("VIBRATION", health.vibration),
    )
}
"""Message id -> its format and the function that fills it."""


def _mode_edition(a: Autopilot) -> object:
    """PX4 publishes its status twice a second, and at once when it changes."""
    return (a.commander.mode, a.commander.user_intended_mode, a.commander.armed, a.estimate.time_us // 500_000)


def _origin_edition(a: Autopilot) -> object:
    return a.home_position.origin_set_us


EDITIONS = {BY_NAME["CURRENT_MODE"].id: _mode_edition, BY_NAME["GPS_GLOBAL_ORIGIN"].id: _origin_edition}
"""Messages that are streamed only when there is something new: what tells one edition from the next."""
