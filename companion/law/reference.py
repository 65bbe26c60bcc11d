"""The path following manifold: the state and the inputs of a vehicle that flies the mission exactly (Lemma 4.4).

On the manifold V = mu(X) alpha(X) (Eq. 7) and psi = beta(X); everything else follows by differentiating along that flow
and by flatness. Lemma 4.4's map with its slips corrected, and with drag.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.calculus.scalar import Scalar, cos, sin
from companion.calculus.taylor import Gradient, Taylor
from companion.calculus.vectors import E3, ZERO, Rotation, Vector
from companion.frames import Heading
from companion.law.flatness import HeadingRate, body_acceleration, body_rates, torques
from companion.law.implicit import Position, Specification
from companion.law.motion import Model, Motion


@dataclass(frozen=True, slots=True)
class Reference:
    """A point of the path following manifold, in the paper's letters; world frame but for ``w`` and ``torque``."""

    X: Vector  # m
    V: Vector  # m/s
    A: Vector  # m/s^2
    J: Vector  # m/s^3
    S: Vector  # m/s^4
    R: Rotation  # R_nb
    w: Vector  # rad/s, body
    zeta: Scalar  # N
    zeta_dot: Scalar  # N/s
    zeta_ddot: Scalar  # N/s^2, the input there
    torque: Vector  # N m, body, the input there
    psi: Scalar  # rad


def flow(specification: Specification, X: Vector, order: int) -> tuple[Taylor, Taylor, Taylor]:
    """The motion X' = mu(X) alpha(X) from ``X`` as series in time, one coefficient from the ones before."""
    coefficients = [X.components()]
    for k in range(order):
        x, y, z = (Taylor(column) for column in zip(*coefficients, strict=True))
        mu = tangent(specification, (x, y, z))
        alpha = specification.alpha((x, y, z), mu)
        speed = [component * alpha for component in mu]
        a, b, c = ((v.c[k] if isinstance(v, Taylor) else v if k == 0 else 0.0) / (k + 1) for v in speed)
        coefficients.append((a, b, c))
    x, y, z = (Taylor(column) for column in zip(*coefficients, strict=True))
    return x, y, z


def tangent(specification: Specification, at: Position) -> Position:
    """mu (Eq. 7) at a point, or along a motion where the coordinates are series."""
    x, y, z = at
    seeded = (Gradient(x, (1.0, 0.0, 0.0)), Gradient(y, (0.0, 1.0, 0.0)), Gradient(z, (0.0, 0.0, 1.0)))
    grad1, grad2 = (Vector(*h.partials) for h in specification.h(seeded))
    normal = grad1.cross(grad2)
    mu: Vector = normal / normal.norm()
    return mu.components()


def reference_motion(specification: Specification, model: Model, X: Vector) -> Reference:
    """The point of the manifold over ``X``, a point of an implicit path."""
    series = flow(specification, X, 4)
    motion = [X, *(Vector(*(coordinate.derivative(k) for coordinate in series)) for k in (1, 2, 3, 4))]
    beta = specification.beta(series, tangent(specification, series))
    heading = [beta.derivative(k) if isinstance(beta, Taylor) else beta if k == 0 else 0.0 for k in (0, 1, 2)]
    return _flat(model, motion, heading, specification.heading)


def reference_over_arc(
    path: Sequence[Vector],
    alpha: Sequence[Scalar],
    beta: Sequence[Scalar],
    model: Model,
    kind: Heading,
    wind: Vector = ZERO,
) -> Reference:
    """The point of the manifold where the ``path`` has these derivatives over arc length (the point and four more), the
    speed ``alpha`` (three) and the yaw ``beta`` (two), which is a heading of this ``kind``: for any path, implicit or
    not. ``wind``: the steady velocity of the air, m/s, world frame."""
    a, a1, a2, a3 = alpha
    # s' = alpha(s), differentiated
    s1 = a
    s2 = a * a1
    s3 = a * (a1 * a1 + a * a2)
    s4 = a * (a1 * a1 * a1 + 4.0 * a * a1 * a2 + a * a * a3)
    c0, c1, c2, c3, c4 = path
    motion = [
        c0,
        c1 * s1,
        c2 * (s1 * s1) + c1 * s2,
        c3 * (s1 * s1 * s1) + c2 * (3.0 * s1 * s2) + c1 * s3,
        c4 * (s1 * s1 * s1 * s1) + c3 * (6.0 * s1 * s1 * s2) + c2 * (3.0 * s2 * s2 + 4.0 * s1 * s3) + c1 * s4,
    ]
    psi, b1, b2 = beta
    return _flat(model, motion, [psi, b1 * s1, b2 * s1 * s1 + b1 * s2], kind, wind)


def _flat(
    model: Model, derivatives: Sequence[Vector], heading: Sequence[Scalar], kind: Heading, wind: Vector = ZERO
) -> Reference:
    """Everything else by flatness, from X, V, A, J, S and psi with two time derivatives. Drag goes with V - ``wind``: a
    steady wind adds nothing to its derivatives."""
    X, V, A, J, S = derivatives
    psi, psi_dot, psi_ddot = heading
    force = (E3 * model.g - A - (V - wind) * model.c) * model.m
    zeta = force.norm()
    R = _rotation(force / zeta, psi, kind)
    rate = HeadingRate(R, kind)
    level = Motion(X, V, R, ZERO, zeta, 0.0, ZERO)
    zeta_dot, w = body_rates(model, level, J, A, psi_dot, rate, rate.by_r)
    motion = Motion(X, V, R, w, zeta, zeta_dot, ZERO)
    zeta_ddot, w_dot = body_acceleration(model, motion, S, J, psi_ddot, rate, rate.by_r)
    return Reference(X, V, A, J, S, R, w, zeta, zeta_dot, zeta_ddot, torques(model, w, w_dot), psi)


def _rotation(down: Vector, psi: Scalar, kind: Heading) -> Rotation:
    """R whose third column is ``down`` and whose heading is psi."""
    north, east = cos(psi), sin(psi)
    if kind is Heading.TWIST:
        # the level axis of that heading, swung as the short way from upright to ``down`` swings everything
        swung = (down.x * north + down.y * east) / (down.z + 1.0)
        forward = Vector(north - down.x * swung, east - down.y * swung, -(down.x * north + down.y * east))
        return Rotation(forward, down.cross(forward), down)
    forward = Vector(north, east, -(down.x * north + down.y * east) / down.z)
    forward = forward / forward.norm()
    return Rotation(forward, down.cross(forward), down)
