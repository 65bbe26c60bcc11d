"""Streams, requests, parameters, calibration; and what PX4 says for a device this vehicle does not have."""

from __future__ import annotations

import math

from companion import mavlink_common as mav
from companion.mavlink_common import (
    MAV_CMD_ACTUATOR_TEST,
    MAV_CMD_CONTROL_HIGH_LATENCY,
    MAV_CMD_DO_AUTOTUNE_ENABLE,
    MAV_CMD_DO_GRIPPER,
    MAV_CMD_DO_SET_ACTUATOR,
    MAV_CMD_DO_SET_SAFETY_SWITCH_STATE,
    MAV_CMD_EXTERNAL_ATTITUDE_ESTIMATE,
    MAV_CMD_EXTERNAL_POSITION_ESTIMATE,
    MAV_CMD_FIXED_MAG_CAL_YAW,
    MAV_CMD_GET_MESSAGE_INTERVAL,
    MAV_CMD_INJECT_FAILURE,
    MAV_CMD_LOGGING_START,
    MAV_CMD_PREFLIGHT_CALIBRATION,
    MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN,
    MAV_CMD_PREFLIGHT_STORAGE,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_RUN_PREARM_CHECKS,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MavResult,
    MavSeverity,
)
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commands.parts import Command, Handler, Wire, accept, whole

MESSAGE_INTERVAL = 244
"""The message that GET_MESSAGE_INTERVAL, and a request for it, is answered with."""
UNANSWERED = frozenset({
    mav.MAV_CMD_DO_FIGURE_EIGHT, mav.MAV_CMD_NAV_DELAY, mav.MAV_CMD_DO_DIGICAM_CONTROL,
    mav.MAV_CMD_DO_MOUNT_CONFIGURE, mav.MAV_CMD_DO_MOUNT_CONTROL, mav.MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    mav.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL, mav.MAV_CMD_DO_MOUNT_CONTROL_QUAT,
    mav.MAV_CMD_PREFLIGHT_SET_SENSOR_OFFSETS, mav.MAV_CMD_PREFLIGHT_UAVCAN, mav.MAV_CMD_OBLIQUE_SURVEY,
    mav.MAV_CMD_CONFIGURE_ACTUATOR, mav.MAV_CMD_START_RX_PAIR, mav.MAV_CMD_REQUEST_CAMERA_INFORMATION,
    mav.MAV_CMD_SET_CAMERA_MODE, mav.MAV_CMD_SET_CAMERA_ZOOM, mav.MAV_CMD_SET_CAMERA_FOCUS,
    mav.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, mav.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, mav.MAV_CMD_DO_TRIGGER_CONTROL,
    mav.MAV_CMD_LOGGING_STOP, mav.MAV_CMD_DO_VTOL_TRANSITION, mav.MAV_CMD_PAYLOAD_PREPARE_DEPLOY,
    mav.MAV_CMD_PAYLOAD_CONTROL_DEPLOY, mav.MAV_CMD_DO_WINCH,
})  # fmt: skip
"""Commands that PX4 leaves to cameras, mounts, loggers and the like, of which none is here to answer."""
STORAGE_ACTIONS = range(5)
"""PREFLIGHT_STORAGE's first parameter."""
RESET_CONFIGURATION = 2
"""PREFLIGHT_STORAGE: back to the defaults, sensors apart."""
RESET_ALL = 4
"""PREFLIGHT_STORAGE: back to the defaults, all of them."""
LOAD = 0
"""PREFLIGHT_STORAGE: read from where they are kept."""
SAVE = 1
"""PREFLIGHT_STORAGE: write there."""
GRIPPER_ACTIONS = (0, 1)
"""Release and grab."""
SAFETY_STATES = (0, 1)
"""Safe and dangerous."""
MOTOR_FUNCTIONS = range(1, 13)  # ACTUATOR_OUTPUT_FUNCTION_MOTOR1..12
MOTOR_UNIT = 101  # FAILURE_UNIT_SYSTEM_MOTOR


