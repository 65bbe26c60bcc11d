"""The vehicle's state as samples of PX4's topics, in the layout of each release."""

from __future__ import annotations

from companion.frames import rotation_matrix, to_body
from companion.mavlink.modes import Mode
from companion.mavlink_common import MAV_TYPE_QUADROTOR
from companion.xrce.topics import LAYOUTS, Layout
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander.commander import MANUAL
from sim_bridge.autopilot.commander.external_modes import EXTERNAL, nav_state_of
from sim_bridge.autopilot.flight_modes.topics import Level
from sim_bridge.autopilot.messages.parts import altitude_of, heading_of
from sim_bridge.autopilot.xrce.topic_table import Release

GYRO_US = 4_000
"""us between two samples of the gyro."""
SOURCE_DDS = 2  # TimesyncStatus.SOURCE_PROTOCOL_DDS
FRAME_NED = 1
"""VehicleOdometry's POSE_FRAME_NED and VELOCITY_FRAME_NED."""
DISARMED = 1  # VehicleStatus.ARMING_STATE_DISARMED
ARMED = 2  # VehicleStatus.ARMING_STATE_ARMED
ROTARY_WING = 1  # VehicleStatus.vehicle_type
ACCURACY = 0.1
"""m and m/s: a standard deviation of the estimate that is told (plausible; nothing here estimates it)."""
NAV_STATE = {
    Mode.MANUAL: 0, Mode.ALTITUDE: 1, Mode.POSITION: 2, Mode.MISSION: 3, Mode.HOLD: 4, Mode.RETURN: 5,
    Mode.POSITION_SLOW: 6, Mode.ALTITUDE_CRUISE: 8, Mode.ACRO: 10, Mode.DESCEND: 12, Mode.TERMINATION: 13,
    Mode.OFFBOARD: 14, Mode.STABILIZED: 15, Mode.TAKEOFF: 17, Mode.LAND: 18, Mode.FOLLOW: 19, Mode.PRECISION_LAND: 20,
    Mode.ORBIT: 21,
}  # fmt: skip
"""VehicleStatus's NAVIGATION_STATE_* of a mode."""

