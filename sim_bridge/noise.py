"""Chance, and chance that has a memory: processes of which the next value leans on the last, exact for any step.

Each process begins in its steady state, so that its statistics hold from the first step on.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Iterator
from itertools import chain

import numpy as np

Draw = Callable[[], float]
"""The next number of a standard normal distribution."""
DRAWN_AT_ONCE = 1024
"""random numbers drawn at a time, which is cheaper than one by one."""


class RandomStream(enum.IntEnum):
    """What chance is for. Each has its own source: a world with one more of them keeps the others as they were."""

    GUSTS = 0
    ESTIMATE = 1
    DOWN = 2
    UP = 3
    SAID = 4


def normals(seed: int, cause: RandomStream) -> Draw:
    """A source of normal numbers, the same for the same seed."""

    def drawn() -> Iterator[list[float]]:
        generator = np.random.default_rng((abs(seed), seed < 0, cause))
        while True:
            yield generator.standard_normal(DRAWN_AT_ONCE).tolist()

    return chain.from_iterable(drawn()).__next__


def first_order(a: float) -> tuple[float, float]:
    """Over ``a`` time constants: what is left of the value, and how much noise of unit variance is added to it."""
    return math.exp(-a), math.sqrt(-math.expm1(-2.0 * a))


class FirstOrder:
    """A first-order Gauss-Markov process of unit variance: x' = -x / time + noise."""

    __slots__ = ("_draw", "_keep", "_kick", "x")

    def __init__(self, draw: Draw, step: float, time: float) -> None:
        self._draw = draw
        self.set_step(step / time)
        self.x = draw()

    def set_step(self, a: float) -> None:
        """Let a step be ``a`` time constants from now on."""
        self._keep, self._kick = first_order(a)

    def update(self) -> float:
        """The value a step later."""
        self.x = x = self._keep * self.x + self._kick * self._draw()
        return x


class SecondOrder:
    """Two equal lags, one after the other: x' = -x / time + noise of unit variance, y' = (x - y) / time.

    In the steady state var x = 1, var y = cov xy = 1/2; what noise a step adds is what keeps these so.
    """

    __slots__ = ("_draw", "_keep", "_kick_x", "_kick_xy", "_kick_y", "_pass", "x", "y")

    def __init__(self, draw: Draw, step: float, time: float) -> None:
        self._draw = draw
        self.set_step(step / time)
        self.x = draw()
        self.y = 0.5 * self.x + 0.5 * draw()

    def set_step(self, a: float) -> None:
        """Let a step be ``a`` time constants from now on."""
        keep = math.exp(-a)
        square = keep * keep
        xx = -math.expm1(-2.0 * a)
        xy = 0.5 - square * (a + 0.5)
        yy = 0.5 - square * (a * a + a + 0.5)
        self._keep, self._pass = keep, keep * a
        self._kick_x = math.sqrt(xx)
        self._kick_xy = xy / self._kick_x
        self._kick_y = math.sqrt(max(0.0, yy - self._kick_xy * self._kick_xy))

    def update(self) -> None:
        """``x`` and ``y`` a step later."""
        noise = self._draw()
        self.y = self._keep * self.y + self._pass * self.x + self._kick_xy * noise + self._kick_y * self._draw()
        self.x = self._keep * self.x + self._kick_x * noise
