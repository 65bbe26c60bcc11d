"""What rotors do: command to thrust, thrust to force and torque, and how a motor follows: a lag, or its own motion.

A rotor's force is along body -z. Nothing here sums over the rotors; rigid_body does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from companion.frames import Vec3
from companion.vehicle import Rotor
from companion.world.machine import RotorDynamics

Four = tuple[float, float, float, float]
"""One number a rotor, in motor order: commands in the rotors' own units, or thrusts in N."""


def torque_per_newton(rotor: Rotor) -> Vec3:
    """The torque about the centre of mass (FRD) of one newton of thrust: r x (0, 0, -1) and the reaction torque."""
    x, y, _ = rotor.position_b
    return (-y, x, rotor.spin.reaction * rotor.torque_per_thrust)


def thrust_wanted(rotors: tuple[Rotor, ...], curve: float = 0.0) -> Callable[[Four], Four]:
    """A function from commands to the thrusts (N) they ask for, each command held to its rotor's range.

    A command that is not a number asks for the bottom of the range. ``curve``: the part of the thrust that goes with
    the square of the command over its highest (PX4's THR_MDL_FAC).
    """
    if curve > 0.0:
        straight, highest = thrust_wanted(rotors), [rotor.thrust_max * rotor.command[1] for rotor in rotors]

        def curved(commands: Four) -> Four:
            a, b, c, d = (
                n * ((1.0 - curve) + curve * abs(n) / most) for n, most in zip(straight(commands), highest, strict=True)
            )
            return (a, b, c, d)

        return curved
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


class MotorLag(NamedTuple):
    """A first-order lag over one step, solved exactly: what is left of the gap after half and after the whole step."""

    half: float
    full: float

    @classmethod
    def over(cls, step: float, lag: float) -> MotorLag:
        """For a time constant ``lag`` and a step of ``step``, s. A lag of 0 follows at once."""
        return cls(math.exp(-0.5 * step / lag), math.exp(-step / lag)) if lag > 0.0 else cls(0.0, 0.0)


Course = Callable[[Four, Four], tuple[Four, Four, Four]]
"""From the thrusts now and those wanted to those at the beginning, the middle and the end of a step in which the wanted
stay as they are."""


def lagging(step: float, lag: float) -> Course:
    """Motors that follow with a first-order ``lag`` (s).

    Without a lag the thrusts jump at the beginning, and the step knows only the new ones.
    """
    half, full = MotorLag.over(step, lag)
    if full == 0.0:
        return lambda now, wanted: (wanted, wanted, wanted)

    def course(now: Four, wanted: Four) -> tuple[Four, Four, Four]:
        a0, a1, a2, a3 = now
        b0, b1, b2, b3 = wanted
        d0, d1, d2, d3 = a0 - b0, a1 - b1, a2 - b2, a3 - b3
        middle = (b0 + half * d0, b1 + half * d1, b2 + half * d2, b3 + half * d3)
        return (now, middle, (b0 + full * d0, b1 + full * d1, b2 + full * d2, b3 + full * d3))

    return course


def spinning(step: float, rotors: tuple[Rotor, ...], dynamics: RotorDynamics) -> Course:
    """The paper's rotors: I_rz Omega' = -b Omega |Omega| + tau, f = gamma Omega |Omega|, b = gamma / c.

    ``wanted`` are the thrusts to which the motors' torques tau = wanted / c lead in the end. Solved exactly.
    """
    gamma = dynamics.thrust_factor
    slowing = tuple(gamma * rotor.torque_per_thrust / dynamics.inertia for rotor in rotors)  # b / I_rz

    def course(now: Four, wanted: Four) -> tuple[Four, Four, Four]:
        later: tuple[list[float], list[float]] = ([], [])
        for thrust, goal, k in zip(now, wanted, slowing, strict=True):
            speed, aim = (math.copysign(math.sqrt(abs(x) / gamma), x) for x in (thrust, goal))
            for into, t in zip(later, (0.5 * step, step), strict=True):
                omega = _spun(speed, aim, k, t)
                into.append(gamma * omega * abs(omega))
        (a, b, c, d), (e, f, g, h) = later
        return (now, (a, b, c, d), (e, f, g, h))

    return course


def _spun(speed: float, aim: float, k: float, t: float) -> float:
    """Omega after ``t`` s of Omega' = k (aim |aim| - Omega |Omega|), from ``speed``. rad/s; k: 1/rad."""
    if speed < 0.0:
        return -_spun(-speed, -aim, k, t)
    if aim == 0.0:
        return speed / (1.0 + k * speed * t)
    if aim > 0.0:
        risen = math.tanh(k * aim * t)
        return aim * (speed + aim * risen) / (aim + speed * risen)
    until_rest = math.atan(speed / -aim)
    left = until_rest + k * aim * t
    return -aim * math.tan(left) if left > 0.0 else aim * math.tanh(-left)
