"""What the level of rates remembers from step to step."""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.rate_loop_model import TimedCommand
from companion.estimation.vehicle_estimate import VehicleEstimate
from companion.law.speed_scale import UNITY, SpeedScale
from companion.steering.path_poles import PathPoles
from companion.steering.yaw import YawMemory


class RateMemory(NamedTuple):
    """The blocks' memories, side by side.

    ``estimate``: of the vehicle, at its last state. ``commands``: those that act at or after it. ``zeta``: N, the
    thrust at the horizon (Eq. 4). ``governor``: of the speed. ``yaw``: of the yaw compensation. ``poles``: of the path.
    ``delay``: s, the dead time; None before the first step. ``limited``: the last command met a limit. ``moving``: it
    was to fly somewhere.
    """

    estimate: VehicleEstimate
    commands: tuple[TimedCommand, ...]
    zeta: float
    governor: SpeedScale = UNITY
    yaw: YawMemory = YawMemory()
    poles: PathPoles = PathPoles()
    delay: float | None = None
    limited: bool = False
    moving: bool = False
