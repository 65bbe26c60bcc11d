"""The paper's law as a function of the extended state, without limits: what ``companion law`` computes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.allocation import Allocation
from companion.law.bare import bare_law, state_names
from companion.law.flight import model_of
from companion.law.gains import Level, default_gains
from companion.mission import Mission
from companion.vehicle import CompanionError, Vehicle

Array = NDArray[np.float64]


class LawAnswer(NamedTuple):
    """xi, b and D of Eq. (8); ``u``: (zeta_ddot, u2, u3, u4) at motors, (zeta_dot, p, q, r) at rates; ``tau``: M^-1 u,
    N of the four motors, None at rates."""

    xi: Array
    b: Array
    D: Array
    u: Array
    tau: Array | None


class ControlLaw:
    """``law(chi) -> LawAnswer``. ``state_names``: the order of chi; SI, radians, z down."""

    def __init__(self, mission: Mission, vehicle: Vehicle, level: Level) -> None:
        self.level = level
        self.state_names = state_names(level)
        gains = mission.gains if mission.gains is not None else default_gains(level)
        self._law = bare_law(mission.specification(1.0), level, model_of(vehicle), gains)
        self._allocation = Allocation(vehicle)

    def __call__(self, chi: Sequence[float] | Array) -> LawAnswer:
        """The answer at a state. LawError: the law is not defined there. CompanionError: chi is no state."""
        state = [float(value) for value in chi]
        if len(state) != len(self.state_names):
            raise CompanionError(
                f"{len(state)} numbers; expected {len(self.state_names)}: {', '.join(self.state_names)}"
            )
        if not np.all(np.isfinite(state)):
            raise CompanionError("a number that is not finite")
        answer = self._law(state)
        tau: Array | None = None
        if self.level is Level.MOTORS:
            _, u2, u3, u4 = answer.inputs
            tau = np.array(self._allocation.motor_torques((state[-2], u2, u3, u4)), dtype=float)
        return LawAnswer(np.array(answer.xi), np.array(answer.b), np.array(answer.D), np.array(answer.inputs), tau)
