"""What offboard flies of the last setpoint."""

from __future__ import annotations

from companion.frames import euler_from_rotation, rotation_matrix
from sim_bridge.autopilot.flight_modes.guidance import CLOSED_OF_HOVER, Throttle, takeoff_throttle
from sim_bridge.autopilot.flight_modes.position_setpoints import TrajectorySetpoint
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.control.position import Target
from sim_bridge.sensors import Estimate

STOP = (0.0, 0.0, 0.0)
"""m/s."""


class PositionFlight:
    """The flight of a TrajectorySetpoint, from the ground to the ground. ``target``: what was last asked for."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._rises_from: float | None = None  # s, when the throttle began to open
        self.target: Target | None = None

    def aim(
        self, now: Estimate, setpoint: TrajectorySetpoint, armed_for: float, landed: bool, stands: bool, touching: bool
    ) -> Target | Throttle:  # fmt: skip
        """What the position loop is to fly. ``armed_for``: s; ``stands``: the legs are on the ground."""
        self.target = None
        t = now.time_us * 1e-6
        climbs = setpoint.can_be_flown and setpoint.climbs_from(now.p_n[2])
        if landed or (self._rises_from is not None and stands):
            if not climbs or armed_for < self._parameters["COM_SPOOLUP_TIME"]:
                self._rises_from = None
                return Throttle(0.0)
            self._rises_from = t if self._rises_from is None else self._rises_from
            return takeoff_throttle(t - self._rises_from, self._parameters["MPC_Z_VEL_MAX_UP"], self._parameters)
        self._rises_from = None
        if touching and setpoint.sinks(now.p_n[2]):
            return Throttle(CLOSED_OF_HOVER)
        heading = setpoint.heading
        if heading is None:
            heading = euler_from_rotation(rotation_matrix(now.q_nb))[0]
        if setpoint.can_be_flown:
            self.target = Target(
                setpoint.position, setpoint.velocity, heading, setpoint.acceleration, setpoint.heading_rate
            )  # fmt: skip
        else:  # PX4's answer to what makes no sense: stop and wait
            self.target = Target((None, None, None), STOP, heading)
        return self.target
