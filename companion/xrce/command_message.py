"""A setpoint -> the message that commands it, compiled once for a client's readers: each setpoint waits for it.

    header | DATA offboard_control_mode | DATA actuator_motors | DATA vehicle_thrust_setpoint

One ``struct`` of header and samples, of which a setpoint changes the sequence number, the state's stamp, the command
and the thrust. Stamps of the samples themselves are 0: PX4 puts its own time in.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

from companion.vehicle import AttitudeSetpoint, MotorSetpoint, OutputLevel, RateSetpoint, Setpoint, TorqueSetpoint
from companion.xrce.agent import Reader
from companion.xrce.messages import BEST_EFFORT
from companion.xrce.objects import Data
from companion.xrce.topics import Layout

MODE = "offboard_control_mode"
TOPICS = {
    OutputLevel.MOTORS: ("actuator_motors", "vehicle_thrust_setpoint"),
    OutputLevel.TORQUES: ("vehicle_torque_setpoint", "vehicle_thrust_setpoint"),
    OutputLevel.RATES: ("vehicle_rates_setpoint",),
    OutputLevel.ATTITUDE: ("vehicle_attitude_setpoint",),
}
"""What PX4 must read for a level, beside the mode. PX4's land detector believes the last vehicle_thrust_setpoint, so
that one is written along with motors: without it two take-offs ended in "landed" at 6 m and a disarming."""
FLAG = {
    OutputLevel.MOTORS: "direct_actuator",
    OutputLevel.TORQUES: "thrust_and_torque",
    OutputLevel.RATES: "body_rate",
    OutputLevel.ATTITUDE: "attitude",
}
"""The flag of offboard_control_mode."""
_COMMAND = {
    OutputLevel.MOTORS: ("actuator_motors", "control", 4),
    OutputLevel.TORQUES: ("vehicle_torque_setpoint", "xyz", 3),
    OutputLevel.RATES: ("vehicle_rates_setpoint", "roll", 3),  # and pitch and yaw, which follow it
    OutputLevel.ATTITUDE: ("vehicle_attitude_setpoint", "q_d", 4),
}
"""The field that a command begins with, and how many values it has."""
_THRUST = {
    OutputLevel.MOTORS: ("vehicle_thrust_setpoint", "xyz"),
    OutputLevel.TORQUES: ("vehicle_thrust_setpoint", "xyz"),
    OutputLevel.RATES: ("vehicle_rates_setpoint", "thrust_body"),
    OutputLevel.ATTITUDE: ("vehicle_attitude_setpoint", "thrust_body"),
}
"""The thrust, a vector of the body; commanded is its last component, downwards."""
_SEQUENCE = 2
"""Index of the sequence number among the values."""
READER_IDS = 4
"""bytes of a reader's request and object id, before its sample."""


class CommandMessage:
    """The message of one ``level`` for these ``readers`` in a ``session``; with the mode, if that is among them."""

    __slots__ = ("_command", "_pack", "_stamps", "_thrust", "_values", "readers", "session")

    def __init__(self, level: OutputLevel, session: int, readers: Sequence[Reader], layouts: Sequence[Layout]) -> None:
        self.session, self.readers = session, list(readers)
        code = "<BBH"
        values: list[Any] = [session, BEST_EFFORT, 0]
        begins: dict[tuple[str, str], int] = {}
        for reader, layout in zip(readers, layouts, strict=True):
            size = READER_IDS + layout.size
            code += f"BBH{READER_IDS}s{layout.code}{-size % 4}x"
            values += [Data.ID, Data.FLAGS, size, reader.ids]
            for name, where in layout.fields.items():
                begins[reader.topic.name, name] = len(values) + (where.start if isinstance(where, slice) else where)
            values += layout.zero
        self._stamps = [at for (_, name), at in begins.items() if name == "timestamp_sample"]
        if (MODE, FLAG[level]) in begins:
            values[begins[MODE, FLAG[level]]] = True
        topic, name, count = _COMMAND[level]
        begin = begins[topic, name]
        self._command = slice(begin, begin + count)
        self._thrust = begins[_THRUST[level]] + 2
        if level is OutputLevel.MOTORS:  # of its twelve a quadrotor has not: NaN leaves them stopped
            values[begin + count : begin + 12] = [math.nan] * (12 - count)
        self._values, self._pack = values, struct.Struct(code).pack

    def encode(self, sequence: int, setpoint: Setpoint, sample: int) -> bytes:
        """The message with a ``setpoint`` of its level. ``sample``: us, PX4's stamp of the state, by which it measures
        its latency."""
        values = self._values.copy()
        values[_SEQUENCE] = sequence
        for at in self._stamps:
            values[at] = sample
        match setpoint:
            case MotorSetpoint(command):
                thrust = sum(command) / len(command)
            case TorqueSetpoint(command, thrust) | RateSetpoint(command, thrust) | AttitudeSetpoint(command, thrust):
                pass
        values[self._command] = command
        values[self._thrust] = -thrust
        return self._pack(*values)
