"""How many states the vehicle sends: each stamp counts once, however often it comes."""

from __future__ import annotations

import math
from dataclasses import dataclass

RATE_FIRST, RATE_OVER = 0.25, 0.5
"""s over which the rate of states is measured, first and from then on (engineering choice)."""


@dataclass(slots=True)
class StateCount:
    """``begun_at``: s by our clock, when the present measurement began. ``total``: states so far. ``rate``: Hz, None
    until measured."""

    begun_at: float
    total: int = 0
    rate: float | None = None
    _since: int = 0
    _newest: tuple[int, float] = (0, -math.inf)

    def is_new(self, t_boot: float, restarts: int) -> bool:
        """Whether a stamp (s) lies after all others of this run of the vehicle's clock, the ``restarts``-th."""
        if t_boot <= self._newest[1] and restarts == self._newest[0]:
            return False
        self._newest = (restarts, t_boot)
        return True

    def add(self, count: int, now: float) -> None:
        """So many new states by ``now`` (s). Measured from a state to a state, so that few are counted right too."""
        if not count:
            return
        if not self.total:
            self.begun_at, self.total = now, count
            return
        self.total += count
        self._since += count
        passed = now - self.begun_at
        if passed >= (RATE_FIRST if self.rate is None else RATE_OVER):
            self.rate = self._since / passed
            self._since, self.begun_at = 0, now
