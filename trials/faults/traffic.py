"""What companion and vehicle told each other, as the companion heard and said it: every byte, both ways."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from companion import mavlink_common as mav
from companion.mavlink.codec import Decoder, Frame
from companion.mavlink.dialect import message
from companion.mavlink.modes import Mode, mode_of
from companion.vehicle import Vehicle

HEARTBEAT, CURRENT_MODE, ODOMETRY = message("HEARTBEAT"), message("CURRENT_MODE"), message("ODOMETRY")
COMMAND_LONG, COMMAND_INT, SET_MODE = message("COMMAND_LONG"), message("COMMAND_INT"), message("SET_MODE")
ATTITUDE_TARGET, ACTUATORS = message("SET_ATTITUDE_TARGET"), message("SET_ACTUATOR_CONTROL_TARGET")
CHANGING = {
    mav.MAV_CMD_NAV_WAYPOINT: "NAV_WAYPOINT",
    mav.MAV_CMD_NAV_RETURN_TO_LAUNCH: "RETURN",
    mav.MAV_CMD_NAV_LAND: "LAND",
    mav.MAV_CMD_NAV_TAKEOFF: "TAKEOFF",
    mav.MAV_CMD_NAV_LAND_LOCAL: "PRECISION_LAND",
    mav.MAV_CMD_DO_ORBIT: "ORBIT",
    mav.MAV_CMD_NAV_VTOL_TAKEOFF: "VTOL_TAKEOFF",
    mav.MAV_CMD_DO_SET_MODE: "MODE",
    mav.MAV_CMD_DO_FLIGHTTERMINATION: "TERMINATE",
    mav.MAV_CMD_DO_REPOSITION: "REPOSITION",
    mav.MAV_CMD_DO_SET_ROI_LOCATION: "ROI",
    mav.MAV_CMD_OVERRIDE_GOTO: "OVERRIDE_GOTO",
    mav.MAV_CMD_DO_SET_STANDARD_MODE: "STANDARD_MODE",
    mav.MAV_CMD_MISSION_START: "MISSION_START",
    mav.MAV_CMD_COMPONENT_ARM_DISARM: "ARM_DISARM",
    mav.MAV_CMD_GUIDED_CHANGE_SPEED: "GUIDED",
}
"""Commands that change mode, arming or place."""
STATE_AGE_MAX = 0.6
"""s between the arrival of a state and a setpoint made from it: 0.2 until it is stale, 0.3 of levelling, and the time
until each is noticed (the pilot looks around every 0.05 s)."""
ROUNDING = 1e-4
"""Of a float32 on the wire, against its limit."""


class Said(NamedTuple):
    """A command of the companion's that changes mode, arming or place. ``mode``: the one it asks for, if one."""

    at: float
    words: str
    mode: Mode | None = None


class Heard(NamedTuple):
    """What the vehicle said of itself. ``armed``: None where the message does not say."""

    at: float
    mode: Mode
    intended: Mode | None
    armed: bool | None


