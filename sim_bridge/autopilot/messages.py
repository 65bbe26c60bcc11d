"""What the vehicle says: one small function a message, from the autopilot to the values in wire order.

The hot ones are written out in wire order; ``Format.values`` by name serves where once a second is enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.frames import rotation_matrix, to_body
from companion.mavlink.dialect import BY_NAME, Format, Value, message
from companion.mavlink.modes import Mode
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.setpoints import AttitudeDemand

Values = tuple[Value, ...]
Build = Callable[[Autopilot], Values]

QUADROTOR, PX4 = 2, 12  # MAV_TYPE, MAV_AUTOPILOT
ARMED, MANUAL_INPUT, STABILIZED, GUIDED, AUTO, CUSTOM = 0x80, 0x40, 0x10, 0x08, 0x04, 0x01
CAPABILITIES = 0xE8FF
SET_ACTUATOR_TARGET = 0x0400
"""MAV_PROTOCOL_CAPABILITY_SET_ACTUATOR_TARGET: this autopilot takes motor commands."""
VERSION = 1 << 24 | 19 << 16  # 1.19.0, development
SENSORS_PRESENT, SENSORS_ENABLED, SENSORS_HEALTHY = 0x0300C02F, 0x0301C02F, 0x0320C83F
"""MAV_SYS_STATUS_SENSOR bits, as PX4's simulation tells them."""
WITHOUT_POSITION = ~0x4020
"""Without position control and GPS: before the estimator has settled."""
PREARM_CHECK = 0x10000000
FIELD_N = (0.21, 0.01, 0.43)
"""gauss, the earth's magnetic field at the default home."""
STANDARD_MODES = {
    Mode.POSITION: 1, Mode.ORBIT: 2, Mode.ALTITUDE: 4, Mode.RETURN: 5, Mode.MISSION: 6, Mode.LAND: 7, Mode.TAKEOFF: 8,
}  # fmt: skip
MOTOR_OFF = 900.0
"""What ACTUATOR_OUTPUT_STATUS tells of a motor that is disarmed or not there, us of a servo pulse."""
NO_OFFSET = (0.0, 0.0, 0.0, 0.0)
POSE_COVARIANCE = (0.04, *(0.0,) * 5, 0.04, *(0.0,) * 4, 0.013, *(0.0,) * 3, 4e-4, 0.0, 0.0, 4e-4, 0.0, 0.035)
VELOCITY_COVARIANCE = (0.012, *(0.0,) * 5, 0.012, *(0.0,) * 4, 0.0036, *(0.0,) * 9)
LOCAL_NED = 1
AUTOPILOT_ESTIMATOR = 8  # MAV_ESTIMATOR_TYPE_AUTOPILOT


def heartbeat(a: Autopilot) -> Values:
    """HEARTBEAT."""
    return (a.commander.mode.custom_mode, QUADROTOR, PX4, _base_mode(a), _system_status(a), 3)


def _base_mode(a: Autopilot) -> int:
    mode = a.commander.mode
    bits = CUSTOM | (ARMED if a.commander.armed else 0)
    if mode is Mode.OFFBOARD:
        return bits | (STABILIZED if isinstance(a.demand, AttitudeDemand) else 0)
    if mode is Mode.ACRO:
        return bits | MANUAL_INPUT
    return bits | STABILIZED | (GUIDED | AUTO if mode.main == 4 else MANUAL_INPUT)


def _system_status(a: Autopilot) -> int:
    """MAV_STATE: 0 not ready, 3 standing by, 4 active, 5 in a failsafe."""
    if a.commander.armed:
        return 4 if a.commander.failsafe is None else 5
    return 3 if a.commander.can_run(a.commander.mode, a.t) else 0


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
        LOCAL_NED, LOCAL_NED, now.resets, AUTOPILOT_ESTIMATOR, 0,
    )  # fmt: skip


def highres_imu(a: Autopilot) -> Values:
    """HIGHRES_IMU: the specific force, gravity taken away, as an accelerometer feels it."""
    now = a.estimate
    r_nb = rotation_matrix(now.q_nb)
    north, east, down = now.a_n
    force = to_body(r_nb, (north, east, down - a.vehicle.gravity))
    altitude = a.home.altitude - now.p_n[2]
    return (now.time_us, *force, *now.w_b, *to_body(r_nb, FIELD_N), _pressure(altitude), 0.0, altitude, 15.0, 63, 0)


def _pressure(altitude: float) -> float:
    """hPa of the standard atmosphere at an altitude (m above the sea)."""
    base = 1.0 - 2.25577e-5 * altitude
    return 1013.25 * float(base**5.25588) if base > 0.0 else 0.0


def global_position_int(a: Autopilot) -> Values:
    """GLOBAL_POSITION_INT."""
    now = a.estimate
    north, east, down = now.p_n
    latitude, longitude = a.projection.reproject(north, east)
    vn, ve, vd = now.v_n
    w, x, y, z = now.q_nb
    heading = math.degrees(math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)))
    return (
        now.time_us // 1000,
        round(latitude * 1e7), round(longitude * 1e7), _int32((a.home.altitude - down) * 1e3), _int32(-down * 1e3),
        _int16(vn * 100.0), _int16(ve * 100.0), _int16(vd * 100.0), round(heading * 100.0) % 36000,
    )  # fmt: skip


