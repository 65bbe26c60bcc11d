"""Arc length of a parametrised curve: its table, and the way from the parameter to arc length and back.

Between two knots the arc length is the integral of the polynomial through the speeds |gamma'| at six Gauss points. What
a path must be is found here: that it moves on everywhere, has no corner, and closes where it should.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.paths.arc import ArcTable
from companion.paths.tracing import LENGTH_MAX, PathError

Array = NDArray[np.float64]
Many = Callable[[Array], Array]

TURN_MAX = 0.3
"""rad of turning between two knots."""
STRAY_MAX = 1e-9
"""m between the curve and its table, below which a piece is good (engineering choice)."""
STRAY_RANGE = (1e-8, 1e-6)
"""How far the table may stray from the curve: this share of the path's length, within these bounds in m."""
KNOTS_MAX = 300_000
"""of one curve's table (engineering choice)."""
WIDTH_MIN = 1e-9
"""The least width of an interval over the whole range."""
CORNER = 0.5
"""rad of turning that no step is short enough for: a corner."""
CLOSED_WITHIN = 1e-6
"""m and relative: how well the ends of a closed curve must meet."""
SMOOTH_WITHIN = 1e-3
"""How well direction and bending (over the path's own scale) must agree where a closed curve meets itself."""
ROUNDING = 8.0 * float(np.finfo(float).eps)
"""Share of a parameter's size that its last digits are: what a derivative changes by over it is no jump. Engineering
choice: a polyline's last knots are sums, off by 1 to 3 last digits."""
NEWTON_STEPS = 12
"""at most, from arc length to parameter."""

_NODES, _WEIGHTS = (0.5 * np.polynomial.legendre.leggauss(6)[i] for i in (0, 1))
_NODES = _NODES + 0.5
# speeds at the nodes -> coefficients of the arc length over the share of the interval, powers 6..1
_TO_ARC = np.linalg.inv(np.vander(_NODES, 6)) / np.arange(6.0, 0.0, -1.0)[:, None]


@dataclass(frozen=True)
class ArcMap:
    """``parameters``: at the table's knots. ``arcs``: for each interval the coefficients of the arc length over the
    share of the interval passed, powers 6..1."""

    parameters: tuple[float, ...]
    arcs: tuple[tuple[float, float, float, float, float, float], ...]

    def arc(self, u: float, knots: tuple[float, ...]) -> float:
        """The arc length at parameter ``u``; ``knots`` are the table's."""
        i = min(max(bisect_right(self.parameters, u) - 1, 0), len(self.arcs) - 1)
        begin = self.parameters[i]
        t = (u - begin) / (self.parameters[i + 1] - begin)
        a, b, c, d, e, f = self.arcs[i]
        return knots[i] + (((((a * t + b) * t + c) * t + d) * t + e) * t + f) * t

    def parameter(self, s: float, knots: tuple[float, ...]) -> float:
        """The parameter at arc length ``s``."""
        i = min(max(bisect_right(knots, s) - 1, 0), len(self.arcs) - 1)
        a, b, c, d, e, f = self.arcs[i]
        wanted = s - knots[i]
        t = wanted / (knots[i + 1] - knots[i])
        for _ in range(NEWTON_STEPS):
            passed = (((((a * t + b) * t + c) * t + d) * t + e) * t + f) * t
            speed = ((((6.0 * a * t + 5.0 * b) * t + 4.0 * c) * t + 3.0 * d) * t + 2.0 * e) * t + f
            step = (wanted - passed) / speed
            t += step
            if abs(step) < 1e-14:
                break
        begin = self.parameters[i]
        return begin + t * (self.parameters[i + 1] - begin)