@dataclass
class Traffic:
    """``states_at``: when states arrived; ``statuses``: what was said of mode and arming; ``commands``, ``setpoints_at``:
    what the companion sent, and when; ``bad``: setpoints that must not be sent, in words."""

    vehicle: Vehicle
    states_at: list[float] = field(default_factory=list)
    statuses: list[Heard] = field(default_factory=list)
    commands: list[Said] = field(default_factory=list)
    setpoints_at: list[float] = field(default_factory=list)
    bad: list[str] = field(default_factory=list)
    _in: Decoder = field(default_factory=lambda: Decoder(wanted={HEARTBEAT.id, CURRENT_MODE.id, ODOMETRY.id}))
    _out: Decoder = field(default_factory=Decoder)
    _stamps: dict[int, float] = field(default_factory=dict)

    def hear(self, datagram: bytes, now: float) -> None:
        """The companion is given a datagram that comes from its vehicle's address."""
        for frame in self._in.piece(datagram, now):
            if (frame.system, frame.component) == (1, 1):
                self._heard(frame, now)

    def say(self, datagram: bytes, now: float) -> None:
        """The companion sends a datagram."""
        for frame in self._out.datagram(datagram):
            if frame.format in (COMMAND_LONG, COMMAND_INT, SET_MODE):
                said = _changing(frame, now)
                if said is not None:
                    self.commands.append(said)
            elif frame.format in (ATTITUDE_TARGET, ACTUATORS):
                self.setpoints_at.append(now)
                self._look_at(frame, now)

    def last_status(self, now: float) -> Heard | None:
        """What the vehicle last said of its mode until ``now``, s; None: nothing."""
        return next((heard for heard in reversed(self.statuses) if heard.at <= now), None)

    def status_before(self, now: float) -> float:
        """When that was, s; minus infinity if it never has."""
        heard = self.last_status(now)
        return -math.inf if heard is None else heard.at

    def state_after(self, now: float) -> float:
        """When the first state arrived after ``now``, s; infinity if none did."""
        return next((t for t in self.states_at if t > now), math.inf)

    def _heard(self, frame: Frame, now: float) -> None:
        if frame.format is ODOMETRY:
            self.states_at.append(now)
            stamp = frame.values[0]
            self._stamps[stamp // 1000 & 0xFFFFFFFF] = self._stamps[(stamp + 500) // 1000 & 0xFFFFFFFF] = now
        elif frame.format is CURRENT_MODE:
            self.statuses.append(Heard(now, mode_of(frame.values[0]), mode_of(frame.values[1]), None))
        else:
            custom_mode, _, _, base_mode, _, _ = frame.values
            self.statuses.append(
                Heard(now, mode_of(custom_mode), None, bool(base_mode & mav.MAV_MODE_FLAG_SAFETY_ARMED))
            )

    def _look_at(self, frame: Frame, now: float) -> None:
        """A setpoint is finite, within the vehicle's limits, and made from a state that was heard just now."""
        if frame.format is ACTUATORS:
            stamp, commands = frame.values[0] // 1000, frame.values[1:5]
            low = min(rotor.command[0] for rotor in self.vehicle.rotors)
            high = max(rotor.command[1] for rotor in self.vehicle.rotors)
            fits = all(low - ROUNDING <= command <= high + ROUNDING for command in commands)
        else:
            stamp, q, rates, thrust = frame.values[0], frame.values[1:5], frame.values[5:8], frame.values[8]
            limits = self.vehicle.limits
            most: Sequence[float] = (math.inf,) * 3 if limits is None else limits.body_rates
            fits = (
                all(abs(rate) <= limit + ROUNDING for rate, limit in zip(rates, most, strict=True))
                and -ROUNDING <= thrust <= 1.0 + ROUNDING
                and abs(math.hypot(*q) - 1.0) < 1e-3
            )
        if not fits:  # also where something is no number
            self.bad.append(f"{now:.3f} s: {frame.format.named(frame.values)}")
        age = now - self._stamps.get(stamp & 0xFFFFFFFF, -math.inf)
        if age > STATE_AGE_MAX:
            self.bad.append(f"{now:.3f} s: made from a state of {stamp} ms, heard {age:.2f} s ago")


def _changing(frame: Frame, now: float) -> Said | None:
    if frame.format is SET_MODE:
        return Said(now, "SET_MODE", mode_of(frame.values[0]))
    fields = frame.format.named(frame.values)
    command = fields["command"]
    if command not in CHANGING:
        return None
    if command == mav.MAV_CMD_DO_SET_MODE:
        mode = mode_of(int(fields["param2"]) << 16 | int(fields["param3"]) << 24)
        return Said(now, mode.words, mode)
    if command == mav.MAV_CMD_COMPONENT_ARM_DISARM:
        return Said(now, "ARM" if fields["param1"] == 1.0 else "DISARM")
    return Said(now, CHANGING[command])