def hil_state_quaternion(a: Autopilot) -> Values:
    """HIL_STATE_QUATERNION: the truth, as PX4's simulation sends it."""
    truth = a.truth
    north, east, down = truth.p_n
    latitude, longitude = a.projection.reproject(north, east)
    force = to_body(rotation_matrix(truth.q_nb), (truth.a_n[0], truth.a_n[1], truth.a_n[2] - a.vehicle.gravity))
    return (
        round(truth.t_boot * 1e6), *truth.q_nb, *truth.w_b,
        round(latitude * 1e7), round(longitude * 1e7), _int32((a.home.altitude - down) * 1e3),
        *(_int16(v * 100.0) for v in truth.v_n), 0, 0, *(_int16(f / 9.80665 * 1e3) for f in force),
    )  # fmt: skip


def _int16(value: float) -> int:
    return round(value) if -32768.0 < value < 32767.0 else 32767 if value > 0.0 else -32768


def _int32(value: float) -> int:
    return round(value) if -2147483648.0 < value < 2147483647.0 else 2147483647 if value > 0.0 else -2147483648


def actuator_output_status(a: Autopilot) -> Values:
    """ACTUATOR_OUTPUT_STATUS: 1000 us at command 0, 1000 more at command 1."""
    if not a.commander.armed:
        return (a.estimate.time_us, 16, *(MOTOR_OFF,) * 16, *(0.0,) * 16)
    motors = (1000.0 + 1000.0 * command for command in a.commands)
    return (a.estimate.time_us, 16, *motors, *(MOTOR_OFF,) * 12, *(0.0,) * 16)


def extended_sys_state(a: Autopilot) -> Values:
    """EXTENDED_SYS_STATE."""
    return (0, a.landed_state.value)


def current_mode(a: Autopilot) -> Values:
    """CURRENT_MODE: what is flown, and what the operator meant."""
    mode = a.commander.mode
    return (mode.custom_mode, a.commander.intent.custom_mode, STANDARD_MODES.get(mode, 0))


def sys_status(a: Autopilot) -> Values:
    """SYS_STATUS."""
    settled = -1 if a.commander.is_ready(a.t) else WITHOUT_POSITION
    return message("SYS_STATUS").values(
        onboard_control_sensors_present=SENSORS_PRESENT & settled,
        onboard_control_sensors_enabled=SENSORS_ENABLED & settled,
        onboard_control_sensors_health=SENSORS_HEALTHY & settled | (PREARM_CHECK if a.commander.can_arm(a.t) else 0),
        load=120,
        voltage_battery=16200,
        current_battery=-1,
        battery_remaining=100,
    )


def battery_status(a: Autopilot) -> Values:
    """BATTERY_STATUS: a battery that does not drain."""
    return message("BATTERY_STATUS").values(
        energy_consumed=-1,
        temperature=32767,
        voltages=(16200, *(65535,) * 9),
        current_battery=-1,
        battery_function=1,
        type=1,
        battery_remaining=100,
        charge_state=1,
    )


def home_position(a: Autopilot) -> Values:
    """HOME_POSITION."""
    return message("HOME_POSITION").values(
        **_home(a), x=a.guidance.home_n[0], y=a.guidance.home_n[1], z=a.guidance.home_n[2], q=(1.0, 0.0, 0.0, 0.0)
    )


def gps_global_origin(a: Autopilot) -> Values:
    """GPS_GLOBAL_ORIGIN."""
    return message("GPS_GLOBAL_ORIGIN").values(**_home(a))


def _home(a: Autopilot) -> dict[str, int]:
    home = a.home
    return {
        "latitude": round(home.latitude * 1e7),
        "longitude": round(home.longitude * 1e7),
        "altitude": _int32(home.altitude * 1e3),
        "time_usec": a.estimate.time_us,
    }


def autopilot_version(a: Autopilot) -> Values:
    """AUTOPILOT_VERSION; the capability to take motor commands is there exactly when they are taken."""
    return message("AUTOPILOT_VERSION").values(
        capabilities=CAPABILITIES | (SET_ACTUATOR_TARGET if a.direct else 0),
        uid=1,
        flight_sw_version=VERSION,
        middleware_sw_version=VERSION,
        board_version=1,
    )


def timesync(a: Autopilot) -> Values:
    """TIMESYNC: a request."""
    return (0, a.estimate.time_us * 1000)


def ping(a: Autopilot) -> Values:
    """PING: a request to everybody."""
    return (a.estimate.time_us, a.estimate.time_us // 1_000_000, 0, 0)


BUILDERS: dict[int, tuple[Format, Build]] = {
    BY_NAME[name].id: (BY_NAME[name], build)
    for name, build in (
        ("ACTUATOR_OUTPUT_STATUS", actuator_output_status),
        ("ATTITUDE", attitude),
        ("ATTITUDE_QUATERNION", attitude_quaternion),
        ("AUTOPILOT_VERSION", autopilot_version),
        ("BATTERY_STATUS", battery_status),
        ("CURRENT_MODE", current_mode),
        ("EXTENDED_SYS_STATE", extended_sys_state),
        ("GLOBAL_POSITION_INT", global_position_int),
        ("GPS_GLOBAL_ORIGIN", gps_global_origin),
        ("HEARTBEAT", heartbeat),
        ("HIGHRES_IMU", highres_imu),
        ("HIL_STATE_QUATERNION", hil_state_quaternion),
        ("HOME_POSITION", home_position),
        ("LOCAL_POSITION_NED", local_position_ned),
        ("ODOMETRY", odometry),
        ("PING", ping),
        ("SYS_STATUS", sys_status),
        ("TIMESYNC", timesync),
    )
}
"""Message id -> its format and the function that fills it."""
