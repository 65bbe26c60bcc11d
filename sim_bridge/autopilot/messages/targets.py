"""What the vehicle wants: attitude and position targets, motor outputs."""

from __future__ import annotations

import math

from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode
from companion.mavlink_common import MAV_FRAME_GLOBAL_INT, MAV_FRAME_LOCAL_NED
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.flight_modes.setpoints import BELOW_ATTITUDE, AttitudeSetpoint
from sim_bridge.autopilot.messages.parts import (
    NAN,
    Values,
    degrees_e7,
    heading_of,
    int32,
    level,
    uint16,
)
from sim_bridge.control.position import Target
from sim_bridge.rotors import Four

MOTOR_OFF = 900
"""What SERVO_OUTPUT_RAW tells of a motor that is disarmed or not there, us of a servo pulse."""
IDLE_THRUST = 0.001
"""normalised: less and the motor stands."""
FULL_SPEED_RPM = 10_000.0
"""1/min at full command: a figure for the display."""
BY_STICK = (2, 3)
"""Main modes that a pilot flies through the position loop."""
ONLINE = 15
"""ESC_INFO's bits of four motors that answer."""
_FALLING = (NAN, NAN, NAN, NAN, NAN, NAN, 0.0, 0.0, 100.0)
"""Position, velocity and acceleration on the ground: PX4 presses the vehicle down with a target that falls."""


def attitude_target(a: Autopilot) -> Values:
    """ATTITUDE_TARGET. While body rates are flown only those are live; the rest stays as it last was, as in PX4."""
    now = a.estimate
    setpoint = a.setpoint
    if not a.commander.armed or a.commander.landed:
        a.attitude_told = (now.time_us // 1000, level(heading_of(now.q_nb)), IDLE_THRUST)
    elif isinstance(setpoint, AttitudeSetpoint):
        a.attitude_told = (now.time_us // 1000, setpoint.q_nb, setpoint.thrust)
    elif not isinstance(setpoint, BELOW_ATTITUDE):
        a.attitude_told = (now.time_us // 1000, a.cascade.attitude_wanted, a.cascade.thrust)
    time_ms, q, thrust = a.attitude_told
    rates = (NAN if rate is None else rate for rate in a.cascade.rates_wanted)
    return (time_ms, *q, *rates, thrust, 0)


def position_target_local_ned(a: Autopilot) -> Values | None:
    """POSITION_TARGET_LOCAL_NED, while the position loop runs."""
    if not _position_is_controlled(a):
        return None
    time_ms = a.estimate.time_us // 1000
    target = _target(a)
    if a.commander.landed or not a.commander.armed or target is None:
        return (time_ms, *_FALLING, heading_of(a.estimate.q_nb), 0.0, 63, MAV_FRAME_LOCAL_NED)
    values = _numbers(target)
    mask = sum(1 << i for i, value in enumerate(values[:9]) if math.isnan(value))
    return (time_ms, *values, mask, MAV_FRAME_LOCAL_NED)


def position_target_global_int(a: Autopilot) -> Values | None:
    """POSITION_TARGET_GLOBAL_INT: where an automatic mode is going."""
    place, target = a.guidance.destination, a.guidance.target
    if not a.commander.armed or a.commander.mode.main != 4 or place is None or target is None:
        return None
    latitude, longitude = degrees_e7(*a.projection.reproject(place[0], place[1]))
    _, _, _, *rest = _numbers(target)
    altitude = a.home.altitude - place[2]
    return (a.estimate.time_us // 1000, latitude, longitude, altitude, *rest, 0, MAV_FRAME_GLOBAL_INT)


def _target(a: Autopilot) -> Target | None:
    """What was last asked of the position loop."""
    if a.commander.mode is Mode.OFFBOARD:
        return a.offboard_flight.position.target
    return a.manual_flight.target if a.commander.mode.main in BY_STICK else a.guidance.target


def _position_is_controlled(a: Autopilot) -> bool:
    mode = a.commander.mode
    if mode is Mode.OFFBOARD:
        return a.setpoint is not None and not isinstance(a.setpoint, (AttitudeSetpoint, *BELOW_ATTITUDE))
    return mode.main in (2, 3, 4)


def _numbers(target: Target) -> tuple[float, ...]:
    """Position, velocity, acceleration, yaw and its rate; NaN where nothing is asked."""
    vectors = (target.position, target.velocity, target.acceleration)
    return (
        *(NAN if value is None else value for vector in vectors for value in vector),
        NAN if target.heading is None else target.heading,
        target.heading_rate,
    )


def _pulses(a: Autopilot) -> Four:
    """us: 1000 at command 0, 1000 more at command 1."""
    m0, m1, m2, m3 = a.commands
    return (1000.0 + 1000.0 * m0, 1000.0 + 1000.0 * m1, 1000.0 + 1000.0 * m2, 1000.0 + 1000.0 * m3)


def servo_output_raw(a: Autopilot) -> Values:
    """SERVO_OUTPUT_RAW."""
    if not a.commander.armed:
        return (a.estimate.time_us, *(MOTOR_OFF,) * 8, 0, *(MOTOR_OFF,) * 8)
    motors = (uint16(pulse) for pulse in _pulses(a))
    return (a.estimate.time_us, *motors, *(MOTOR_OFF,) * 4, 0, *(MOTOR_OFF,) * 8)


def orbit_execution_status(a: Autopilot) -> Values | None:
    """ORBIT_EXECUTION_STATUS, in an orbit: its circle, with a negative radius where it goes counter-clockwise."""
    orbit = a.guidance.orbit
    if orbit is None or not a.commander.armed or a.commander.mode is not Mode.ORBIT:
        return None
    north, east, down = orbit.centre
    centre = degrees_e7(*a.projection.reproject(north, east))
    radius = math.copysign(orbit.radius, orbit.speed)
    return message("ORBIT_EXECUTION_STATUS").values(
        time_usec=a.estimate.time_us, radius=radius, x=centre[0], y=centre[1], z=a.home.altitude - down
    )  # frame: 0, MAV_FRAME_GLOBAL


def actuator_output_status(a: Autopilot) -> Values:
    """ACTUATOR_OUTPUT_STATUS."""
    motors = _pulses(a) if a.commander.armed else (float(MOTOR_OFF),) * 4
    return (a.estimate.time_us, 16, *motors, *(float(MOTOR_OFF),) * 12, *(0.0,) * 16)


def hil_actuator_controls(a: Autopilot) -> Values:
    """HIL_ACTUATOR_CONTROLS: the motor commands as they are."""
    armed = a.commander.armed
    motors = a.commands if armed else (0.0,) * 4
    return (a.estimate.time_us, 0, *motors, *(0.0,) * 12, 129 if armed else 1)


def esc_status(a: Autopilot) -> Values:
    """ESC_STATUS: the speed goes with the root of the thrust."""
    full = (rotor.thrust_max for rotor in a.vehicle.rotors)
    rpm = (
        int32(math.copysign(FULL_SPEED_RPM * math.sqrt(abs(thrust) / most), thrust))
        for thrust, most in zip(a.truth.rotor_thrusts, full, strict=True)
    )
    return (a.estimate.time_us, *rpm, *(0.0,) * 8, 0)


def esc_info(a: Autopilot) -> Values:
    """ESC_INFO: four motors on line at 50 degrees."""
    return message("ESC_INFO").values(
        time_usec=a.estimate.time_us, count=4, info=ONLINE, temperature=(5000,) * 4
    )  # fmt: skip