def measured(many: Many, begin: float, end: float, closed: bool, breaks: tuple[float, ...]) -> tuple[ArcTable, ArcMap]:
    """The table of gamma over [begin, end] and the map of its parameter. ``breaks``: parameters an interval must not
    straddle. PathError: the curve stops, has a corner, is not defined, or should be closed and is not."""
    joins = np.array(sorted({begin, end, *(b for b in breaks if begin < b < end)}))
    # a first look fine enough that a table's interval cannot hide a whole turn
    parts = max(1, math.ceil(24 / (len(joins) - 1)))
    edges = np.concatenate([np.linspace(a, b, parts + 1)[:-1] for a, b in itertools.pairwise(joins)])
    pending, done = np.stack([edges, [*edges[1:], end]], axis=1), []
    count, tolerance = 0, 0.0
    while len(pending):
        part = _Part(many, pending)
        if tolerance == 0.0:
            tolerance = float(np.clip(STRAY_MAX * part.lengths.sum(), *STRAY_RANGE))
        good = part.good(tolerance)
        tiny = ~good & (pending[:, 1] - pending[:, 0] < WIDTH_MIN * (end - begin))
        for i in np.flatnonzero(tiny):
            if part.turned[i] > CORNER:
                raise PathError(f"has a corner at {_place(part.points[i, 0])}; expected a smooth curve")
        kept = good | tiny
        done.append(part.kept(kept))
        count += int(kept.sum())
        halved = pending[~kept]
        middle = halved.mean(axis=1)
        pending = np.concatenate([np.stack([halved[:, 0], middle], 1), np.stack([middle, halved[:, 1]], 1)])
        if count + len(pending) > KNOTS_MAX or sum(float(d.lengths.sum()) for d in done) > LENGTH_MAX:
            raise PathError(f"is longer than {LENGTH_MAX / 1000:g} km, or turns too often")
    table, arc_map = _assemble(done, end, closed)
    if table.length > LENGTH_MAX:
        raise PathError(f"is longer than {LENGTH_MAX / 1000:g} km")
    if closed:
        _check_closing(many, begin, end, table.length)
    return table, arc_map


@dataclass(frozen=True)
class _Intervals:
    """Finished intervals: where each begins, its length, its quintic (3 x 6) and its arc polynomial."""

    begins: Array
    lengths: Array
    quintics: Array
    arcs: Array


class _Part:
    """Some intervals of the curve, evaluated."""

    def __init__(self, many: Many, edges: Array) -> None:
        self.edges = edges
        self.width = edges[:, 1] - edges[:, 0]
        shares = np.concatenate([[0.0], _NODES, [1.0]])
        at = edges[:, :1] + shares * self.width[:, None]
        at[:, -1] = edges[:, 1]
        values = many(at.ravel()).reshape(5, 3, *at.shape)[:3]
        bad = ~np.isfinite(values).all(axis=(0, 1))
        if bad.any():
            raise PathError(f"is not defined, or not finite, at u = {at[bad][0]:.6g}")
        gamma, g1, g2 = (np.moveaxis(v, 0, -1) for v in values)  # intervals x nodes x 3
        speed = np.linalg.norm(g1, axis=-1)
        scale = max(float(np.max(speed)), 1e-300)
        stops = speed < max(1e-6 * scale, 1e-9)
        if stops.any():
            where, u = gamma[stops][0], at[stops][0]
            raise PathError(f"stops at {_place(where)} (u = {u:.4g}); expected a curve that always moves on")
        self.points = gamma
        tangent = g1 / speed[..., None]
        along = np.sum(g2 * tangent, axis=-1)
        bend = (g2 - along[..., None] * tangent) / speed[..., None] ** 2
        self.arcs = (speed[:, 1:-1] @ _TO_ARC.T) * self.width[:, None]
        self.lengths = self.arcs.sum(axis=1)
        cosines = np.clip(np.sum(tangent[:, 1:] * tangent[:, :-1], axis=-1), -1.0, 1.0)
        self.turned = np.arccos(cosines).sum(axis=1)
        ends = [gamma[:, i] for i in (0, -1)], [tangent[:, i] for i in (0, -1)], [bend[:, i] for i in (0, -1)]
        self.quintics = _quintics(*ends, self.lengths)
        # the polynomial of the speed, seen at the ends it was not made from
        fit = speed[:, 1:-1] @ np.linalg.inv(np.vander(_NODES, 6)).T
        self.missed = np.abs(fit @ np.vander(np.array([0.0, 1.0]), 6).T - speed[:, [0, -1]]).max(axis=1)
        self.speed = speed.mean(axis=1)

    def good(self, tolerance: float) -> NDArray[np.bool_]:
        """Which intervals are short enough: little turning, the table within ``tolerance`` m, the arc length exact."""
        s = self._arc_at(_NODES)
        on_table = np.einsum("ijp,icp->ijc", s[..., None] ** np.arange(5, -1, -1), self.quintics)
        stray = np.linalg.norm(on_table - self.points[:, 1:-1], axis=-1).max(axis=1)
        rounding = 1e-12 * np.linalg.norm(self.points[:, 0], axis=-1)
        result: NDArray[np.bool_] = (
            (self.turned < TURN_MAX) & (stray < tolerance + rounding) & (self.missed < 1e-5 * self.speed)
        )
        return result

    def _arc_at(self, shares: Array) -> Array:
        result: Array = self.arcs @ (shares[:, None] ** np.arange(6, 0, -1)).T
        return result

    def kept(self, which: NDArray[np.bool_]) -> _Intervals:
        """The intervals that are done."""
        return _Intervals(self.edges[which, 0], self.lengths[which], self.quintics[which], self.arcs[which])


