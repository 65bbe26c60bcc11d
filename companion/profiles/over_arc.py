"""Functions of arc length, with the derivatives the law needs: from a formula, or in polynomial pieces."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor

Four = tuple[float, float, float, float]
"""A function and its first three derivatives over arc length."""
Array = NDArray[np.float64]


def over_arc(function: Callable[[Scalar], Scalar]) -> Function:
    """Records f(s) and its first three derivatives. ValueError, ArithmeticError: it is nowhere defined."""
    tape = Tape()
    (s,) = tape.inputs("s")
    value = function(Taylor((s, 1.0, 0.0, 0.0)))
    series = value if isinstance(value, Taylor) else Taylor((value, 0.0, 0.0, 0.0))
    return tape.function("over_arc", [series.derivative(k) for k in range(4)])


@dataclass(frozen=True)
class ArcProfile:
    """A C^3 function of arc length in polynomials of degree 7.

    ``knots``: m, rising. ``pieces``: coefficients in s - knot, highest power first. ``period``: m after which it comes
    again, ``gain`` higher (a heading may have turned); None: before the first and after the last knot it is constant.
    """

    knots: tuple[float, ...]
    pieces: tuple[tuple[float, ...], ...]
    period: float | None
    gain: float = 0.0

    def at(self, s: float) -> Four:
        """The function and its first three derivatives at arc length ``s``."""
        knots = self.knots
        added = 0.0
        if self.period is not None:
            rounds = (s - knots[0]) // self.period
            s -= rounds * self.period
            added = rounds * self.gain
        elif not knots[0] <= s <= knots[-1]:
            return (self.at(min(max(s, knots[0]), knots[-1]))[0], 0.0, 0.0, 0.0)
        i = min(max(bisect_right(knots, s) - 1, 0), len(self.pieces) - 1)
        x = s - knots[i]
        a, b, c, d, e, f, g, h = self.pieces[i]
        return (
            ((((((a * x + b) * x + c) * x + d) * x + e) * x + f) * x + g) * x + h + added,
            (((((7.0 * a * x + 6.0 * b) * x + 5.0 * c) * x + 4.0 * d) * x + 3.0 * e) * x + 2.0 * f) * x + g,
            ((((42.0 * a * x + 30.0 * b) * x + 20.0 * c) * x + 12.0 * d) * x + 6.0 * e) * x + 2.0 * f,
            (((210.0 * a * x + 120.0 * b) * x + 60.0 * c) * x + 24.0 * d) * x + 6.0 * e,
        )


# on [0, 1]: values and three derivatives at both ends -> coefficients, highest power first
_POWERS = np.arange(7, -1, -1)
_ENDS = np.array(
    [
        [
            np.prod(_POWERS[j] - np.arange(k)) * x ** max(int(_POWERS[j]) - k, 0) if _POWERS[j] >= k else 0.0
            for j in range(8)
        ]
        for x in (0.0, 1.0)
        for k in range(4)
    ]
)
"""A quintic's value and two derivatives at both ends, from its coefficients."""
_HERMITE = np.linalg.inv(_ENDS)


def hermite(knots: Sequence[float], values: Array, period: float | None = None, gain: float = 0.0) -> ArcProfile:
    """The profile with these ``values`` (rows: the function and its first three derivatives) at ``knots``."""
    s = np.array(knots, dtype=float)
    h = np.diff(s)
    scale = h ** np.arange(4)[:, None]
    ends = np.concatenate([values[:, :-1] * scale, values[:, 1:] * scale])
    coefficients = (_HERMITE @ ends) / h ** _POWERS[:, None]
    return ArcProfile(tuple(s.tolist()), tuple(map(tuple, coefficients.T.tolist())), period, gain)


def interpolated(
    s: Sequence[float], values: Sequence[float], period: float | None = None, gain: float = 0.0
) -> ArcProfile:
    """The profile through the samples of a table, monotone wherever they are: between two samples it leaves neither of
    them behind, so it is positive between positive ones.

    The slope at a sample is the gentler of its neighbours' (none at a peak), the two further derivatives are zero; then
    f' on an interval is >= 0 where the slopes at its ends add up to at most twice its mean. With ``period`` it closes.
    """
    knots, f = np.array(s, dtype=float), np.array(values, dtype=float)
    if period is not None:
        knots, f = np.append(knots, knots[0] + period), np.append(f, f[0] + gain)
    slopes = np.diff(f) / np.diff(knots)
    before = np.concatenate([[slopes[-1] if period is not None else 0.0], slopes])
    after = np.concatenate([slopes, [slopes[0] if period is not None else 0.0]])
    gentle = np.where(before * after > 0.0, np.sign(after) * np.minimum(np.abs(before), np.abs(after)), 0.0)
    flat = np.zeros_like(f)
    return hermite(knots.tolist(), np.stack([f, gentle, flat, flat]), period, gain)
