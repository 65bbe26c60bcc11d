"""What the level of rates remembers from step to step."""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.rate_loop_model import TimedCommand
from companion.estimation.vehicle_estimate import VehicleEstimate
from companion.law.speed_scale import UNITY, SpeedScale
from companion.steering.path_poles import PathPoles
from companion.steering.yaw import YawMemory


class RateMemory(NamedTuple):
    """The blocks' memories, side by side."""

    estimate: VehicleEstimate  # of the vehicle, at its last state
    commands: tuple[TimedCommand, ...]  # those that act at or after it
    zeta: float  # N, the thrust at the horizon (Eq. 4)
    governor: SpeedScale = UNITY  # of the speed
    yaw: YawMemory = YawMemory()  # of the yaw compensation
    poles: PathPoles = PathPoles()  # of the path
    delay: float | None = None  # s, the dead time; None before the first step
    limited: bool = False  # the last command met a limit of what the vehicle makes
    moving: bool = False  # it was to fly somewhere