_STAMPS = "timestamp:Q timestamp_sample:Q"
_STATUS = (
    "timestamp:Q armed_time:Q takeoff_time:Q arming_state:B latest_arming_reason:B latest_disarming_reason:B "
    "nav_state_timestamp:Q nav_state_user_intention:B nav_state:B {}valid_nav_states_mask:I can_set_nav_states_mask:I "
    "failure_detector_status:H hil_state:B vehicle_type:B failsafe:? failsafe_and_user_took_over:? "
    "failsafe_defer_state:B gcs_connection_lost:? gcs_connection_lost_counter:B high_latency_data_link_lost:? "
    "is_vtol:? is_vtol_tailsitter:? in_transition_mode:? in_transition_to_fw:? system_type:B system_id:B "
    "component_id:B safety_button_available:? safety_off:? power_input_valid:? usb_connected:? "
    "open_drone_id_system_present:? open_drone_id_system_healthy:? parachute_system_present:? "
    "parachute_system_healthy:? {}rc_calibration_in_progress:? calibration_enabled:? pre_flight_checks_pass:?"
)
_LOCAL = (
    f"{_STAMPS} xy_valid:? z_valid:? v_xy_valid:? v_z_valid:? p:3f delta_xy:2f xy_reset_counter:B delta_z:f "
    "z_reset_counter:B v:3f z_deriv:f delta_vxy:2f vxy_reset_counter:B delta_vz:f vz_reset_counter:B a:3f heading:f "
    "heading_var:f unaided_heading:f delta_heading:f heading_reset_counter:B heading_good_for_control:? tilt_var:f "
    "xy_global:? z_global:? ref_timestamp:Q ref_lat:d ref_lon:d ref_alt:f {} dist_bottom_sensor_bitfield:B eph:f epv:f "
    "evh:f evv:f dead_reckoning:? vxy_max:f vz_max:f hagl_min:f {}"
)
_GLOBAL = (
    f"{_STAMPS} lat:d lon:d alt:f alt_ellipsoid:f {{}} eph:f epv:f terrain_alt:f terrain_alt_valid:? dead_reckoning:?"
)
STATUS = {
    Release.V1_15: Layout(_STATUS.format("", "avoidance_system_required:? avoidance_system_valid:? ")),
    Release.V1_16: Layout(_STATUS.format("", "")),
    Release.MAIN: Layout(_STATUS.format("nav_state_display:B ", "traffic_avoidance_system_present:? ")),
}
"""vehicle_status by release."""
_BOTTOM = "dist_bottom_valid:? dist_bottom:f dist_bottom_var:f delta_dist_bottom:f dist_bottom_reset_counter:B"
LOCAL_1_15 = Layout(_LOCAL.format("dist_bottom:f dist_bottom_valid:?", "hagl_max:f"))
LOCAL = Layout(_LOCAL.format(_BOTTOM, "hagl_max_z:f hagl_max_xy:f"))
"""vehicle_local_position, from 1.16 on."""
_COUNTERS = "lat_lon_reset_counter:B alt_reset_counter:B"
GLOBAL_1_15 = Layout(_GLOBAL.format(f"delta_alt:f {_COUNTERS}"))
GLOBAL = Layout(
    _GLOBAL.format(f"lat_lon_valid:? alt_valid:? delta_alt:f delta_terrain:f {_COUNTERS} terrain_reset_counter:B")
)
"""vehicle_global_position, from 1.16 on."""
SENSOR_COMBINED = Layout(
    "timestamp:Q gyro_rad:3f gyro_integral_dt:I accelerometer_timestamp_relative:I accelerometer_m_s2:3f "
    "accelerometer_integral_dt:I accelerometer_clipping:B gyro_clipping:B accel_calibration_count:B "
    "gyro_calibration_count:B"
)
ATTITUDE = Layout(f"{_STAMPS} q:4f delta_q_reset:4f quat_reset_counter:B")
ODOMETRY = Layout(
    f"{_STAMPS} pose_frame:B position:3f q:4f velocity_frame:B velocity:3f angular_velocity:3f position_variance:3f "
    "orientation_variance:3f velocity_variance:3f reset_counter:B quality:B"
)
LAND_DETECTED = Layout(
    "timestamp:Q freefall:? ground_contact:? maybe_landed:? landed:? in_ground_effect:? in_descend:? "
    "has_low_throttle:? vertical_movement:? horizontal_movement:? rotational_movement:? "
    "close_to_ground_or_skipped_check:? at_rest:?"
)
TIMESYNC = LAYOUTS["timesync_status", 0]  # version 0


def sensor_combined(a: Autopilot, stamp: int) -> bytes:
    """The gyro and the accelerometer, as they feel."""
    now = a.estimate
    north, east, down = now.a_n
    felt = to_body(rotation_matrix(now.q_nb), (north, east, down - a.vehicle.gravity))
    force = tuple(each + wrong for each, wrong in zip(felt, now.f_b_error, strict=True))
    return SENSOR_COMBINED.encode(
        timestamp=stamp, gyro_rad=now.w_b, gyro_integral_dt=GYRO_US, accelerometer_m_s2=force,
        accelerometer_integral_dt=GYRO_US,
    )  # fmt: skip


def attitude(a: Autopilot, stamp: int) -> bytes:
    """vehicle_attitude."""
    now = a.estimate
    return ATTITUDE.encode(timestamp=stamp, timestamp_sample=stamp, q=now.q_nb, quat_reset_counter=now.resets)


def odometry(a: Autopilot, stamp: int) -> bytes:
    """vehicle_odometry: everything in NED but the body rates."""
    now = a.estimate
    spread = (ACCURACY**2,) * 3
    return ODOMETRY.encode(
        timestamp=stamp, timestamp_sample=stamp, pose_frame=FRAME_NED, position=now.p_n, q=now.q_nb,
        velocity_frame=FRAME_NED, velocity=now.v_n, angular_velocity=now.w_b, position_variance=spread,
        orientation_variance=spread, velocity_variance=spread, reset_counter=now.resets,
    )  # fmt: skip


def local_position(a: Autopilot, stamp: int, layout: Layout) -> bytes:
    """vehicle_local_position."""
    now = a.estimate
    return layout.encode(
        timestamp=stamp, timestamp_sample=stamp, xy_valid=True, z_valid=True, v_xy_valid=True, v_z_valid=True,
        p=now.p_n, v=now.v_n, z_deriv=now.v_n[2], a=now.a_n, heading=heading_of(now.q_nb),
        heading_good_for_control=True, xy_global=True, z_global=True, ref_lat=a.home.latitude, ref_lon=a.home.longitude,
        ref_alt=a.home.altitude, eph=ACCURACY, epv=ACCURACY, evh=ACCURACY, evv=ACCURACY,
    )  # fmt: skip


