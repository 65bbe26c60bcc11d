"""The law without a vehicle: a state in, the paper's matrices and inputs out. No limit, clamp, wrap or drag.

This is ``companion law``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from companion.calculus.straight import Function, Tape
from companion.calculus.vectors import ZERO, Rotation, Vector
from companion.frames import Heading, rotation_from_euler
from companion.law.errors import LawError
from companion.law.gains import Gains, Level
from companion.law.implicit import Specification
from companion.law.lie import linear_feedback, linearise, solve
from companion.law.motion import Model, Motion

SINGULAR = 1e-9
"""Cosine of phi and theta, N of zeta, sine of the angle between the gradients: how near to a singularity a state may
come before it is called singular. Engineering choice: a million times rounding."""


STATE_NAMES = ("x", "y", "z", "psi", "theta", "phi", "u", "v", "w", "p", "q", "r", "zeta", "zeta_dot")
"""The paper's order of the extended state. At the level of rates p, q, r and zeta_dot are missing."""


def state_names(level: Level) -> tuple[str, ...]:
    """The state of ``level`` in the paper's order."""
    if level is Level.MOTORS:
        return STATE_NAMES
    return tuple(name for name in STATE_NAMES if name not in ("p", "q", "r", "zeta_dot"))


@dataclass(frozen=True, slots=True)
class Answer:
    """What the law says at one state. ``inputs``: (zeta_ddot, u2, u3, u4) or (zeta_dot, p, q, r)."""

    xi: tuple[float, ...]
    b: tuple[float, ...]
    D: tuple[tuple[float, ...], ...]
    inputs: tuple[float, ...]


def bare_law(
    specification: Specification, level: Level, model: Model, gains: Gains
) -> Callable[[Sequence[float]], Answer]:
    """The law at ``level`` as a function of the extended state (``state_names``). It raises LawError."""
    matrices = _record_law(specification, level, model)
    names = state_names(level)

    def law(chi: Sequence[float]) -> Answer:
        state = dict(zip(names, chi, strict=True))
        psi, theta, phi, zeta = state["psi"], state["theta"], state["phi"], state["zeta"]
        if abs(zeta) < SINGULAR:
            raise LawError("singular: zeta = 0")
        if abs(math.cos(phi)) < SINGULAR:
            raise LawError("singular: phi = +-90 deg")
        if abs(math.cos(theta)) < SINGULAR:
            raise LawError("singular: theta = +-90 deg")
        r_nb = rotation_from_euler(psi, theta, phi)
        counted = psi if specification.heading is Heading.PROJECTED else specification.heading.of(r_nb)
        w = (state.get("p", 0.0), state.get("q", 0.0), state.get("r", 0.0), state.get("zeta_dot", 0.0))
        position = (state["x"], state["y"], state["z"], state["u"], state["v"], state["w"])
        try:
            values = matrices(*position, *r_nb, counted, *w, zeta)
        except ZeroDivisionError:
            raise LawError("singular: grad h1 and grad h2 are dependent here, or a division by zero") from None
        except (ValueError, OverflowError) as error:
            raise LawError(f"an expression is not defined here: {error}") from None
        if not all(map(math.isfinite, values)):
            raise LawError("an expression is not finite here")
        if values[-1] < SINGULAR:
            raise LawError("singular: grad h1 and grad h2 are dependent here")
        count = sum(level.degrees)
        xi, b = values[:count], values[count : count + 4]
        D = tuple(values[count + 4 + 4 * i : count + 8 + 4 * i] for i in range(4))
        try:
            inputs = solve(D, b, linear_feedback(gains, xi))
        except np.linalg.LinAlgError:
            raise LawError("singular: D has no inverse here") from None
        return Answer(xi, b, D, inputs)

    return law


def _record_law(specification: Specification, level: Level, model: Model) -> Function:
    """(X, V, R, psi, w, zeta_dot, zeta) -> xi, b, D row by row, and the sine between the gradients."""
    tape = Tape()
    X = Vector(*tape.inputs("x", "y", "z"))
    V = Vector(*tape.inputs("vx", "vy", "vz"))
    r = tape.inputs(*(f"r{i}{j}" for i in range(3) for j in range(3)))
    R = Rotation(Vector(r[0], r[3], r[6]), Vector(r[1], r[4], r[7]), Vector(r[2], r[5], r[8]))
    (psi,) = tape.inputs("psi")
    w = Vector(*tape.inputs("p", "q", "r"))
    zeta_dot, zeta = tape.inputs("zeta_dot", "zeta")
    motion = Motion(X, V, R, w, zeta, zeta_dot, ZERO)
    result = linearise(specification, level, model, motion, psi)
    grad1, grad2 = result.gradients
    sine = grad1.cross(grad2).norm() / (grad1.norm() * grad2.norm())
    return tape.function("matrices", [*result.xi, *result.b, *(entry for row in result.D for entry in row), sine])
