"""What a vehicle is told to do."""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from companion.frames import Quaternion, Vec3


class OutputLevel(enum.Enum):
    """The kind of setpoint the law goes out as."""

    MOTORS = "motors"
    TORQUES = "torques"
    RATES = "rates"
    ATTITUDE = "attitude"

    __hash__ = object.__hash__  # members are the only ones of their kind; Enum's own goes by the name, in Python

    @property
    def without_rate_loop(self) -> bool:
        """Whether the vehicle's own rate loop is out of the way, so that the law itself keeps the vehicle upright."""
        return self in (OutputLevel.MOTORS, OutputLevel.TORQUES)


class MotorSetpoint(NamedTuple):
    """Commands to the rotors in motor order, each inside its rotor's command range."""

    commands: tuple[float, ...]


class TorqueSetpoint(NamedTuple):
    """Torques about the body axes (FRD) and collective thrust (0..1, up), as shares: PX4's normalised setpoints."""

    torque_b: Vec3
    thrust: float


class RateSetpoint(NamedTuple):
    """Body rates (rad/s, FRD) and collective thrust (0..1, up)."""

    rates_b: Vec3
    thrust: float


class AttitudeSetpoint(NamedTuple):
    """Attitude (body to world) and collective thrust (0..1, up)."""

    q_nb: Quaternion
    thrust: float


Setpoint = MotorSetpoint | TorqueSetpoint | RateSetpoint | AttitudeSetpoint


def is_finite(setpoint: Setpoint) -> bool:
    """Whether every number in it is one. PX4 takes a NaN for "stop this motor": over XRCE, and from 1.18 on a thrust
    over MAVLink too."""
    match setpoint:
        case MotorSetpoint(commands):
            return math.isfinite(sum(commands))
        case TorqueSetpoint(vector, thrust) | RateSetpoint(vector, thrust) | AttitudeSetpoint(vector, thrust):
            return math.isfinite(sum(vector) + thrust)
