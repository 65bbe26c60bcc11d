"""How the vehicle is and moves: attitude, position, velocity, altitude, home. Most of it is sent often."""

from __future__ import annotations

import math

from companion.frames import rotation_matrix, to_body
from companion.mavlink.dialect import message
from companion.mavlink_common import (
    MAV_FRAME_LOCAL_NED,
)
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.messages.parts import (
    NAN,
    Values,
    altitude_of,
    degrees_e7,
    heading_of,
    int16,
    int32,
    place,
    pressure_at,
)

NO_OFFSET = (0.0, 0.0, 0.0, 0.0)
"""The quaternion of a vehicle that is not tilted by its mounting: all zeros."""
POSE_COVARIANCE = (0.04, *(0.0,) * 5, 0.04, *(0.0,) * 4, 0.013, *(0.0,) * 3, 4e-4, 0.0, 0.0, 4e-4, 0.0, 0.035)
"""m^2 and rad^2, upper triangle (recorded)."""
VELOCITY_COVARIANCE = (0.012, *(0.0,) * 5, 0.012, *(0.0,) * 4, 0.0036, *(0.0,) * 9)
"""m^2/s^2, upper triangle (recorded)."""
AUTOPILOT_ESTIMATOR = 8  # MAV_ESTIMATOR_TYPE_AUTOPILOT
FIELD_N = (0.21, 0.01, 0.43)
"""gauss, the earth's magnetic field at the default home."""
GRAVITY_MG = 9.80665e-3
"""m/s^2 in one thousandth of g."""
DOWNWARDS = 25  # MAV_SENSOR_ROTATION_PITCH_270
RANGE_MAX_CM = 10_000
"""cm: what PX4's simulated range finder tells."""


