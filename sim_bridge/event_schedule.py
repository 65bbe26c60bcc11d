"""The events of a world, by the clock: which last now, which have just happened."""

from __future__ import annotations

from collections.abc import Iterable

from companion.world.events import ClockJump, EstimatorReset, Event, Happening, Jump, When

HAPPEN_ONCE = (EstimatorReset, ClockJump)
ROUNDING = 1e-9


class Script:
    """The events of one flight."""

    def __init__(self, events: Iterable[Event]) -> None:
        self._lasting: list[Happening] = []
        self._due: list[Jump] = []
        for event in events:
            self.add(event)

    def __bool__(self) -> bool:
        return bool(self._lasting or self._due)

    def add(self, event: Event) -> None:
        """One more."""
        if isinstance(event, HAPPEN_ONCE):
            self._due.append(event)
        else:
            self._lasting.append(event)

    def now(self, t: float, offboard_at: float | None) -> list[Happening]:
        """What lasts at ``t``; ``offboard_at``: when the first setpoint was flown in OFFBOARD. Plant time, s."""
        return [event for event in self._lasting if _lasts(event.when, t, offboard_at)]

    def happened(self, t: float, offboard_at: float | None) -> list[Jump]:
        """What has come due since the last time it was asked."""
        happened = [event for event in self._due if _lasts(event.when._replace(end=t + 1.0), t, offboard_at)]
        self._due = [event for event in self._due if event not in happened]
        return happened


def _lasts(when: When, t: float, offboard_at: float | None) -> bool:
    if when.after_offboard:
        if offboard_at is None:
            return False
        t -= offboard_at
    return when.begin <= t + ROUNDING < when.end
