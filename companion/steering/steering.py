"""What every output level has in common: the seam between the pilot and the law."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from companion.law.flight import Command, Ramp
from companion.vehicle import Setpoint, VehicleState

SteeringMemory = Any
"""What a level carries from step to step; frozen, and nobody else's business."""


class Steered(NamedTuple):
    """One step of steering.

    ``setpoint``: clamped and finite. ``memory``: for the next step. ``command``: what the law asked for. ``zeta``: N,
    ``zeta_dot``: N/s, the dynamic extension (Eq. 4). ``thrust_n``: N, the collective thrust that was sent.
    ``saturated``: whether a limit was met.
    """

    setpoint: Setpoint
    memory: SteeringMemory
    command: Command
    zeta: float
    zeta_dot: float
    thrust_n: float
    saturated: bool


class Steering(Protocol):
    """The law at one output level."""

    def begin(self) -> SteeringMemory:
        """The memory when taking over from a hover."""

    def steer(self, memory: SteeringMemory, state: VehicleState, dt: float, ramp: Ramp, s: float) -> Steered:
        """The setpoint for ``state``, whose nearest point on the path lies at arc length ``s`` (m).

        ``dt``: s since the last step, 0 to hold the extension. Raises LawError.
        """

    def level(self, state: VehicleState | None) -> Setpoint:
        """A setpoint that levels and hovers: from a fresh state, or from none (then it asks for no turning)."""
