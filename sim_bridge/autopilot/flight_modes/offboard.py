"""What offboard flies of the last setpoint."""

from __future__ import annotations

from typing import NamedTuple

from companion.frames import euler_from_rotation, rotation_matrix
from companion.mavlink.modes import Mode
from sim_bridge.autopilot.flight_modes.guidance import CLOSED_OF_HOVER, Throttle, takeoff_throttle
from sim_bridge.autopilot.flight_modes.position_setpoints import TrajectorySetpoint
from sim_bridge.autopilot.flight_modes.setpoints import (
    ActuatorMotors,
    AttitudeSetpoint,
    MotorSetpoint,
    RatesSetpoint,
    Setpoint,
    TorqueSetpoint,
)
from sim_bridge.autopilot.flight_modes.topics import LEVEL_OF, Level, Topics
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.control.cascade import Cascade
from sim_bridge.control.position import Target
from sim_bridge.rotors import Four
from sim_bridge.sensors import Estimate

STOP = (0.0, 0.0, 0.0)
"""m/s."""


class Ground(NamedTuple):
    """Whether the vehicle counts as landed, stands on its legs, and has felt the ground for long enough."""

    landed: bool
    stands: bool
    touching: bool


class PositionFlight:
    """The flight of a TrajectorySetpoint, from the ground to the ground. ``target``: what was last asked for."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._rises_from: float | None = None  # s, when the throttle began to open
        self.target: Target | None = None

    def aim(self, now: Estimate, setpoint: TrajectorySetpoint, on: Ground, armed_for: float) -> Target | Throttle:
        """What the position loop is to fly. ``armed_for``: s."""
        self.target = None
        t = now.time_us * 1e-6
        climbs = setpoint.can_be_flown and setpoint.climbs_from(now.p_n[2])
        if on.landed or (self._rises_from is not None and on.stands):
            if not climbs or armed_for < self._parameters["COM_SPOOLUP_TIME"]:
                self._rises_from = None
                return Throttle(0.0)
            self._rises_from = t if self._rises_from is None else self._rises_from
            return takeoff_throttle(t - self._rises_from, self._parameters["MPC_Z_VEL_MAX_UP"], self._parameters)
        self._rises_from = None
        if on.touching and setpoint.sinks(now.p_n[2]):
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


class OffboardFlight:
    """Flies the last ``setpoint``, for as long as the commander leaves the vehicle in offboard; None: none has come.

    ``position``: the flight to places. ``topics``: what is written from outside. ``direct``: the vehicle takes motor
    commands over MAVLink.
    """

    def __init__(self, parameters: Parameters, cascade: Cascade, *, direct: bool) -> None:
        self.position = PositionFlight(parameters)
        self.topics = Topics()
        self.setpoint: Setpoint | None = None
        self._cascade = cascade
        self._direct = direct

    def take(self, setpoint: Setpoint) -> None:
        """Another setpoint."""
        if isinstance(setpoint, TrajectorySetpoint) and not isinstance(self.setpoint, TrajectorySetpoint):
            self._cascade.begin_position()
        self.setpoint = setpoint

    def fly(self, now: Estimate, on: Ground, armed_for: float) -> Four:
        """The motor commands of the setpoint. ``armed_for``: s."""
        setpoint, cascade = self.setpoint, self._cascade
        assert setpoint is not None
        if isinstance(setpoint, MotorSetpoint):
            return cascade.fly_motors(now, setpoint.commands)
        if isinstance(setpoint, TrajectorySetpoint):
            return self._fly_to_a_place(now, setpoint, on, armed_for)
        if isinstance(setpoint, ActuatorMotors):
            return cascade.hold_motors(setpoint.commands)
        if isinstance(setpoint, TorqueSetpoint):
            return cascade.fly_torque(setpoint.torque)
        return fly(cascade, now, setpoint, on.landed)

    def go_on(self, now: Estimate, level: Level, landed: bool) -> Four:
        """The motor commands before the first setpoint of a ``level``: what was flown goes on."""
        cascade = self._cascade
        if self._direct:
            return cascade.fly_motors(now, cascade.commands)
        if level >= Level.TORQUES:
            return cascade.hold_motors(cascade.commands)
        return cascade.fly_rates(now, cascade.rates_wanted, cascade.thrust, landed)

    def _fly_to_a_place(self, now: Estimate, setpoint: TrajectorySetpoint, on: Ground, armed_for: float) -> Four:
        """A place, a velocity, an acceleration."""
        cascade = self._cascade
        if cascade.wants_target:
            wanted = self.position.aim(now, setpoint, on, armed_for)
            if isinstance(wanted, Throttle):
                return cascade.open_throttle(now, wanted.of_hover)
            cascade.aim(now, wanted)
        return cascade.fly_aim(now)

    def level(self, mode: Mode, external: Level | None) -> Level:
        """The level the vehicle's own loops are told at in a mode. ``external``: at which it is flown by others."""
        if external is not None:
            return external
        if mode is not Mode.OFFBOARD:
            return Level.POSITION
        if self.topics.level is not None:
            return self.topics.level
        return Level.RATES if self.setpoint is None else LEVEL_OF.get(type(self.setpoint), Level.POSITION)

    def fight(self, written: ActuatorMotors | TorqueSetpoint) -> Four:
        """The motor commands of a step in which somebody wrote past the vehicle's own loops."""
        cascade = self._cascade
        commands = written.commands if isinstance(written, ActuatorMotors) else cascade.mixed(written.torque)
        cascade.commands = commands
        return commands


def fly(cascade: Cascade, now: Estimate, setpoint: AttitudeSetpoint | RatesSetpoint, landed: bool) -> Four:
    """An attitude or rates."""
    if isinstance(setpoint, RatesSetpoint):
        return cascade.fly_rates(now, setpoint.rates, setpoint.thrust, landed)
    return cascade.fly_attitude(now, setpoint.q_nb, setpoint.thrust, setpoint.heading_rate, landed)