def _quintics(points: list[Array], tangents: list[Array], bends: list[Array], lengths: Array) -> Array:
    """For each interval and coordinate the quintic in arc length through both ends, highest power first."""
    h = lengths[:, None]
    d = points[1] - points[0]
    v0, v1 = tangents[0] * h, tangents[1] * h
    a0, a1 = 0.5 * bends[0] * h * h, 0.5 * bends[1] * h * h
    coefficients = (
        (6.0 * d - 3.0 * (v0 + v1) - a0 + a1) / h**5,
        (-15.0 * d + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1) / h**4,
        (10.0 * d - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1) / h**3,
        0.5 * bends[0],
        tangents[0],
        points[0],
    )
    return np.stack(coefficients, axis=-1)


def _assemble(done: list[_Intervals], end: float, closed: bool) -> tuple[ArcTable, ArcMap]:
    begins = np.concatenate([d.begins for d in done])
    order = np.argsort(begins)
    lengths = np.concatenate([d.lengths for d in done])[order]
    quintics = np.concatenate([d.quintics for d in done])[order]
    arcs = np.concatenate([d.arcs for d in done])[order]
    knots = (0.0, *np.cumsum(lengths).tolist())
    pieces = tuple((tuple(x), tuple(y), tuple(z)) for x, y, z in quintics.tolist())
    parameters = (*begins[order].tolist(), end)
    return ArcTable(knots, pieces, closed), ArcMap(parameters, tuple(map(tuple, arcs.tolist())))


def _check_closing(many: Many, begin: float, end: float, length: float) -> None:
    # on a long path of short bends the parameter's rounding alone moves the higher derivatives, at length^4
    inside = ROUNDING * max(abs(begin), abs(end))
    values = many(np.array([begin, end, begin + inside, end - inside]))
    first, last = values[:, :, 0], values[:, :, 1]
    gap = float(np.linalg.norm(first[0] - last[0]))
    if gap > CLOSED_WITHIN * max(1.0, length):
        raise PathError(f"does not close: its ends are {gap:.3g} m apart")
    here, there, *beside = np.moveaxis(over_arc(values), -1, 0)
    names = ("", "a corner", "a sudden bend", "a bend that changes suddenly", "a bend whose change changes suddenly")
    for k in range(1, 5):
        scale = (length / math.tau) ** (k - 1)
        size = 1.0 + scale * float(np.linalg.norm(here[k]))
        rounding = sum(float(np.linalg.norm(a[k] - b[k])) for a, b in zip((here, there), beside, strict=True))
        if scale * (float(np.linalg.norm(here[k] - there[k])) - rounding) > SMOOTH_WITHIN * size:
            raise PathError(
                f"has {names[k]} where it closes; expected the two ends to go over into each other smoothly"
            )


def over_arc(derivatives: Array) -> Array:
    """gamma and four derivatives over arc length, from those over a parameter; both (5, 3) or (5, 3, n)."""
    g = derivatives
    n2 = np.sum(g[1] * g[1], axis=0)
    n = np.sqrt(n2)
    # u(s) is the inverse of s(u), whose derivatives are those of the speed n
    n_1 = np.sum(g[1] * g[2], axis=0) / n
    n_2 = (np.sum(g[2] * g[2] + g[1] * g[3], axis=0) - n_1 * n_1) / n
    n_3 = (np.sum(3.0 * g[2] * g[3] + g[1] * g[4], axis=0) - 3.0 * n_1 * n_2) / n
    u1 = 1.0 / n
    u2 = -n_1 / n**3
    u3 = (3.0 * n_1 * n_1 - n * n_2) / n**5
    u4 = (10.0 * n * n_1 * n_2 - n * n * n_3 - 15.0 * n_1**3) / n**7
    return np.stack(
        [
            g[0],
            g[1] * u1,
            g[2] * u1**2 + g[1] * u2,
            g[3] * u1**3 + 3.0 * g[2] * u1 * u2 + g[1] * u3,
            g[4] * u1**4 + 6.0 * g[3] * u1**2 * u2 + g[2] * (3.0 * u2 * u2 + 4.0 * u1 * u3) + g[1] * u4,
        ]
    )


def _place(p: Array) -> str:
    x, y, z = map(float, p)
    return f"x {x:z.2f}, y {y:z.2f}, z {z:z.2f}"
