"""The rhythm in which states come: when the next one is due, and when to be ready for it.

A state that arrives at a processor which has slept for 4 ms finds its caches full of other work: the same tick takes
two to three times as long as right after another one. So the last tick is flown again, for nothing, a few times just
before the next state is due; and for the fraction of a millisecond that is left the link is asked again and again
instead of slept on.
"""

from __future__ import annotations

import math

PHASE_GAIN, PERIOD_GAIN, MEAN_GAIN = 0.2, 0.02, 0.05
"""What one arrival changes of the due time, of the period, of the other means."""
MARGIN = 8e-5
"""s that the last warm-up ends before a state is due, beside the usual deviation. Engineering choice."""
WATCH_MAX = 4e-4
"""s of asking the link without sleeping, at most: a tenth of a core at 250 Hz. Engineering choice."""
WARM_UPS = 4
"""The first finds everything cold, and one falls out where the waking is late; the third is as quick as it gets.
Engineering choice."""
WARM_UP_TIME_MAX = 0.25
"""Of the period, for all warm-ups. A machine on which not even one fits has no time for them. Engineering choice."""
REGULAR = 0.08
"""A rhythm is one while states keep to it within this share of the period, in the mean. Engineering choice."""
PERIOD_MIN, PERIOD_MAX = 5e-4, 0.1
"""s: what comes quicker is a burst, what comes slower needs no hurry. Engineering choice."""
ODD, ODD_MAX = 0.25, 20
"""States in a row that are out of step by so much of a period, or by periods, after which the rhythm is another one."""


class Rhythm:
    """Learns from arrivals (s, our clock). Not to be relied on: a state may come at any time."""

    def __init__(self) -> None:
        self._last = -math.inf
        self._due = -math.inf
        self._period = math.nan
        self._deviation = math.inf
        self._warm_up_time = 2e-4
        self._late = False
        self._odd = 0
        self.watch_until = -math.inf
        """Until when to ask the link without sleeping."""

    def add_arrival(self, now: float) -> None:
        """A state came."""
        late, self._late = self._late, False
        self.watch_until = -math.inf
        interval, self._last = now - self._last, now
        if math.isnan(self._period) or self._odd > ODD_MAX:
            self._period = interval if PERIOD_MIN < interval < PERIOD_MAX else math.nan
            self._deviation, self._due, self._odd = PERIOD_MAX, now + self._period, 0
            return
        off = -self._warm_up_time if late else now - self._due
        # a state that was lost, or a stall, leaves the rhythm as it is
        periods = round(off / self._period)
        off -= periods * self._period
        self._odd = self._odd + 1 if periods or abs(off) > ODD * self._period else 0
        self._due += (periods + 1) * self._period + PHASE_GAIN * off
        self._deviation += MEAN_GAIN * (abs(off) - self._deviation)
        self._period += PERIOD_GAIN * off

    def warm_up_at(self, now: float) -> float:
        """When to warm up next, ``now`` at the earliest; inf for not any more before the next state."""
        most = WARM_UP_TIME_MAX * self._period
        regular = self._deviation < REGULAR * self._period
        if not regular or self._warm_up_time > most:
            return math.inf
        end = self._due - self._deviation - MARGIN
        at = max(now, end - min(WARM_UPS * self._warm_up_time, most))
        return at if at + self._warm_up_time <= end else math.inf

    def add_warm_up(self, begun: float, ended: float) -> None:
        """A warm-up ran from ``begun`` to ``ended`` (s)."""
        self._warm_up_time += MEAN_GAIN * (ended - begun - self._warm_up_time)
        self.watch_until = min(self._due + 2.0 * self._deviation, ended + WATCH_MAX)

    def was_late(self) -> None:
        """Something was there already when a warm-up ended: it came while that went on."""
        self._late = True
