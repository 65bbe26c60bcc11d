"""Setpoint -> the values of its MAVLink message, one small function per encoding.

Stamps are those of a state, which telemetry has bounded; a number too large for its type is clamped by the encoder.
What is not finite is kept back before, where it is sent: ``daemon.conductor``.
"""

from __future__ import annotations

from companion.mavlink.dialect import Format, Value, message
from companion.vehicle import AttitudeSetpoint, MotorSetpoint, RateSetpoint

SET_ACTUATOR_CONTROL_TARGET = message("SET_ACTUATOR_CONTROL_TARGET")
SET_ATTITUDE_TARGET = message("SET_ATTITUDE_TARGET")

Sendable = MotorSetpoint | RateSetpoint | AttitudeSetpoint
"""What has a message: torques go over XRCE alone."""
IGNORE_ATTITUDE = 0x80
"""SET_ATTITUDE_TARGET's type mask: rates are asked for."""
IGNORE_RATES = 0x07
"""SET_ATTITUDE_TARGET's type mask: an attitude is asked for."""
IDENTITY = (1.0, 0.0, 0.0, 0.0)
"""q_nb that nobody reads."""


def encoded(setpoint: Sendable, t_boot: float, system: int, component: int) -> tuple[Format, tuple[Value, ...]]:
    """The message for a vehicle. ``t_boot``: s, the stamp of the state the setpoint was computed from."""
    if isinstance(setpoint, RateSetpoint):
        return SET_ATTITUDE_TARGET, _rates(setpoint, t_boot, system, component)
    if isinstance(setpoint, AttitudeSetpoint):
        return SET_ATTITUDE_TARGET, _attitude(setpoint, t_boot, system, component)
    return SET_ACTUATOR_CONTROL_TARGET, _motors(setpoint, t_boot, system, component)


def _motors(setpoint: MotorSetpoint, t_boot: float, system: int, component: int) -> tuple[Value, ...]:
    """Group 0, controls 0.. = motor commands: only for a vehicle that declares direct motors."""
    unused = (0.0,) * (8 - len(setpoint.commands))
    return (round(t_boot * 1e6), *setpoint.commands, *unused, 0, system, component)


def _rates(setpoint: RateSetpoint, t_boot: float, system: int, component: int) -> tuple[Value, ...]:
    return (
        _milliseconds(t_boot), *IDENTITY, *setpoint.rates_b, setpoint.thrust, system, component, IGNORE_ATTITUDE,
        0.0, 0.0, 0.0,
    )  # fmt: skip


def _attitude(setpoint: AttitudeSetpoint, t_boot: float, system: int, component: int) -> tuple[Value, ...]:
    return (
        _milliseconds(t_boot), *setpoint.q_nb, 0.0, 0.0, 0.0, setpoint.thrust, system, component, IGNORE_RATES,
        0.0, 0.0, 0.0,
    )  # fmt: skip


def _milliseconds(t_boot: float) -> int:
    return round(t_boot * 1e3) & 0xFFFFFFFF
