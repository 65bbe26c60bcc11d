"""What every output level has in common: the seam between the pilot and the law."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from companion.law.flight import Command, Ramp, Thrust
from companion.vehicle import Setpoint, VehicleState


class Steered(NamedTuple):
    """One step of steering.

    ``setpoint``: clamped and finite. ``thrust``: the extension's state for the next step. ``command``: what the law
    asked for. ``thrust_n``: N, the collective thrust that was sent. ``saturated``: whether a limit was met.
    """

    setpoint: Setpoint
    thrust: Thrust
    command: Command
    thrust_n: float
    saturated: bool


class Steering(Protocol):
    """The law at one output level."""

    def begin(self) -> Thrust:
        """The extension's state when taking over from a hover."""

    def steer(self, thrust: Thrust, state: VehicleState, dt: float, ramp: Ramp) -> Steered:
        """The setpoint for ``state``. ``dt``: s since the last step, 0 to hold the extension. Raises LawError."""

    def level(self, state: VehicleState | None) -> Setpoint:
        """A setpoint that levels and hovers: from a fresh state, or from none (then it asks for no turning)."""
