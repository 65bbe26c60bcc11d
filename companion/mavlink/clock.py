"""How late a state is: our clock against its stamp, over the best that this link has done.

    late = (now - t_boot) - best            best: the least of (now - t_boot), moved with the drift of the two clocks

A clock that runs fast lowers ``best`` by itself, with the states. One that runs slow must raise it, and that a growing
delay must not do. So it is raised only by what TIMESYNC proves: the vehicle answered after we asked, hence our clock
is ahead of its clock by ``sent - answered`` at least, whatever the way down takes. When that bound rises to where it
never was (which the least round trips show first), the clocks drift; a delay that grows either way only lowers it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

DRIFT_MAX = 0.06
"""s a second that the vehicle's clock may fall behind: PX4's simulator on a busy computer runs at 0.949 (px4.md, 0.10).
"""
DRIFT_UNPROVEN = 2e-4
"""s a second that is believed without TIMESYNC: twice what two crystals differ (engineering choice)."""
STOOD_FOR = 1.0
"""s of nothing but late states after which a vehicle that has not begun to fly was started anew: see ``restart``."""
LATE = 0.5
"""s: from here on a state counts as one of another clock while nothing flies."""
RATE_OVER, RATE_FIRST = 2.0, 0.1
"""s over which the rate of the vehicle's clock is taken, and after which it is known for the first time."""

BEHIND_FROM = 0.5
"""s a second from which on a clock may be one that falls behind; slower stamps have another unit (engineering choice).
"""


@dataclass(slots=True)
class VehicleClock:
    """One vehicle's clock. ``rate``: s of it a second of ours, None until measured; below 1 only as far as TIMESYNC
    proves it, since states that come later and later look the same. ``may_restart``: nothing flies, so
    a vehicle whose clock begins anew is taken again. ``restarts``: how often that was. ``may_stand``: a simulated
    vehicle whose clock stands until its first setpoint; what passes until then is no lateness."""

    rate: float | None = None
    may_restart: bool = True
    restarts: int = 0
    may_stand: bool = False
    _stands_at: float | None = None
    _best: float = math.inf
    _at: float = -math.inf
    _floor: float = -math.inf
    _floor_at: float = -math.inf
    _late_since: float | None = None
    _rate_from: tuple[float, float] | None = None
    _fallen: float = 0.0  # s a second that TIMESYNC proves it to fall behind
    _fallen_from: tuple[float, float] | None = None

    def late(self, t_boot: float, now: float) -> float:
        """s by which a state that arrives at ``now`` is older than the youngest this link has brought."""
        apart = now - t_boot
        if self.may_stand:
            if self._stands_at is None or t_boot == self._stands_at:
                self._stands_at, self._best, self._at = t_boot, apart, now
                return 0.0
            self.may_stand = False
        best = self._best + DRIFT_UNPROVEN * (now - self._at) if self._at > -math.inf else math.inf
        self._at = now
        if apart < best:
            if self._floor > -math.inf and best < math.inf:
                self._floor += apart - best
            best = apart
        self._best = best
        late = apart - best
        if late < LATE:
            self._late_since = None
        elif self._late_since is None:
            self._late_since = now
        elif self.may_restart and now - self._late_since > STOOD_FOR:
            self.restart()
            return self.late(t_boot, now)
        self._measure(t_boot, now)
        return late

    def restart(self) -> None:
        """Forget what was: the vehicle's clock began anew."""
        self.restarts += 1
        self._best, self._at = math.inf, -math.inf
        self._floor = self._floor_at = -math.inf
        self._late_since = self._rate_from = self._fallen_from = self.rate = None
        self._fallen = 0.0

    def synchronise(self, sent: float, answered: float, now: float) -> None:
        """TIMESYNC: asked at ``sent`` by our clock, answered at ``answered`` by the vehicle's, back at ``now``."""
        floor = sent - answered
        if self._fallen_from is None:
            self._fallen_from = (floor, now)
        elif now - self._fallen_from[1] >= RATE_OVER:
            self._fallen = max(0.0, (floor - self._fallen_from[0]) / (now - self._fallen_from[1]))
            self._fallen_from = (floor, now)
        if self._floor == -math.inf:
            self._floor, self._floor_at = floor, now
        elif floor > self._floor:
            rise = min(floor - self._floor, DRIFT_MAX * (now - self._floor_at))
            self._best += rise
            self._floor, self._floor_at = floor, now

    def _measure(self, t_boot: float, now: float) -> None:
        """How fast the vehicle's clock runs."""
        if self._rate_from is None:
            self._rate_from = (t_boot, now)
            return
        stamp, at = self._rate_from
        if now - at >= RATE_FIRST:
            rate = (t_boot - stamp) / (now - at)
            self.rate = max(rate, 1.0 - self._fallen) if BEHIND_FROM < rate < 1.0 else rate
            if now - at >= RATE_OVER:
                self._rate_from = (t_boot, now)
