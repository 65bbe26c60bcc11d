"""The law one concept simpler: a point and a heading instead of a path.

All three directions are transverse, with the gains of h1; nothing runs along. Far away the errors are bounded one
inside the other: the distance (so that the point is approached at a steady speed), and the velocity beside the speed
that distance asks for (so that a vehicle which arrives fast brakes at a bounded acceleration).

    A-chain of the level:  X^(n) = -k_{n-1} X^(n-1) - .. - k_2 A - k_1 bounded(V + (k_0/k_1) bounded(X - X_0))
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.calculus.scalar import Scalar, maximum
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Vector
from companion.frames import Heading, Vec3
from companion.law.errors import LawError
from companion.law.feedback import Bounds, WantedDerivatives
from companion.law.flight import Command, Flying, place
from companion.law.gains import Gains, Level
from companion.law.motion import Model
from companion.law.recording import finish_step, inputs, known_motion
from companion.law.speed_scale import STANDSTILL

NO_SCALES = (STANDSTILL, 1.0)
"""Factors on the speed and on the path poles, which a point does not have. By definition."""
ACCELERATION_MAX = 4.0
"""m/s^2 of braking and of setting off. Engineering choice: 22 degrees of tilt."""


@dataclass(frozen=True, slots=True)
class HoldLaw:
    """The law that holds a point at one level."""

    step: Function

    def __call__(self, flying: Flying, point_n: Vec3, yaw: float) -> Command:
        """The command at a state. LawError: no thrust, or a state that is not finite."""
        p_n, v_n, r_nb, zeta, w_b, zeta_dot, disturbance, drag, *_ = flying
        if not zeta > 0.0:
            raise LawError(f"singular: thrust {zeta:.3g} N")
        values = self.step(p_n, v_n, r_nb, w_b, zeta, zeta_dot, disturbance, drag, *NO_SCALES, point_n, yaw)
        if not math.isfinite(sum(values)):
            raise LawError(f"the law is not finite at {place(p_n)}")
        return Command(values[0], values[1:4], values[4:7], *values[7:])


def hold_law(
    level: Level, model: Model, gains: Gains, bounds: Bounds | None, kind: Heading = Heading.PROJECTED
) -> HoldLaw:
    """Records the law that holds a point. Only the gains of h1 (all directions) and h4 are used."""
    tape = Tape()
    model, motion, _, _ = inputs(tape, model)
    X0 = Vector(*tape.tuple_input("px", "py", "pz"))
    (yaw,) = tape.inputs("yaw")
    _, V, A, *jerk = known_motion(level, model, motion)
    k0, k1, k2, *rest = gains.h1
    e = motion.X - X0
    if bounds is None:
        errors = -(V * k1) - e * k0
    else:
        towards = V + _within(e, bounds.path_error) * (k0 / k1)
        errors = -(_within(towards, ACCELERATION_MAX * k2 / k1) * k1)
    errors = errors - A * k2
    derivative = errors - jerk[0] * rest[0] if jerk else errors
    beta = Taylor((yaw, 0.0, 0.0))
    reported: tuple[Scalar, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
    wanted = WantedDerivatives(derivative, errors / k2)
    return HoldLaw(finish_step(tape, level, model, motion, gains, bounds, wanted, reported, beta, kind, 1.0))


def _within(vector: Vector, most: float) -> Vector:
    """``vector``, no longer than ``most``."""
    result: Vector = vector * (most / maximum(most, vector.norm()))
    return result