def attitude(a: Autopilot) -> Values:
    """ATTITUDE."""
    now = a.estimate
    w, x, y, z = now.q_nb
    phi = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    theta = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    psi = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return (now.time_us // 1000, phi, theta, psi, *now.w_b)


def attitude_quaternion(a: Autopilot) -> Values:
    """ATTITUDE_QUATERNION."""
    now = a.estimate
    return (now.time_us // 1000, *now.q_nb, *now.w_b, *NO_OFFSET)


def local_position_ned(a: Autopilot) -> Values:
    """LOCAL_POSITION_NED."""
    now = a.estimate
    return (now.time_us // 1000, *now.p_n, *now.v_n)


def odometry(a: Autopilot) -> Values:
    """ODOMETRY: the velocity in NED, as PX4 sends it since 2022."""
    now = a.estimate
    return (
        now.time_us, *now.p_n, *now.q_nb, *now.v_n, *now.w_b, *POSE_COVARIANCE, *VELOCITY_COVARIANCE,
        MAV_FRAME_LOCAL_NED, MAV_FRAME_LOCAL_NED, now.resets, AUTOPILOT_ESTIMATOR, 0,
    )  # fmt: skip


def highres_imu(a: Autopilot) -> Values:
    """HIGHRES_IMU: the specific force, gravity taken away, as an accelerometer feels it."""
    now = a.estimate
    r_nb = rotation_matrix(now.q_nb)
    north, east, down = now.a_n
    felt, wrong = to_body(r_nb, (north, east, down - a.vehicle.gravity)), now.f_b_error
    force = (felt[0] + wrong[0], felt[1] + wrong[1], felt[2] + wrong[2])
    altitude = altitude_of(a)
    return (now.time_us, *force, *now.w_b, *to_body(r_nb, FIELD_N), pressure_at(altitude), 0.0, altitude, 15.0, 63, 0)


def scaled_imu(a: Autopilot) -> Values:
    """SCALED_IMU: the same in whole numbers, mg, mrad/s and mgauss."""
    values = highres_imu(a)
    force = (int16(value / GRAVITY_MG) for value in values[1:4])
    rest = (int16(value * 1e3) for value in values[4:10])
    return (a.estimate.time_us // 1000, *force, *rest, 1500)


def scaled_pressure(a: Autopilot) -> Values:
    """SCALED_PRESSURE."""
    altitude = altitude_of(a)
    return (a.estimate.time_us // 1000, pressure_at(altitude), 0.0, int16(1500.0 - 0.65 * altitude), 0)


def global_position_int(a: Autopilot) -> Values | None:
    """GLOBAL_POSITION_INT, once the estimator knows where it is."""
    if not a.home_position.position_known:
        return None
    now = a.estimate
    vn, ve, vd = now.v_n
    heading = math.degrees(heading_of(now.q_nb))
    return (
        now.time_us // 1000, *place(a), int32(altitude_of(a) * 1e3), int32((a.guidance.home_n[2] - now.p_n[2]) * 1e3),
        int16(vn * 100.0), int16(ve * 100.0), int16(vd * 100.0), round(heading * 100.0) % 36000,
    )  # fmt: skip


def gps_raw_int(a: Autopilot) -> Values:
    """GPS_RAW_INT: ten satellites and a good fix."""
    vn, ve, _ = a.estimate.v_n
    altitude = int32(altitude_of(a) * 1e3)
    course = round(math.degrees(math.atan2(ve, vn)) * 100.0) % 36000
    speed = min(65534, round(math.hypot(vn, ve) * 100.0))
    return (
        a.estimate.time_us, *place(a), altitude, 70, 110, speed, course, 3, 10, altitude, 900, 1780, 400, 0, 0,
    )  # fmt: skip


def altitude(a: Autopilot) -> Values:
    """ALTITUDE: above the sea, home and the ground, which is flat at the origin's height."""
    height = 0.0 - a.estimate.p_n[2]
    above_sea = altitude_of(a)
    if not a.home_position.position_known:
        return (a.estimate.time_us, above_sea, NAN, NAN, NAN, NAN, NAN)
    return (a.estimate.time_us, above_sea, above_sea, height, height + a.guidance.home_n[2], 0.0, height)


def vfr_hud(a: Autopilot) -> Values:
    """VFR_HUD: the airspeed is not known."""
    vn, ve, vd = a.estimate.v_n
    throttle = max(0, min(100, int(100.0 * a.cascade.thrust))) if a.commander.armed else 0
    heading = int(math.degrees(heading_of(a.estimate.q_nb)) % 360.0) % 360
    return (NAN, math.hypot(vn, ve), altitude_of(a), -vd, heading, throttle)


def distance_sensor(a: Autopilot) -> Values:
    """DISTANCE_SENSOR: looking down."""
    distance = max(0, min(65535, round(0.0 - a.estimate.p_n[2] * 100.0)))
    return (
        a.estimate.time_us // 1000, 0, RANGE_MAX_CM, distance, 0, 0, DOWNWARDS, 0, 0.0, 0.0, *NO_OFFSET,
        1 if distance == 0 else 0,
    )  # fmt: skip


def hil_state_quaternion(a: Autopilot) -> Values:
    """HIL_STATE_QUATERNION: the truth, as PX4's simulation sends it."""
    truth = a.truth
    north, east, down = truth.p_n
    force = to_body(rotation_matrix(truth.q_nb), (truth.a_n[0], truth.a_n[1], truth.a_n[2] - a.vehicle.gravity))
    return (
        round(truth.t_boot * 1e6), *truth.q_nb, *truth.w_b,
        *degrees_e7(*a.projection.reproject(north, east)), int32((a.home.altitude - down) * 1e3),
        *(int16(v * 100.0) for v in truth.v_n), 0, 0, *(int16(f / GRAVITY_MG) for f in force),
    )  # fmt: skip


def home_position(a: Autopilot) -> Values | None:
    """HOME_POSITION: where a return goes, once that is known."""
    if a.home_position.home_set_us is None:
        return None
    x, y, z = a.guidance.home_n
    latitude, longitude = degrees_e7(*a.projection.reproject(x, y))
    return message("HOME_POSITION").values(
        latitude=latitude, longitude=longitude, altitude=int32((a.home.altitude - z) * 1e3),
        x=x, y=y, z=z, q=a.home_position.home_q, time_usec=a.home_position.home_set_us,
    )  # fmt: skip


def gps_global_origin(a: Autopilot) -> Values | None:
    """GPS_GLOBAL_ORIGIN: the zero of the local frame, once the estimator has one."""
    if a.home_position.origin_set_us is None:
        return None
    latitude, longitude = degrees_e7(a.home.latitude, a.home.longitude)
    return (latitude, longitude, int32(a.home.altitude * 1e3), a.home_position.origin_set_us)
