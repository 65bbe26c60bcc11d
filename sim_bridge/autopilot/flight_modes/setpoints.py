"""Offboard setpoints as PX4 reads them: which fields count, which messages do nothing, what is never flown.

A number that is not finite is no demand where PX4 knows such a thing (a body rate), and spoils the message elsewhere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Quaternion, Vec3, clamped
from companion.mavlink.dialect import Value, message
from sim_bridge.autopilot.flight_modes.position_setpoints import TrajectorySetpoint
from sim_bridge.control.rates import RatesWanted
from sim_bridge.rotors import Four

ATTITUDE_TARGET = message("SET_ATTITUDE_TARGET")
ACTUATORS = message("SET_ACTUATOR_CONTROL_TARGET")


def _index(field: str) -> int:
    where = ATTITUDE_TARGET.where[field]
    assert isinstance(where, int)
    return where


_Q = ATTITUDE_TARGET.where["q"]
_RATES = slice(_index("body_roll_rate"), _index("body_yaw_rate") + 1)
"""Where the rates stand in the wire order."""
_THRUST = _index("thrust")
_MASK = _index("type_mask")
_THRUST_BODY = ATTITUDE_TARGET.where["thrust_body"]
_CONTROLS = ACTUATORS.where["controls"]
_GROUP = ACTUATORS.where["group_mlx"]

IGNORE_ROLL_RATE = 0x01
"""ATTITUDE_TARGET_TYPEMASK: no roll rate is asked for."""
IGNORE_PITCH_RATE = 0x02
"""ATTITUDE_TARGET_TYPEMASK: no pitch rate."""
IGNORE_YAW_RATE = 0x04
"""ATTITUDE_TARGET_TYPEMASK: no yaw rate."""
USE_THRUST_BODY = 0x20
"""ATTITUDE_TARGET_TYPEMASK: thrust_body counts."""
IGNORE_THROTTLE = 0x40
"""ATTITUDE_TARGET_TYPEMASK: thrust does not."""
IGNORE_ATTITUDE = 0x80
"""ATTITUDE_TARGET_TYPEMASK: the attitude does not."""

RATE_MOST = 100.0
"""rad/s. PX4 passes any demand on; this only keeps absurd ones from overflowing the arithmetic."""
THRUST_MOST = 10.0
"""normalised: a thrust beyond it is garbage."""


class MotorSetpoint(NamedTuple):
    """Motor commands in the rotors' own units."""

    commands: Four


class ActuatorMotors(NamedTuple):
    """PX4's actuator_motors, in the rotors' own units: held until others come. Nobody is told the thrust."""

    commands: Four


class TorqueSetpoint(NamedTuple):
    """PX4's vehicle_torque_setpoint, normalised: the vehicle's own mixer makes motor commands of it and the last
    vehicle_thrust_setpoint."""

    torque: Vec3


class RatesSetpoint(NamedTuple):
    """Body rates (rad/s) and normalised thrust (up)."""

    rates: RatesWanted
    thrust: float


class AttitudeSetpoint(NamedTuple):
    """Attitude (body to world), normalised thrust (up), and the rate the heading turns at (rad/s)."""

    q_nb: Quaternion
    thrust: float
    heading_rate: float


BELOW_ATTITUDE = (MotorSetpoint, ActuatorMotors, TorqueSetpoint, RatesSetpoint)
"""Setpoints with which nobody in the vehicle controls the attitude."""
Setpoint = MotorSetpoint | ActuatorMotors | TorqueSetpoint | RatesSetpoint | AttitudeSetpoint | TrajectorySetpoint


def attitude_target(values: tuple[Value, ...]) -> RatesSetpoint | AttitudeSetpoint | None:
    """What a SET_ATTITUDE_TARGET asks for. None: nothing PX4 would act on."""
    mask = int(values[_MASK])
    if mask & USE_THRUST_BODY:
        thrust = -values[_THRUST_BODY][2]
    elif mask & IGNORE_THROTTLE:
        return None
    else:
        thrust = values[_THRUST]
    if not math.isfinite(thrust):
        return None
    thrust = clamped(thrust, -THRUST_MOST, THRUST_MOST)
    # Ignoring either roll or pitch rate drops all rates.
    p, q, r = map(_rate, values[_RATES])
    if mask & IGNORE_YAW_RATE:
        r = None
    if not mask & IGNORE_ATTITUDE:
        w, x, y, z = values[_Q]
        norm = math.sqrt(w * w + x * x + y * y + z * z)
        if not 0.5 < norm < 2.0:
            return None
        return AttitudeSetpoint((w / norm, x / norm, y / norm, z / norm), thrust, r or 0.0)
    if mask & (IGNORE_ROLL_RATE | IGNORE_PITCH_RATE):
        return None
    return RatesSetpoint((p, q, r), thrust)


def actuator_controls(values: tuple[Value, ...]) -> MotorSetpoint | None:
    """What a SET_ACTUATOR_CONTROL_TARGET asks of direct motors: group 0, the first four controls. None: nothing."""
    a, b, c, d = values[_CONTROLS][:4]
    if values[_GROUP] != 0 or not all(map(math.isfinite, (a, b, c, d))):
        return None
    return MotorSetpoint((a, b, c, d))


def _rate(value: float) -> float | None:
    if -RATE_MOST <= value <= RATE_MOST:
        return value
    return math.copysign(RATE_MOST, value) if math.isfinite(value) else None
