"""``speed: auto``: the fastest profile that keeps every limit of the vehicle, with a margin.

The square of the speed is a quintic spline over arc length, so that alpha is C^3 and more; its knots lie a fixed time
apart at the speed that bends and accelerations alone would allow. A first profile takes that speed, lowered and
smoothed until every limit is kept. From there Newton's method on a barrier shortens the time: minimise

    time - mu sum log(1 - used),        mu going down to 1/500,

where `used` are the shares of all limits at places between the knots, on the exact reference with drag. The demand at a
place depends on the speed there and three derivatives, so a step costs no more than the path is long.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, minimum_filter1d
from scipy.sparse import csc_matrix, diags_array
from scipy.sparse.linalg import splu

from companion.feasibility.arc_spline import ArcSpline
from companion.feasibility.headroom import SPEED_MIN, Headroom, TooSlowError
from companion.feasibility.stations import places, stations_along
from companion.mission import Mission
from companion.profiles import AutoSpeed, SpeedProfile, hermite
from companion.vehicle import Vehicle

Array = NDArray[np.float64]

KNOT_TIME = 0.12
"""s between two knots."""
KNOTS_MIN, KNOTS_MAX = 12, 6000
"""A path with more knots than this (a flight of twelve minutes) is flown with the first profile, some 10 % slower."""
PER_KNOT = 3
"""Places between two knots."""
BARRIER_FIRST = 0.05
"""weight of the barrier to begin with."""
BARRIER_STEP = 0.1
"""factor from one weight to the next."""
BARRIER_LAST = 0.002
"""the last weight (see the module)."""
NEWTON_STEPS = 40
"""at most, at one weight of the barrier."""
CONVERGED = 0.1
"""What another Newton's step would gain, over the weight of the barrier."""
EXCESS_MAX = 1.004
"""What may be used between the places looked at, over the margin."""
SMOOTHING = np.array([1.0, 2.0, 3.0, 2.0, 1.0]) / 9.0
"""weights of five neighbouring knots: a triangle."""
LOWERINGS = 60
"""attempts at most to keep every limit."""


