"""The outputs of a curve given by a parametrisation: errors at the closest point, frame-free.

For any regular curve gamma(sigma), closed or open, in any parameter. The transverse error e = X - gamma is driven out
by its covariant derivatives in the normal bundle (what a Bishop frame measures; equal gains in both normal directions
make the frame itself unnecessary), the speed along the unit tangent T by those of T . V - alpha. Where a curve can also
be written as h1 = h2 = 0 with h1, h2 distances, the two laws are equal.

The closest point solves F = gamma' . e = 0; differentiating F gives the time derivatives of sigma (written sd, sdd, ..,
as every time derivative below). It is unique while Q = |gamma'|^2 - gamma'' . e > 0: within the curve's radius of
curvature. The paper's proof covers Jordan curves; of an open curve it covers nothing at the ends, which are phases of
the flight (hold) and never flown through by this law.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.calculus.scalar import Scalar, maximum
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Vector


@dataclass(frozen=True, slots=True)
class Closest:
    """The motion seen from the curve, in the order of the level (motors 4, rates 3).

    ``w``: the transverse error and its covariant derivatives w0 .. w_{n-1}; the next one is P S + ``cross`` (P J at the
    level of rates), P the projection normal to T. ``vT``: the speed along T and its derivatives; the next one is
    T . S + ``along``. ``T`` and its time derivatives. ``s``: arc length as a series in time, from the present.
    ``gamma``: the closest point as a series. ``Q``: over |gamma'|^2, 1 on the curve, 0 on its evolute.
    """

    w: tuple[Vector, ...]
    cross: Vector
    vT: tuple[Scalar, ...]
    along: Scalar
    T: tuple[Vector, ...]
    s: Taylor
    gamma: tuple[Taylor, Taylor, Taylor]
    Q: Scalar


def closest_point(derivatives: tuple[Vector, ...], motion: tuple[Vector, ...], q_min: float) -> Closest:
    """The motion (X, V, A) for the level of rates, (X, V, A, J) for that of motors, seen from the closest point.

    ``derivatives``: gamma, gamma', .. over the parameter there, one more than the motion has. ``q_min``: the least Q
    over |gamma'|^2 that is divided by; past the evolute the law then stays finite and points downhill.
    """
    gamma, g1, g2, g3, *rest = derivatives
    X, V, A, *jerk = motion
    e = X - gamma
    n2 = g1 @ g1
    n = g1.norm()
    Q = n2 - g2 @ e
    if q_min > 0.0:
        Q = maximum(Q, n2 * q_min)
    sd = (g1 @ V) / Q
    gd = g2 * sd
    ed = V - g1 * sd
    Qd = 2.0 * (g1 @ gd) - (g3 @ e) * sd - g2 @ ed
    sdd = (gd @ V + g1 @ A - sd * Qd) / Q
    gdd = g3 * (sd * sd) + g2 * sdd
    T = g1 / n
    nd = T @ gd
    Td = (gd - T * nd) / n
    ndd = Td @ gd + T @ gdd
    Tdd = (gdd - T * ndd - Td * (2.0 * nd)) / n
    vT, aT = T @ V, T @ A
    vTd = Td @ V + aT
    w0 = e - T * (T @ e)
    w1 = V - T * vT
    w2 = A - T * aT - Td * vT
    if not jerk:
        cross = -(Td * aT) - Td * vTd - Tdd * vT
        along = Tdd @ V + 2.0 * (Td @ A)
        s = Taylor((0.0, n * sd, 0.5 * (nd * sd + n * sdd)))
        where = _series(gamma, g1 * sd, g1 * sdd + gd * sd)
        return Closest((w0, w1, w2), projected(T, cross), (vT, vTd), along, (T, Td, Tdd), s, where, Q / n2)
    (J,), (g4,) = jerk, rest
    edd = A - gd * sd - g1 * sdd
    Qdd = 2.0 * (gd @ gd + g1 @ gdd) - (g4 @ e) * (sd * sd) - (g3 @ e) * sdd - 2.0 * (g3 @ ed) * sd - g2 @ edd
    sddd = (gdd @ V + 2.0 * (gd @ A) + g1 @ J - 2.0 * sdd * Qd - sd * Qdd) / Q
    gddd = g4 * (sd * sd * sd) + g3 * (3.0 * sd * sdd) + g2 * sddd
    nddd = Tdd @ gd + 2.0 * (Td @ gdd) + T @ gddd
    Tddd = (gddd - T * nddd - Td * (3.0 * ndd) - Tdd * (3.0 * nd)) / n
    aTd = Td @ A + T @ J
    vTdd = Tdd @ V + 2.0 * (Td @ A) + T @ J
    qv = -(Td * aT) - Td * vTd - Tdd * vT
    w3 = J + qv - T * (T @ (J + qv))
    cross = -(Td * aTd) - Tdd * aT - Td * vTdd - Tdd * (2.0 * vTd) - Tddd * vT - Td * (T @ (J + qv))
    along = Tddd @ V + 3.0 * (Tdd @ A) + 3.0 * (Td @ J)
    s = Taylor((0.0, n * sd, 0.5 * (nd * sd + n * sdd), (ndd * sd + 2.0 * nd * sdd + n * sddd) / 6.0))
    where = _series(gamma, g1 * sd, g1 * sdd + gd * sd)
    return Closest((w0, w1, w2, w3), cross, (vT, vTd, vTdd), along, (T, Td, Tdd, Tddd), s, where, Q / n2)


def _series(value: Vector, first: Vector, second: Vector) -> tuple[Taylor, Taylor, Taylor]:
    columns = zip(value.components(), first.components(), (second * 0.5).components(), strict=True)
    x, y, z = (Taylor(column) for column in columns)
    return x, y, z


def projected(T: Vector, vector: Vector) -> Vector:
    """P vector: its part normal to T."""
    result: Vector = vector - T * (T @ vector)
    return result
