"""Linear error feedback, bounded (Eq. 9): from the outputs to the wanted highest derivative of the position.

The paper's feedback is not bounded; ``Bounds`` is a departure from it, needed by any machine with a largest thrust: far
from the path a linear law asks for a free fall or a somersault. Bounds touch only the terms on the errors themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.calculus.scalar import Scalar, maximum, minimum, sqrt, wrap
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Vector
from companion.law.closest import Closest, projected
from companion.law.gains import Gains, Level
from companion.law.implicit import Outputs
from companion.vehicle import Limits, Vehicle

BOUNDED_POLE = 5.5
"""1/s: up to such poles of h1 and h2 the whole path error of Bounds counts. Simulated on sih at -6: after a jump of
3 m the vehicle tilts by 45 deg, and by 50 if the whole counts."""
YAW_RETURN_RATE = 1.5
"""rad/s at which a heading error is turned out at most. Engineering choice."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """How large an error the law may see, and how hard it may turn the vehicle.

    ``path_error``: m; errors beyond are used as if they were this large. Simulated: with 1.5 the tilt stays below 43
    deg from 22 m off. ``speed_error``: m/s, likewise. ``yaw_return_rate``: rad/s at which a heading error is turned
    out. ``yaw_rate``: rad/s, the most at the level of rates, the heading's own turning included; the vehicle's limit.
    ``yaw_acceleration``: rad/s^2; holding a heading at a steep tilt must not take the thrust that carries the vehicle.
    Simulated at motors: without it a figure-eight at 4 m/s and 60 deg was lost on a mixer that gives yaw its full
    share; at rates the torque is limited where it is known (``steering.yaw``). ``yaw_divisor``: the least |R22| (of a
    twist, 1 + R22) used where the yaw channel divides by it (78 deg of tilt); the path is followed either way.
    ``q_min``: the least share of Q, the nearness of the evolute (see ``closest``). All engineering choices.
    """

    path_error: float = 1.5
    speed_error: float = 2.0
    yaw_return_rate: float = YAW_RETURN_RATE
    yaw_rate: float = Limits().body_rates[2]
    yaw_acceleration: float = 10.0
    yaw_divisor: float = 0.2
    q_min: float = 0.25


def bounds_of(vehicle: Vehicle, path_pole: float | None = None) -> Bounds | None:
    """Those of a vehicle; None where it has no limits. ``path_pole``: 1/s, of h1 and h2 where it was chosen: what an
    error at rest asks for grows with its square, so the error that counts shrinks."""
    if vehicle.limits is None:
        return None
    shrink = 1.0 if path_pole is None else min(1.0, (BOUNDED_POLE / path_pole) ** 2)
    return Bounds(path_error=shrink * Bounds().path_error, yaw_rate=vehicle.limits.body_rates[2])


def clamped(value: Scalar, limit: float) -> Scalar:
    """``value`` within +-limit."""
    return maximum(minimum(value, limit), -limit)


HEIGHT_SPEED = 3.0
"""m/s at which a height that has gains of its own is approached at most: with poles of -6 that of Bounds. Engineering
choice."""
HEIGHT_ACCELERATION = 5.0
"""m/s^2 that its error and speed may ask for: half of g, or the thrust that turns the vehicle would go. Engineering
choice: with 14 it did, half a meter above the path, and the vehicle tilted by 80 deg."""


@dataclass(frozen=True, slots=True)
class WantedDerivatives:
    """``derivative``: the snap (motors) or jerk (rates) that gives the errors their linear dynamics.

    ``missing``: m/s^2, what the acceleration lacks of the one the errors ask for: -(k_0 e + k_1 e')/k_2 - e'' for h1
    and h2, one order less for h3; zero on the path following manifold.
    """

    derivative: Vector
    missing: Vector


def linear(gains: Sequence[float], errors: Sequence[Scalar]) -> Scalar:
    """-k_0 e - k_1 e' - ... (Eq. 9)."""
    total: Scalar = 0.0
    for gain, error in zip(gains, errors, strict=True):
        total = total - error * gain
    return total


def lacking(gains: Sequence[float], errors: Sequence[Scalar], order: int) -> Scalar:
    """What the error's derivative of this ``order`` lacks of the one that the errors below it ask for."""
    return linear(gains[: order + 1], errors[: order + 1]) / gains[order]


def wanted_derivative(known: Outputs, level: Level, gains: Gains, bounds: Bounds | None) -> WantedDerivatives:
    """The snap (motors) or jerk (rates) that gives h1, h2, h3 their linear dynamics: the 3x3 solve

        [grad h1; grad h2; mu] S = v - drift

    in closed form, mu being normal to both gradients.
    """
    n1, _, n3, _ = level.degrees
    a, b, mu = known.grad1, known.grad2, known.mu
    area = a.cross(b).norm()
    across1, across2 = b.cross(mu) / area, mu.cross(a) / area
    errors1 = [known.h1.derivative(k) for k in range(n1)]
    errors2 = [known.h2.derivative(k) for k in range(n1)]
    errors3 = [known.h3.derivative(k) for k in range(n3)]
    if bounds is not None:
        offset: Vector = across1 * errors1[0] + across2 * errors2[0]
        shrink = bounds.path_error / maximum(bounds.path_error, offset.norm())
        errors1[0], errors2[0] = errors1[0] * shrink, errors2[0] * shrink
        errors3[0] = clamped(errors3[0], bounds.speed_error)
    v1 = linear(gains.h1, errors1) - known.h1.derivative(n1)
    v2 = linear(gains.h2, errors2) - known.h2.derivative(n1)
    v3 = linear(gains.h3, errors3) - known.h3.derivative(n3)
    a1, a2, a3 = lacking(gains.h1, errors1, 2), lacking(gains.h2, errors2, 2), lacking(gains.h3, errors3, 1)
    wanted = WantedDerivatives(mu * v3 + across1 * v1 + across2 * v2, mu * a3 + across1 * a1 + across2 * a2)
    if gains.vertical is None:
        return wanted
    used = across1.z * errors1[0] + across2.z * errors2[0]
    heights = [across1.z * known.h1.derivative(k) + across2.z * known.h2.derivative(k) for k in range(n1)]
    return with_vertical(wanted, mu, gains.h1, gains.vertical, heights, used, bounds)


def wanted_on_curve(
    seen: Closest, alpha: Taylor, level: Level, gains: Gains, bounds: Bounds | None
) -> WantedDerivatives:
    """The same from the transverse error and the speed error. ``alpha``: the wanted speed as a series in time."""
    _, _, n3, _ = level.degrees
    T = seen.T[0]
    used3 = [speed - alpha.derivative(k) for k, speed in enumerate(seen.vT)]
    offset = seen.w[0]
    if bounds is not None:
        offset = offset * (bounds.path_error / maximum(bounds.path_error, offset.norm()))
        used3[0] = clamped(used3[0], bounds.speed_error)
    across = (offset, *seen.w[1:])
    normal = linear_across(gains.h1, across) - seen.cross
    tangential = linear(gains.h3, used3) + alpha.derivative(n3) - seen.along
    missing = linear_across(gains.h1[:3], across[:3]) / gains.h1[2] + T * lacking(gains.h3, used3, 1)
    wanted = WantedDerivatives(projected(T, normal) + T * tangential, missing)
    if gains.vertical is None:
        return wanted
    return with_vertical(wanted, T, gains.h1, gains.vertical, [error.z for error in seen.w], offset.z, bounds)


def with_vertical(
    wanted: WantedDerivatives, tangent: Vector, gains: Sequence[float], vertical: Sequence[float],
    heights: Sequence[Scalar], used: Scalar, bounds: Bounds | None,
) -> WantedDerivatives:  # fmt: skip
    """``wanted`` by ``gains``, with ``vertical`` for the vertical part of the distance to the path in their place.

    ``heights``: that part and its derivatives, across ``tangent``: two at rates, three at motors; ``used``: m, as it
    was bounded for ``gains``. Exact on a level path. Where it slopes by g the vertical normal direction has what is
    between the two, by cos^2 g: with poles of gains: auto, the vertical ones up to twice as fast, all these have a
    damping of 0.65 at least.
    """
    k0, k1, k2, *rest = vertical
    e, speed, acceleration, *higher = heights
    if bounds is None:
        towards = -(e * k0 + speed * k1) / k2
    else:
        approached = clamped(e * (k0 / k1), HEIGHT_SPEED)
        towards = clamped(-(approached + speed) * (k1 / k2), HEIGHT_ACCELERATION)
    up = projected(tangent, Vector(0.0, 0.0, 1.0))
    usual = (used, speed, acceleration, *higher)
    missing = towards - acceleration
    derivative = missing * k2 + linear(rest, higher) - linear(gains, usual)
    return WantedDerivatives(
        wanted.derivative + up * derivative, wanted.missing + up * (missing - lacking(gains, usual, 2))
    )


def linear_across(gains: Sequence[float], errors: Sequence[Vector]) -> Vector:
    """``linear`` of vectors."""
    total = errors[0] * -gains[0]
    for gain, error in zip(gains[1:], errors[1:], strict=True):
        total = total - error * gain
    return total


def wanted_heading_acceleration(
    psi: Scalar, psi_dot: Scalar, beta: Taylor, gains: Gains, bounds: Bounds | None
) -> Scalar:
    """psi'' = beta'' - k_1 (psi' - beta') - k_0 wrap(psi - beta) (level of motors)."""
    error = wrap(psi - beta.derivative(0))
    if bounds is not None:
        error = clamped(error, bounds.yaw_return_rate * gains.h4[1] / gains.h4[0])
    return beta.derivative(2) + linear(gains.h4, (error, psi_dot - beta.derivative(1)))


def wanted_heading_rate(psi: Scalar, beta: Taylor, gains: Gains, bounds: Bounds | None) -> Scalar:
    """psi' = beta' - k_0 wrap(psi - beta) (level of rates)."""
    error = wrap(psi - beta.derivative(0))
    if bounds is not None:
        error = clamped(error, bounds.yaw_return_rate / gains.h4[0])
    return beta.derivative(1) + linear(gains.h4, (error,))


def yaw_divisor(by_r: Scalar, bounds: Bounds | None) -> Scalar:
    """What the yaw channel divides by (HeadingRate's by_r), kept away from zero with its sign."""
    if bounds is None:
        return by_r
    sign = by_r / maximum(sqrt(by_r * by_r), 1e-12)
    return sign * maximum(sqrt(by_r * by_r), bounds.yaw_divisor)
