"""What every output level has in common: the seam between the pilot and the law."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

from companion.estimation.learned import Learned
from companion.frames import Vec3
from companion.law.flight import Command
from companion.law.speed_scale import SpeedScale
from companion.vehicle import Setpoint, VehicleState

SteeringMemory = Any
"""What a level carries from step to step; frozen, and nobody else's business."""


class Along(NamedTuple):
    """Fly the path. ``s``: m, arc length near the closest point. ``speed_scale``: the factor on alpha."""

    s: float
    speed_scale: SpeedScale


class At(NamedTuple):
    """Hold a point of the local frame (m), the nose at ``yaw`` (rad). Far away it is approached at a steady speed."""

    p_n: Vec3
    yaw: float


Aim = Along | At


class Estimates(NamedTuple):
    """What a level has found out about its vehicle, for the record."""

    thrust_scale: float  # acceleration made over acceleration asked for
    drag: float  # 1/s
    disturbance: Vec3  # m/s^2, world
    velocity_bias: Vec3  # m/s, reported velocity over the derivative of the reported position
    dead_time: float  # s
    rate_lag: float  # s
    yaw_lag: float = math.nan  # s
    path_pole: float = math.nan  # 1/s, of h1 and h2, where it was chosen and not written
    motor_lag: float = math.nan  # s, where it is looked for
    thrust_curve: float = math.nan  # slope of the thrust beyond proportion to its command, where it is looked for
    thrust_curve_std: float = math.nan  # of it


class Steered(NamedTuple):
    """One step of steering."""

    setpoint: Setpoint  # clamped and finite
    memory: SteeringMemory  # for the next step
    command: Command  # what the law asked for
    zeta: float  # N, the dynamic extension (Eq. 4)
    zeta_dot: float  # N/s
    thrust: float  # N, the collective thrust that was sent
    saturated: bool  # whether a limit was met
    thrust_share: float = 0.0  # of the largest thrust
    converged: bool = True  # whether the thrust scale is known well enough to follow a path
    governor: float = 1.0  # share of the mission's speed that was asked for; below 1 where it could not be flown
    estimates: Estimates | None = None  # None where the level has none
    rotor_left: float = 1.0  # share of its thrust that the weakest rotor gives, where the level can tell


class Steering(Protocol):
    """The law at one output level."""

    def begin(self, state: VehicleState) -> SteeringMemory:
        """The memory when taking over from a flight without hurry, at ``state``."""

    def steer(
        self, memory: SteeringMemory, state: VehicleState, dt: float, aim: Aim, round_trip: float | None = None
    ) -> Steered:
        """The setpoint for ``state``. Raises LawError.

        ``dt``: s since the last step; 0 while setpoints are sent but not flown: then the thrust the law integrates and
        the estimates stand still. ``round_trip``: s, there and back, as measured; None where it is not known.
        """

    def learn(self, memory: SteeringMemory) -> SteeringMemory:
        """What the last step's state teaches of the vehicle, taken in. It does not feed that step's setpoint, so it is
        best done when that is on its way; the next step does it where it was not."""

    def level_setpoint(self, state: VehicleState | None, memory: SteeringMemory | None = None) -> Setpoint:
        """A setpoint that levels and hovers: from a fresh state, or from none (then it asks for no turning).
        ``memory``: of the flight so far, if there was one."""

    def learned_values(self, memory: SteeringMemory) -> Learned | None:
        """What the flight found out of its vehicle, for the next one; None if that is nothing."""