def global_position(a: Autopilot, stamp: int, layout: Layout) -> bytes:
    """vehicle_global_position."""
    latitude, longitude = a.projection.reproject(*a.estimate.p_n[:2])
    return layout.encode(
        timestamp=stamp, timestamp_sample=stamp, lat=latitude, lon=longitude, alt=altitude_of(a), eph=ACCURACY,
        epv=ACCURACY,
    )  # fmt: skip


def status(a: Autopilot, stamp: int, layout: Layout) -> bytes:
    """vehicle_status."""
    commander = a.commander
    return layout.encode(
        timestamp=stamp, arming_state=ARMED if commander.armed else DISARMED,
        armed_time=round(commander.armed_at * 1e6) if commander.armed else 0,
        nav_state_user_intention=nav_state(commander.user_intended_mode), nav_state=nav_state(commander.mode),
        vehicle_type=ROTARY_WING, failsafe=commander.failsafe is not None,
        gcs_connection_lost=commander.failsafe_flags.gcs_connection_lost, system_type=MAV_TYPE_QUADROTOR, system_id=1,
        component_id=1, pre_flight_checks_pass=commander.can_arm(a.t),
    )  # fmt: skip


def nav_state(mode: Mode) -> int:
    """VehicleStatus's number of a mode."""
    return nav_state_of(mode) if mode in EXTERNAL else NAV_STATE.get(mode, NAV_STATE[Mode.HOLD])


def land_detected(a: Autopilot, stamp: int) -> bytes:
    """vehicle_land_detected: all three stages at once."""
    landed = a.commander.landed
    return LAND_DETECTED.encode(timestamp=stamp, ground_contact=landed, maybe_landed=landed, landed=landed)


CONTROL_MODE = LAYOUTS["vehicle_control_mode", 0]  # version 0
LOWEST = {
    Mode.MANUAL: Level.ATTITUDE, Mode.STABILIZED: Level.ATTITUDE, Mode.ACRO: Level.RATES,
    Mode.TERMINATION: Level.MOTORS, Mode.ALTITUDE: Level.VELOCITY, Mode.ALTITUDE_CRUISE: Level.VELOCITY,
    Mode.DESCEND: Level.VELOCITY,
}  # fmt: skip
"""What tells the loops in a mode that does not begin with a position: the level from which they run."""


def control_mode(a: Autopilot, stamp: int) -> bytes:
    """vehicle_control_mode: which of the vehicle's loops run, and who tells them."""
    mode = a.commander.mode
    by_topics = mode is Mode.OFFBOARD or mode in EXTERNAL
    level = a.level_in(mode) if by_topics else LOWEST.get(mode, Level.POSITION)
    return CONTROL_MODE.encode(
        timestamp=stamp, flag_armed=a.commander.armed,
        flag_multicopter_position_control_enabled=level <= Level.ACCELERATION,
        flag_control_manual_enabled=mode in MANUAL,
        flag_control_auto_enabled=not by_topics and mode not in MANUAL and mode not in (Mode.ORBIT, Mode.TERMINATION),
        flag_control_offboard_enabled=mode is Mode.OFFBOARD, flag_control_position_enabled=level <= Level.POSITION,
        flag_control_velocity_enabled=level <= Level.VELOCITY, flag_control_altitude_enabled=level <= Level.VELOCITY,
        flag_control_climb_rate_enabled=level <= Level.VELOCITY,
        flag_control_acceleration_enabled=by_topics and level <= Level.ACCELERATION,
        flag_control_attitude_enabled=level <= Level.ATTITUDE, flag_control_rates_enabled=level <= Level.RATES,
        flag_control_allocation_enabled=level <= Level.TORQUES and mode is not Mode.TERMINATION,
        flag_control_termination_enabled=mode is Mode.TERMINATION, source_id=nav_state(mode) if mode in EXTERNAL else 0,
    )  # fmt: skip


def timesync(stamp: int, observed_us: int, estimated_us: int, round_trip_us: int) -> bytes:
    """timesync_status: what an answer of the agent's says of its clock."""
    return TIMESYNC.encode(
        timestamp=stamp, source_protocol=SOURCE_DDS, observed_offset=observed_us,
        estimated_offset=estimated_us, round_trip_time=round_trip_us,
    )  # fmt: skip
