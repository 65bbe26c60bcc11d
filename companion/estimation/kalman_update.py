"""A measurement of one axis, in the step of ``kalman_step``: what the axis and q = (k, c) learn from it.

An axis is its state x, the covariance S of it given q, G = dx/dq, and sensitivities y = dx/dm, one for each of the
parameters m that are no states. All are numbers or symbols of a tape, and changed in place.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.calculus.scalar import Scalar

Matrix = list[list[Scalar]]
Moved = Matrix
"""What k and c have moved by in a step, and that over each of m."""
Seen = tuple[Scalar, ...]
"""Innovation, its variance, and how it goes with each of m."""


class Axis(NamedTuple):
    """One axis in the middle of a step: its state, S, G, and a column y for each of m."""

    x: list[Scalar]
    S: Matrix
    G: Matrix
    y: Matrix


def update(known: Axis, T: Matrix, moved: Moved, states: tuple[int, ...], measured: Scalar, noise: Scalar) -> Seen:
    """Innovation and variance of a measurement of the sum of ``states``; the axis, ``T`` and what q has ``moved`` by in
    this step are changed in place. The axis learns what it does given q, and q the rest."""
    x, S, G, y = known
    cross, slope, variance = _seen(known, states, noise)
    apart = _apart(known, states, measured)
    inverse = 1.0 / variance
    gains = [value * inverse for value in cross]
    for i, gain in enumerate(gains):
        for j in range(i, len(gains)):
            S[i][j] = S[j][i] = S[i][j] - gain * cross[j]
        for values, value in zip((x, *y), apart, strict=True):
            values[i] = values[i] + gain * value
        G[i] = [G[i][0] - gain * slope[0], G[i][1] - gain * slope[1]]
    by_q = [T[0][0] * slope[0] + T[0][1] * slope[1], T[1][0] * slope[0] + T[1][1] * slope[1]]
    whole = variance + (slope[0] * by_q[0] + slope[1] * by_q[1])
    residual, *by_m = (value - (slope[0] * by[0] + slope[1] * by[1]) for value, by in zip(apart, moved, strict=True))
    inverse = 1.0 / whole
    gain_k, gain_c = by_q[0] * inverse, by_q[1] * inverse
    for by, value in zip(moved, (residual, *by_m), strict=True):
        by[:] = by[0] + gain_k * value, by[1] + gain_c * value
    crossed = T[0][1] - gain_k * by_q[1]
    T[:] = [T[0][0] - gain_k * by_q[0], crossed], [crossed, T[1][1] - gain_c * by_q[1]]
    return residual, whole, *by_m


def update_frozen(
    known: Axis, T: Matrix, moved: Moved, states: tuple[int, ...], measured: Scalar, noise: Scalar
) -> Seen:
    """The same where q stays as it is, though not known: Joseph's form, with the gain of the axis as a whole."""
    x, S, G, y = known
    cross, slope, variance = _seen(known, states, noise)
    by_q = [T[0][0] * slope[0] + T[0][1] * slope[1], T[1][0] * slope[0] + T[1][1] * slope[1]]
    whole = variance + (slope[0] * by_q[0] + slope[1] * by_q[1])
    apart = residual, *by_m = _apart(known, states, measured)
    inverse = 1.0 / whole
    gains = [(value + (k * by_q[0] + c * by_q[1])) * inverse for value, (k, c) in zip(cross, G, strict=True)]
    half = [value - gain * (variance * 0.5) for value, gain in zip(cross, gains, strict=True)]
    for i, gain in enumerate(gains):
        for j in range(i, len(gains)):
            S[i][j] = S[j][i] = S[i][j] - (gain * half[j] + half[i] * gains[j])
        for values, value in zip((x, *y), apart, strict=True):
            values[i] = values[i] + gain * value
        G[i] = [G[i][0] - gain * slope[0], G[i][1] - gain * slope[1]]
    return residual, whole, *by_m


def _apart(known: Axis, states: tuple[int, ...], measured: Scalar) -> list[Scalar]:
    """What is measured of the sum of ``states`` beyond what is known of it, and that over each of m."""
    return [measured - _sum(known.x, states), *(_sum(column, states) * -1.0 for column in known.y)]


def _seen(known: Axis, states: tuple[int, ...], noise: Scalar) -> tuple[list[Scalar], tuple[Scalar, Scalar], Scalar]:
    """Of the sum of ``states``, given q: its covariance with each state, its slope by q, its variance as measured."""
    cross = [_sum(row, states) for row in known.S]
    slope = (_sum([row[0] for row in known.G], states), _sum([row[1] for row in known.G], states))
    return cross, slope, noise + _sum(cross, states)


def _sum(values: list[Scalar], states: tuple[int, ...]) -> Scalar:
    total: Scalar = 0.0
    for state in states:
        total = total + values[state]
    return total