def _set_message_interval(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    msgid, interval, *others, target = command.parameters
    if any(math.isfinite(value) and int(value + 0.5) != 0 for value in (others[0], others[1], target)):
        return MavResult.FAILED
    if math.isnan(interval):
        interval_us = 0  # no order either way: back to the default
    elif interval < 0.0 or math.isinf(interval):
        interval_us = -1
    else:
        interval_us = min(whole(interval) or int(interval > 0.0), 2**31 - 1)
    return MavResult.ACCEPTED if wire.set_interval(whole(msgid), interval_us) else MavResult.FAILED


def _get_message_interval(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    wire.tell_interval(whole(command.parameters[0]))
    return MavResult.ACCEPTED


def _request_message(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    msgid = whole(command.parameters[0]) & 0xFFFF
    if msgid == MESSAGE_INTERVAL:
        wire.tell_interval(whole(command.parameters[1]))
        return MavResult.ACCEPTED
    return MavResult.ACCEPTED if wire.request(msgid, command.parameters[1]) else MavResult.DENIED


def _storage(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult | None:
    """Parameters: 0 load, 1 save, 2 and 4 reset."""
    if autopilot.commander.armed:
        return MavResult.TEMPORARILY_REJECTED
    action = whole(command.parameters[0])
    if action not in STORAGE_ACTIONS:
        return None
    if action in (RESET_CONFIGURATION, RESET_ALL):
        autopilot.parameters.reset()
    return MavResult.ACCEPTED


def _reboot(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """A simulation neither reboots nor switches itself off."""
    return MavResult.ACCEPTED if whole(command.parameters[0]) == 0 else MavResult.DENIED


def _calibrate(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """A calibration is over before it begins: what is simulated is calibrated."""
    if autopilot.commander.armed:
        return MavResult.TEMPORARILY_REJECTED
    wanted = [name for value, name in zip(command.parameters, _CALIBRATIONS, strict=True) if name and whole(value) > 0]
    if wanted:
        kind = "level" if wanted[0] == "accel" and whole(command.parameters[4]) == 2 else wanted[0]
        say = autopilot.commander.say
        say(MavSeverity.INFO, f"[cal] calibration started: 2 {kind}")
        for percent in (0, 50, 100):
            say(MavSeverity.INFO, f"[cal] progress <{percent}>")
        say(MavSeverity.INFO, f"[cal] calibration done: {kind}")
    return MavResult.ACCEPTED


_CALIBRATIONS = ("gyro", "mag", "baro", "", "accel", "airspeed", "")


def _calibrate_heading(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    if autopilot.commander.armed:
        return MavResult.TEMPORARILY_REJECTED
    heading = command.parameters[0] if math.isfinite(command.parameters[0]) else 0.0
    autopilot.commander.say(MavSeverity.INFO, f"Assuming vehicle is facing heading {heading:.1f} degrees")
    autopilot.commander.say(MavSeverity.INFO, "Mag quick calibration finished")
    return MavResult.ACCEPTED


def _grip(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    return MavResult.IN_PROGRESS if whole(command.parameters[1]) in GRIPPER_ACTIONS else MavResult.DENIED


def _autotune(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """There is nothing to tune: asked rightly, it fails."""
    return MavResult.FAILED if command.parameters[:2] == (1.0, 0.0) else MavResult.DENIED


def _test_actuator(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult | None:
    if autopilot.commander.armed:
        return MavResult.DENIED
    return MavResult.ACCEPTED if whole(command.parameters[4]) in MOTOR_FUNCTIONS else None


def _inject_failure(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult | None:
    """The stand-in's failures are in its world file; here it only answers as PX4's simulation does."""
    if not autopilot.parameters["SYS_FAILURE_EN"]:
        return MavResult.DENIED
    return MavResult.ACCEPTED if whole(command.parameters[0]) == MOTOR_UNIT else None


def _set_safety(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    if autopilot.commander.armed:
        return MavResult.TEMPORARILY_REJECTED
    return MavResult.ACCEPTED if whole(command.parameters[0]) in SAFETY_STATES else MavResult.FAILED


def _high_latency(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    autopilot.commander.say(MavSeverity.CRITICAL, "Control high latency failed! Telemetry unavailable\t")
    return MavResult.FAILED


def _deny(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    return MavResult.DENIED


HANDLERS: dict[int, Handler] = {
    MAV_CMD_DO_SET_ACTUATOR: accept,
    MAV_CMD_DO_GRIPPER: _grip,
    MAV_CMD_DO_AUTOTUNE_ENABLE: _autotune,
    MAV_CMD_PREFLIGHT_CALIBRATION: _calibrate,
    MAV_CMD_PREFLIGHT_STORAGE: _storage,
    MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: _reboot,
    MAV_CMD_ACTUATOR_TEST: _test_actuator,
    MAV_CMD_RUN_PREARM_CHECKS: accept,
    MAV_CMD_INJECT_FAILURE: _inject_failure,
    MAV_CMD_GET_MESSAGE_INTERVAL: _get_message_interval,
    MAV_CMD_SET_MESSAGE_INTERVAL: _set_message_interval,
    MAV_CMD_REQUEST_MESSAGE: _request_message,
    MAV_CMD_EXTERNAL_ATTITUDE_ESTIMATE: accept,
    MAV_CMD_LOGGING_START: _deny,  # there is no log to stream
    MAV_CMD_CONTROL_HIGH_LATENCY: _high_latency,
    MAV_CMD_DO_SET_SAFETY_SWITCH_STATE: _set_safety,
    MAV_CMD_FIXED_MAG_CAL_YAW: _calibrate_heading,
    MAV_CMD_EXTERNAL_POSITION_ESTIMATE: accept,
}
