"""How well the vehicle is: sensors, estimator, battery, link clocks."""

from __future__ import annotations

import math

from companion.mavlink.dialect import message
from companion.mavlink.modes import Landed
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.messages.parts import NAN, Values

SENSORS_PRESENT = 0x0300C02F
"""Bits of MAV_SYS_STATUS_SENSOR, as PX4's simulation says them: what is there."""
SENSORS_ENABLED = 0x0301C02F
"""Bits of the same: what is in use."""
SENSORS_HEALTHY = 0x0320C83F
"""Bits of the same: what is well."""
WITHOUT_POSITION = ~0x4020
"""Without position control and GPS: before the estimator has settled."""
PREARM_CHECK = 0x10000000
"""MAV_SYS_STATUS_PREARM_CHECK."""
VOLTAGE_FULL = 16200  # mV, four cells of BAT1_V_CHARGED
VOLTAGE_EMPTY = 14400  # mV, four cells of BAT1_V_EMPTY
ESTIMATOR_STARTING = 164
"""ESTIMATOR_STATUS_FLAGS before the position is known (recorded)."""
ESTIMATOR_GOOD = 1023
"""ESTIMATOR_STATUS_FLAGS once it is (recorded)."""
STANDING_STILL = 128  # ESTIMATOR_CONST_POS_MODE: only on the ground
RETURN_MARGIN = 100.0  # s, RTL_TIME_MARGIN
RETURN_FACTOR = 1.1  # RTL_TIME_FACTOR
GNSS_ID = 4
"""The receiver's id (recorded)."""
NOT_TOLD_8 = 255
"""uint8: nobody knows."""
NOT_TOLD_16 = 65535
"""uint16: nobody knows."""


def sys_status(a: Autopilot) -> Values:
    """SYS_STATUS."""
    settled = -1 if a.commander.is_ready(a.t) else WITHOUT_POSITION
    return message("SYS_STATUS").values(
        onboard_control_sensors_present=SENSORS_PRESENT & settled,
        onboard_control_sensors_enabled=SENSORS_ENABLED & settled,
        onboard_control_sensors_health=SENSORS_HEALTHY & settled | (PREARM_CHECK if a.commander.can_arm(a.t) else 0),
        load=120,
        voltage_battery=_millivolts(a),
        current_battery=_centiamperes(a),
        battery_remaining=math.ceil(_share_left(a)),
    )


def battery_status(a: Autopilot) -> Values:
    """BATTERY_STATUS. As in PX4 the percentage is rounded here, and rounded up in SYS_STATUS."""
    left = a.battery.time_left
    return message("BATTERY_STATUS").values(
        current_consumed=round(a.battery.consumed),
        energy_consumed=-1,
        temperature=32767,
        voltages=(_millivolts(a), *(NOT_TOLD_16,) * 9),
        current_battery=_centiamperes(a),
        battery_function=1,
        type=1,
        battery_remaining=round(_share_left(a)),
        time_remaining=0 if left is None else max(1, int(min(left, 1e6))),
        charge_state=a.battery.state,
    )


def _share_left(a: Autopilot) -> float:
    """%."""
    return max(0.0, min(100.0, 100.0 * a.battery.remaining))


def _centiamperes(a: Autopilot) -> int:
    return -1 if a.battery.current is None else round(100.0 * a.battery.current)


def _millivolts(a: Autopilot) -> int:
    if a.battery.voltage is not None:
        return max(0, min(65534, round(1e3 * a.battery.voltage)))
    return round(VOLTAGE_EMPTY + (VOLTAGE_FULL - VOLTAGE_EMPTY) * max(0.0, min(1.0, a.battery.remaining)))


def estimator_status(a: Autopilot) -> Values:
    """ESTIMATOR_STATUS: small innovations, once there are any."""
    time_us = a.estimate.time_us
    if not a.home_position.position_known:
        return (time_us, NAN, NAN, 0.0022, NAN, NAN, NAN, 14.145, 0.8, ESTIMATOR_STARTING)
    flags = ESTIMATOR_GOOD & ~(0 if a.commander.landed else STANDING_STILL)
    return (time_us, 0.0135, 0.006, 0.0024, 0.08, 0.003, NAN, 0.289, 0.036, flags)


