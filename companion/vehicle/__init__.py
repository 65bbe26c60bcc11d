"""The nouns every room shares: the vehicle as it is, the state it is in, what it is told to do.

SI units and radians; world frame NED (``_n``), body frame FRD (``_b``).

machine    what its vehicle file describes
state      its own estimate, its mode, what it says of itself
setpoints  motor commands, rates, attitude
"""

from __future__ import annotations

from companion.vehicle.machine import (
    GRAVITY,
    TILT_MARGIN,
    CompanionError,
    Limits,
    MotorInterface,
    Rotor,
    Spin,
    Vehicle,
)
from companion.vehicle.setpoints import (
    AttitudeSetpoint,
    MotorSetpoint,
    OutputLevel,
    RateSetpoint,
    Setpoint,
    TorqueSetpoint,
    is_finite,
)
from companion.vehicle.state import (
    Fact,
    FrameOrigin,
    Home,
    KnownStatus,
    Landed,
    Mode,
    Tuning,
    VehicleState,
    VehicleStatus,
)

__all__ = [
    "GRAVITY",
    "TILT_MARGIN",
    "AttitudeSetpoint",
    "CompanionError",
    "Fact",
    "FrameOrigin",
    "Home",
    "KnownStatus",
    "Landed",
    "Limits",
    "Mode",
    "MotorInterface",
    "MotorSetpoint",
    "OutputLevel",
    "RateSetpoint",
    "Rotor",
    "Setpoint",
    "Spin",
    "TorqueSetpoint",
    "Tuning",
    "Vehicle",
    "VehicleState",
    "VehicleStatus",
    "is_finite",
]