class Fastest:
    """The search for one mission and one vehicle. ``knot_time``: s.

    ``at``: the places along the path, ``ds`` m apart, at which every limit is kept. ``matrices``: from coefficients to
    the squared speed and its three derivatives there. ``steady``: m/s that could be flown there without end.
    """

    def __init__(self, mission: Mission, auto: AutoSpeed, vehicle: Vehicle, knot_time: float = KNOT_TIME) -> None:
        self._mission = mission
        self.headroom = Headroom(vehicle, auto, None if mission.closed else (0.0, mission.table.length))
        self._everywhere = stations_along(mission, places(mission))
        s = self._everywhere.s
        steady = self.headroom.steady(self._everywhere)
        passed = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (steady[1:] + steady[:-1]))])
        knots = max(KNOTS_MIN, math.ceil(passed[-1] / knot_time)) + 1
        self.spline = ArcSpline(
            np.interp(np.linspace(0.0, passed[-1], knots), passed, s),
            mission.table.length if mission.closed else None,
        )
        widths = np.diff(self.spline.knots)
        shares = (np.arange(PER_KNOT) + 0.5) / PER_KNOT
        self.at = stations_along(mission, (self.spline.knots[:-1, None] + shares * widths[:, None]).ravel())
        self.ds = np.repeat(widths / PER_KNOT, PER_KNOT)
        self.steady = np.interp(self.at.s, s, steady)
        self._at_sites = np.interp(self.spline.sites, s, steady)
        self._weight = self.ds / self.steady
        self.matrices = self.spline.matrices(self.at.s)

    def profile(self) -> SpeedProfile:
        """The speed along the path, with the sign of its direction. TooSlowError: none is slow enough."""
        coefficients = self.first()
        if len(self.spline.knots) <= KNOTS_MAX:
            coefficients = self.improve(coefficients)
        everywhere = self.spline.matrices(self._everywhere.s)
        for _ in range(LOWERINGS):
            alpha = speeds([matrix @ coefficients for matrix in everywhere])
            if float(self.headroom.used(self._everywhere, alpha).max()) <= EXCESS_MAX:
                break
            coefficients = coefficients * 0.997
        knots = self.spline.knots
        at_knots = speeds([matrix @ coefficients for matrix in self.spline.matrices(knots)])
        return SpeedProfile(hermite(knots.tolist(), at_knots * self.headroom.auto.direction, self.spline.period))

    def first(self) -> Array:
        """Coefficients that keep every limit: the steady speed smoothed, and lowered where a limit is passed."""
        mode = "wrap" if self.spline.period is not None else "nearest"

        def smoothed(values: Array, width: int) -> Array:
            result: Array = convolve1d(minimum_filter1d(values, width, mode=mode), SMOOTHING, mode=mode)
            return result

        coefficients = smoothed(self._at_sites**2, 5)
        seen = (self.matrices[0] != 0).T.tocsr()  # coefficient -> the places where it has a say
        for _ in range(LOWERINGS):
            used = self._used(coefficients).max(axis=0)
            if float(used.max()) < 0.98:
                return coefficients
            worst = np.maximum.reduceat(used[seen.indices], seen.indptr[:-1])
            lower = np.where(worst > 0.95, np.sqrt(0.93 / np.minimum(worst, 5.0)), 1.0)
            coefficients = coefficients * smoothed(lower, 3)
            if float(coefficients.min()) < SPEED_MIN**2:
                break
        i = int(np.argmax(used))
        raise TooSlowError(f"no speed is slow enough for this vehicle at {self.at.s[i]:.1f} m along the path")

    def improve(self, coefficients: Array) -> Array:
        """Coefficients of the fastest profile, from ones that keep every limit."""
        mu = BARRIER_FIRST
        while True:
            for _ in range(NEWTON_STEPS):
                gradient, curvature = self._newton(coefficients, mu)
                step = -splu(curvature).solve(gradient)
                gain = -float(gradient @ step)
                value = self._value(coefficients, mu)
                size = 1.0
                while self._value(coefficients + size * step, mu) > value - 0.1 * size * gain and size > 1e-6:
                    size *= 0.5
                if size <= 1e-6:
                    break
                coefficients = coefficients + size * step
                if gain < CONVERGED * mu * float(self._weight.sum()):
                    break
            if mu <= BARRIER_LAST:
                return coefficients
            mu = max(mu * BARRIER_STEP, BARRIER_LAST)

    def time(self, coefficients: Array) -> float:
        """s along the whole path."""
        return float(np.sum(self.ds / np.sqrt(self.matrices[0] @ coefficients)))

    def slopes(self, y: Array, used: Array) -> Array:
        """Derivatives of the shares ``used`` over the squared speed and its three derivatives: (4, limits, places)."""
        slopes = []
        for k in range(4):
            h = 1e-6 * y[0] / self.steady**k  # a change that takes about a second
            nudged = y.copy()
            nudged[k] += h
            slopes.append((self.headroom.used(self.at, speeds(nudged)) - used) / h)
        return np.stack(slopes)

    def _used(self, coefficients: Array) -> Array:
        return self.headroom.used(self.at, speeds([matrix @ coefficients for matrix in self.matrices]))

    def _value(self, coefficients: Array, mu: float) -> float:
        if float((self.matrices[0] @ coefficients).min()) <= SPEED_MIN**2:
            return math.inf
        left = 1.0 - self._used(coefficients)
        if float(left.min()) <= 0.0:
            return math.inf
        return self.time(coefficients) - mu * float(np.sum(self._weight * np.log(left)))

    def _newton(self, coefficients: Array, mu: float) -> tuple[Array, csc_matrix]:
        """Gradient and curvature of the value; of the limits' own curvature nothing, they are nearly convex."""
        y = np.stack([matrix @ coefficients for matrix in self.matrices])
        used = self.headroom.used(self.at, speeds(y))
        left = 1.0 - used
        pressed = self.slopes(y, used) / left  # derivative x limit x place
        weight = mu * self._weight
        gradients = weight * pressed.sum(axis=1)
        gradients[0] -= 0.5 * self.ds * y[0] ** -1.5
        curvatures = weight * np.einsum("kjn,ljn->kln", pressed, pressed)
        curvatures[0, 0] += 0.75 * self.ds * y[0] ** -2.5
        gradient = sum(matrix.T @ g for matrix, g in zip(self.matrices, gradients, strict=True))
        total = csc_matrix((self.spline.count, self.spline.count))
        for k in range(4):
            rows = diags_array(curvatures[k, k]) @ self.matrices[k] * 0.5
            for i in range(k + 1, 4):
                rows = rows + diags_array(curvatures[k, i]) @ self.matrices[i]
            half = self.matrices[k].T @ rows
            total = total + half + half.T
        return gradient, csc_matrix(total + diags_array(1e-9 * total.diagonal()))


def speeds(squares: Sequence[Array] | Array) -> Array:
    """alpha and three derivatives over s, from alpha^2 and its three."""
    b, b1, b2, b3 = squares
    a = np.sqrt(np.maximum(b, 1e-12))
    a1 = 0.5 * b1 / a
    a2 = (0.5 * b2 - a1 * a1) / a
    a3 = (0.5 * b3 - 3.0 * a1 * a2) / a
    return np.stack([a, a1, a2, a3])
