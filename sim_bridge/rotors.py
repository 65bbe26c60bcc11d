"""What rotors do: command to thrust, thrust to force and torque, and the lag of a motor.

A rotor's force is along body -z. Nothing here sums over the rotors; rigid_body does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from companion.frames import Vec3
from companion.vehicle import Rotor

Four = tuple[float, float, float, float]
"""One number a rotor, in motor order: commands in the rotors' own units, or thrusts in N."""


def torque_per_newton(rotor: Rotor) -> Vec3:
    """The torque about the centre of mass (FRD) of one newton of thrust: r x (0, 0, -1) and the reaction torque."""
    x, y, _ = rotor.position_b
    return (-y, x, rotor.spin.reaction * rotor.torque_per_thrust)


def thrust_wanted(rotors: tuple[Rotor, ...]) -> Callable[[Four], Four]:
    """A function from commands to the thrusts (N) they ask for, each command held to its rotor's range.

    A command that is not a number asks for the bottom of the range.
    """
    (low0, high0), (low1, high1), (low2, high2), (low3, high3) = (rotor.command for rotor in rotors)
    n0, n1, n2, n3 = (rotor.thrust_max for rotor in rotors)

    def wanted(commands: Four) -> Four:
        c0, c1, c2, c3 = commands
        return (
            n0 * (c0 if low0 <= c0 <= high0 else high0 if c0 > high0 else low0),
            n1 * (c1 if low1 <= c1 <= high1 else high1 if c1 > high1 else low1),
            n2 * (c2 if low2 <= c2 <= high2 else high2 if c2 > high2 else low2),
            n3 * (c3 if low3 <= c3 <= high3 else high3 if c3 > high3 else low3),
        )

    return wanted


class Lag(NamedTuple):
    """A first-order lag over one step, solved exactly: what is left of the gap after half and after the whole step."""

    half: float
    full: float

    @classmethod
    def over(cls, step: float, lag: float) -> Lag:
        """For a time constant ``lag`` and a step of ``step``, s. A lag of 0 follows at once."""
        return cls(math.exp(-0.5 * step / lag), math.exp(-step / lag)) if lag > 0.0 else cls(0.0, 0.0)


def course(lag: Lag, now: Four, wanted: Four) -> tuple[Four, Four, Four]:
    """The thrusts at the beginning, the middle and the end of a step in which ``wanted`` stays as it is.

    Without a lag the thrusts jump at the beginning, and the step knows only the new ones.
    """
    half, full = lag
    if full == 0.0:
        return (wanted, wanted, wanted)
    a0, a1, a2, a3 = now
    b0, b1, b2, b3 = wanted
    d0, d1, d2, d3 = a0 - b0, a1 - b1, a2 - b2, a3 - b3
    middle = (b0 + half * d0, b1 + half * d1, b2 + half * d2, b3 + half * d3)
    return (now, middle, (b0 + full * d0, b1 + full * d1, b2 + full * d2, b3 + full * d3))
