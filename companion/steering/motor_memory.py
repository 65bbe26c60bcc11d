"""What the level of motors remembers from step to step."""

from __future__ import annotations

from typing import NamedTuple

from companion.estimation.body_model import TimedWrench
from companion.estimation.motor_estimate import MotorEstimate
from companion.law.speed_scale import UNITY, SpeedScale
from companion.steering.path_poles import PathPoles


class Extension(NamedTuple):
    """The thrust the law integrates: ``zeta`` N, ``zeta_dot`` N/s, and the last ``zeta_ddot``, N/s^2 (Eq. 4)."""

    zeta: float
    zeta_dot: float = 0.0
    zeta_ddot: float = 0.0

    def after(self, dt: float) -> Extension:
        """``dt`` s later, to first order."""
        return Extension(self.zeta + dt * self.zeta_dot, self.zeta_dot + dt * self.zeta_ddot, self.zeta_ddot)


class MotorMemory(NamedTuple):
    """The blocks' memories, side by side."""

    estimate: MotorEstimate  # of the vehicle, at its last state
    commands: tuple[TimedWrench, ...]  # those that act at or after it
    extension: Extension  # of the thrust
    governor: SpeedScale = UNITY  # of the speed
    poles: PathPoles = PathPoles()  # of the path
    delay: float | None = None  # s, the dead time; None before the first step
    limited: bool = False  # the last command met a limit
    moving: bool = False  # it was to fly somewhere
