"""The setpoints that come over a link, for the autopilot's offboard mode."""

from __future__ import annotations

from collections.abc import Callable

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Value
from companion.mavlink_common import MAV_COMP_ID_AUTOPILOT1, MavSeverity
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.flight_modes import position_setpoints
from sim_bridge.autopilot.flight_modes.position_setpoints import TrajectorySetpoint
from sim_bridge.autopilot.flight_modes.setpoints import ACTUATORS, ATTITUDE_TARGET, actuator_controls, attitude_target

SYSTEM = 1
"""The vehicle's own MAVLink system id: PX4's default of MAV_SYS_ID."""
COMPONENT = MAV_COMP_ID_AUTOPILOT1


class SetpointLink:
    """Takes setpoints that are meant for the vehicle. ``handlers``: by message id."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self.handlers: dict[int, Callable[[Frame], None]] = {
            ACTUATORS.id: self._actuators,
            ATTITUDE_TARGET.id: self._attitude_target,
            position_setpoints.LOCAL.id: self._local_target,
            position_setpoints.GLOBAL.id: self._global_target,
        }

    def _attitude_target(self, frame: Frame) -> None:
        if _targets_us(frame):
            setpoint = attitude_target(frame.values)
            if setpoint is not None:
                self._autopilot.offboard(setpoint)

    def _local_target(self, frame: Frame) -> None:
        if _targets_us(frame):
            self._take_place(position_setpoints.local_target(frame, self._autopilot.estimate.q_nb))

    def _global_target(self, frame: Frame) -> None:
        if _targets_us(frame):
            self._take_place(position_setpoints.global_target(frame, self._autopilot.home_position.place_of))

    def _take_place(self, setpoint: TrajectorySetpoint | str | None) -> None:
        if isinstance(setpoint, str):
            self._autopilot.commander.say(MavSeverity.CRITICAL, setpoint)
        elif setpoint is not None:
            self._autopilot.offboard(setpoint)

    def _actuators(self, frame: Frame) -> None:
        if _targets_us(frame):
            setpoint = actuator_controls(frame.values)
            if setpoint is not None:
                self._autopilot.offboard(setpoint)


def is_for_us(system: Value, component: Value) -> bool:
    """Whether a message with such a target is meant for the vehicle."""
    return system in (0, SYSTEM) and component in (0, COMPONENT)


def _targets_us(frame: Frame) -> bool:
    where = frame.format.where
    return is_for_us(frame.values[where["target_system"]], frame.values[where["target_component"]])