def estimator_sensor_fusion_status(a: Autopilot) -> Values:
    """ESTIMATOR_SENSOR_FUSION_STATUS: GPS, barometer, range finder, magnetometer and IMU in use."""
    return (*(NAN,) * 9, 1, 1, 0, 0, 1, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0)


def gnss_integrity(a: Autopilot) -> Values:
    """GNSS_INTEGRITY: a receiver that tells nothing of it."""
    return message("GNSS_INTEGRITY").values(
        id=GNSS_ID, raim_hfom=NOT_TOLD_16, raim_vfom=NOT_TOLD_16, corrections_quality=NOT_TOLD_8,
        system_status_summary=NOT_TOLD_8, gnss_signal_quality=NOT_TOLD_8, post_processing_quality=NOT_TOLD_8,
    )  # fmt: skip


def vibration(a: Autopilot) -> Values:
    """VIBRATION: that of PX4's simulation at rest."""
    return (a.estimate.time_us, 1.2e-10, 0.0112, 0.1135, 0, 0, 0)


def time_estimate_to_target(a: Autopilot) -> Values:
    """TIME_ESTIMATE_TO_TARGET: how long a return would take, s; the rest PX4 does not tell."""
    return (0 if a.commander.landed else _return_time(a), -1, -1, -1, -1)


def _return_time(a: Autopilot) -> int:
    now, home, parameters = a.estimate, a.guidance.home_n, a.parameters
    height = home[2] - now.p_n[2]
    top = a.guidance.return_height(now)
    level = math.hypot(now.p_n[0] - home[0], now.p_n[1] - home[1])
    up = max(0.0, top - height) / max(0.1, parameters["MPC_Z_V_AUTO_UP"])
    across = level / max(0.1, parameters["MPC_XY_CRUISE"])
    down = top / max(0.1, parameters["MPC_Z_V_AUTO_DN"])
    return round(RETURN_FACTOR * (up + across + down) + RETURN_MARGIN)


def extended_sys_state(a: Autopilot) -> Values:
    """EXTENDED_SYS_STATE."""
    return (0, a.landed_state.value)


def autopilot_state_for_gimbal_device(a: Autopilot) -> Values:
    """AUTOPILOT_STATE_FOR_GIMBAL_DEVICE."""
    now = a.estimate
    vx, vy, vz = now.v_n
    return message("AUTOPILOT_STATE_FOR_GIMBAL_DEVICE").values(
        time_boot_us=now.time_us, q=now.q_nb, vx=vx, vy=vy, vz=vz, estimator_status=ESTIMATOR_GOOD,
        landed_state=a.landed_state.value, angular_velocity_z=now.w_b[2],
    )  # fmt: skip


def system_time(a: Autopilot) -> Values:
    """SYSTEM_TIME: the wall's clock, which starts at a fixed time unless somebody sets it, and the vehicle's."""
    return (a.unix_us_at_boot + a.estimate.time_us, a.estimate.time_us // 1000)


def timesync(a: Autopilot) -> Values:
    """TIMESYNC: a request."""
    return (0, a.estimate.time_us * 1000)


def ping(a: Autopilot) -> Values:
    """PING: a request to everybody."""
    return (a.estimate.time_us, a.estimate.time_us // 1_000_000, 0, 0)


def mag_cal_report(a: Autopilot) -> Values:
    """MAG_CAL_REPORT: a calibration that succeeded some time ago."""
    return message("MAG_CAL_REPORT").values(
        cal_status=4, diag_x=1.0, diag_y=1.0, diag_z=1.0, orientation_confidence=1.0, scale_factor=1.0
    )


def is_flying(a: Autopilot) -> bool:
    """Whether the vehicle counts as airborne."""
    return a.landed_state is not Landed.ON_GROUND
