"""Streams, requests, parameters, calibration; and what PX4 says for a device this vehicle does not have."""

from __future__ import annotations

import math

from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.commander.commander import Result, Severity
from sim_bridge.autopilot.commands.parts import Command, Handler, Wire, whole

MESSAGE_INTERVAL = 244
"""The message that GET_MESSAGE_INTERVAL, and a request for it, is answered with."""
UNANSWERED = frozenset({
    35, 93, 203, 204, 205, 206, 214, 220, 242, 243, 260, 311, 500, 521, 530, 531, 532, 1000, 1001, 2003, 2511, 3000,
    30001, 30002, 42600,
})  # fmt: skip
"""MAV_CMD that PX4 leaves to cameras, mounts, loggers and the like, of which none is here to answer."""
STORAGE_ACTIONS = range(5)
RESET_CONFIGURATION, RESET_ALL = 2, 4
LOAD, SAVE = 0, 1
GRIPPER_ACTIONS = (0, 1)
SAFETY_STATES = (0, 1)
MOTOR_FUNCTIONS = range(1, 13)  # ACTUATOR_OUTPUT_FUNCTION_MOTOR1..12
MOTOR_UNIT = 101  # FAILURE_UNIT_SYSTEM_MOTOR


def _set_message_interval(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    msgid, interval, *others, target = command.parameters
    if any(math.isfinite(value) and int(value + 0.5) != 0 for value in (others[0], others[1], target)):
        return Result.FAILED
    if math.isnan(interval):
        interval_us = 0  # no order either way: back to the default
    elif interval < 0.0 or math.isinf(interval):
        interval_us = -1
    else:
        interval_us = min(whole(interval) or int(interval > 0.0), 2**31 - 1)
    return Result.ACCEPTED if wire.set_interval(whole(msgid), interval_us) else Result.FAILED


def _get_message_interval(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    wire.tell_interval(whole(command.parameters[0]))
    return Result.ACCEPTED


def _request_message(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    msgid = whole(command.parameters[0]) & 0xFFFF
    if msgid == MESSAGE_INTERVAL:
        wire.tell_interval(whole(command.parameters[1]))
        return Result.ACCEPTED
    return Result.ACCEPTED if wire.request(msgid, command.parameters[1]) else Result.DENIED


def _storage(command: Command, autopilot: Autopilot, wire: Wire) -> Result | None:
    """Parameters: 0 load, 1 save, 2 and 4 reset."""
    if autopilot.commander.armed:
        return Result.TEMPORARILY_REJECTED
    action = whole(command.parameters[0])
    if action not in STORAGE_ACTIONS:
        return None
    if action in (RESET_CONFIGURATION, RESET_ALL):
        autopilot.parameters.reset()
    return Result.ACCEPTED


def _reboot(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """A simulation neither reboots nor switches itself off."""
    return Result.ACCEPTED if whole(command.parameters[0]) == 0 else Result.DENIED


def _calibrate(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """A calibration is over before it begins: what is simulated is calibrated."""
    if autopilot.commander.armed:
        return Result.TEMPORARILY_REJECTED
    wanted = [name for value, name in zip(command.parameters, _CALIBRATIONS, strict=True) if name and whole(value) > 0]
    if wanted:
        kind = "level" if wanted[0] == "accel" and whole(command.parameters[4]) == 2 else wanted[0]
        say = autopilot.commander.say
        say(Severity.INFO, f"[cal] calibration started: 2 {kind}")
        for percent in (0, 50, 100):
            say(Severity.INFO, f"[cal] progress <{percent}>")
        say(Severity.INFO, f"[cal] calibration done: {kind}")
    return Result.ACCEPTED


_CALIBRATIONS = ("gyro", "mag", "baro", "", "accel", "airspeed", "")


def _calibrate_heading(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    if autopilot.commander.armed:
        return Result.TEMPORARILY_REJECTED
    heading = command.parameters[0] if math.isfinite(command.parameters[0]) else 0.0
    autopilot.commander.say(Severity.INFO, f"Assuming vehicle is facing heading {heading:.1f} degrees")
    autopilot.commander.say(Severity.INFO, "Mag quick calibration finished")
    return Result.ACCEPTED


def _grip(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return Result.IN_PROGRESS if whole(command.parameters[1]) in GRIPPER_ACTIONS else Result.DENIED


def _autotune(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    """There is nothing to tune: asked rightly, it fails."""
    return Result.FAILED if command.parameters[:2] == (1.0, 0.0) else Result.DENIED


def _test_actuator(command: Command, autopilot: Autopilot, wire: Wire) -> Result | None:
    if autopilot.commander.armed:
        return Result.DENIED
    return Result.ACCEPTED if whole(command.parameters[4]) in MOTOR_FUNCTIONS else None


def _inject_failure(command: Command, autopilot: Autopilot, wire: Wire) -> Result | None:
    """The stand-in's failures are in its world file; here it only answers as PX4's simulation does."""
    if not autopilot.parameters["SYS_FAILURE_EN"]:
        return Result.DENIED
    return Result.ACCEPTED if whole(command.parameters[0]) == MOTOR_UNIT else None


def _set_safety(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    if autopilot.commander.armed:
        return Result.TEMPORARILY_REJECTED
    return Result.ACCEPTED if whole(command.parameters[0]) in SAFETY_STATES else Result.FAILED


def _high_latency(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    autopilot.commander.say(Severity.CRITICAL, "Control high latency failed! Telemetry unavailable\t")
    return Result.FAILED


def _accept(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return Result.ACCEPTED


def _deny(command: Command, autopilot: Autopilot, wire: Wire) -> Result:
    return Result.DENIED


HANDLERS: dict[int, Handler] = {
    187: _accept,  # DO_SET_ACTUATOR
    211: _grip,
    212: _autotune,
    241: _calibrate,
    245: _storage,
    246: _reboot,
    310: _test_actuator,
    401: _accept,  # RUN_PREARM_CHECKS
    420: _inject_failure,
    510: _get_message_interval,
    511: _set_message_interval,
    512: _request_message,
    620: _accept,  # EXTERNAL_ATTITUDE_ESTIMATE
    2510: _deny,  # LOGGING_START: there is no log to stream
    2600: _high_latency,
    5300: _set_safety,
    42006: _calibrate_heading,
    43003: _accept,  # EXTERNAL_POSITION_ESTIMATE
}
