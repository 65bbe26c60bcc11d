"""What is written to the vehicle over XRCE: samples of PX4's topics to what the autopilot is asked for.

PX4 asks neither who wrote nor in which mode it is. Values that are no numbers count as nothing, but for a motor, which
they stop, and a body rate, which they ask nothing of.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from companion.frames import Vec3, normalised
from companion.xrce.topics import Topic, TopicError, layout
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.flight_modes.setpoints import (
    RATE_MOST,
    THRUST_MOST,
    ActuatorMotors,
    AttitudeSetpoint,
    RatesSetpoint,
    TorqueSetpoint,
)
from sim_bridge.autopilot.flight_modes.topics import level_of

FLAGS = ("position", "velocity", "acceleration", "attitude", "body_rate", "thrust_and_torque", "direct_actuator")
"""offboard_control_mode's, in their order."""

Fields = dict[str, Any]


class Subscriptions:
    """Takes samples for one autopilot. ``versioned``: its release numbers its messages."""

    def __init__(self, autopilot: Autopilot, *, versioned: bool) -> None:
        self._autopilot = autopilot
        self._versioned = versioned
        self.handlers: dict[str, Callable[[Fields, int], None]] = {
            "offboard_control_mode": self._offboard_mode,
            "actuator_motors": self._motors,
            "vehicle_torque_setpoint": self._torque,
            "vehicle_thrust_setpoint": self._thrust,
            "vehicle_rates_setpoint": self._rates,
            "vehicle_attitude_setpoint": self._attitude,
            "register_ext_component_request": self._register,
            "unregister_ext_component": self._unregister,
            "arming_check_reply": self._arming_check,
            "config_control_setpoints": self._configure,
        }

    def take(self, topic: Topic, sample: bytes, offset_us: int) -> None:
        """A sample came. ``offset_us``: from the vehicle's clock to the agent's. What is not known does nothing."""
        handler = self.handlers.get(topic.name)
        if handler is None:
            return
        try:
            fields = layout(topic, versioned=self._versioned).decode(sample)
        except TopicError:
            return
        if fields is not None:
            handler(fields, self._written_at_us(fields["timestamp"], offset_us))

    def _written_at_us(self, stamp: int, offset_us: int) -> int:
        """us of the vehicle's clock that a sample says it was written at: never the future; 0 is now."""
        now_us = round(self._autopilot.t * 1e6)
        return now_us if stamp == 0 else min(stamp - offset_us, now_us)

    def _offboard_mode(self, fields: Fields, at_us: int) -> None:
        flags = tuple(fields[flag] for flag in FLAGS)
        self._autopilot.take_offboard_mode(level_of(flags), at_us * 1e-6)

    def _motors(self, fields: Fields, at_us: int) -> None:
        rotors = self._autopilot.vehicle.rotors
        shares = fields["control"][: len(rotors)]
        a, b, c, d = (_command(share, rotor.command[1]) for share, rotor in zip(shares, rotors, strict=True))
        self._autopilot.write(ActuatorMotors((a, b, c, d)))

    def _torque(self, fields: Fields, at_us: int) -> None:
        torque: Vec3 = fields["xyz"]
        if all(map(math.isfinite, torque)):
            self._autopilot.write(TorqueSetpoint(torque))

    def _thrust(self, fields: Fields, at_us: int) -> None:
        thrust = _thrust_of(fields["xyz"])
        if thrust is not None:
            self._autopilot.cascade.thrust = thrust

    def _rates(self, fields: Fields, at_us: int) -> None:
        thrust = _thrust_of(fields["thrust_body"])
        if thrust is not None:
            p, q, r = (_rate(fields[axis]) for axis in ("roll", "pitch", "yaw"))
            self._autopilot.write(RatesSetpoint((p, q, r), thrust))

    def _attitude(self, fields: Fields, at_us: int) -> None:
        q, thrust = fields["q_d"], _thrust_of(fields["thrust_body"])
        if thrust is not None and 0.5 < math.hypot(*q) < 2.0:
            heading_rate = fields["yaw_sp_move_rate"]
            turning = heading_rate if math.isfinite(heading_rate) else 0.0
            self._autopilot.write(AttitudeSetpoint(normalised(q), thrust, turning))

    def _register(self, fields: Fields, at_us: int) -> None:
        commander = self._autopilot.commander
        commander.external_modes.register(fields, commander.armed)

    def _unregister(self, fields: Fields, at_us: int) -> None:
        commander = self._autopilot.commander
        commander.finish_mode(commander.external_modes.unregister(fields))

    def _arming_check(self, fields: Fields, at_us: int) -> None:
        self._autopilot.commander.external_modes.answer(fields, self._autopilot.t - at_us * 1e-6)

    def _configure(self, fields: Fields, at_us: int) -> None:
        self._autopilot.commander.external_modes.configure(fields)


def _command(share: float, full: float) -> float:
    """A motor's command of its share of thrust: at most all; none, or less than none, stops it."""
    return full * min(1.0, share) if share > 0.0 else 0.0


def _thrust_of(xyz: Vec3) -> float | None:
    """The thrust upwards of a vector in the body; None: it is no number."""
    thrust = -xyz[2]
    return max(-THRUST_MOST, min(THRUST_MOST, thrust)) if math.isfinite(thrust) else None


def _rate(value: float) -> float | None:
    return max(-RATE_MOST, min(RATE_MOST, value)) if math.isfinite(value) else None
