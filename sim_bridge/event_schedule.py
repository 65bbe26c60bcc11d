"""The events of a world, by the clock: which last now, which have just happened."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from companion.world.events import (
    After,
    ClockJump,
    EstimatorReset,
    Event,
    Jump,
    LastingEvent,
    Operator,
    PayloadDrop,
    PortChange,
    When,
)

HAPPEN_ONCE = (PayloadDrop, EstimatorReset, ClockJump, Operator, PortChange)
ROUNDING = 1e-9
"""s that two sums of steps may differ by."""


class Marks(NamedTuple):
    """Plant time (s) of what events count from; None: it has not been yet."""

    armed: float | None = None
    offboard: float | None = None


class EventSchedule:
    """The events of one flight."""

    def __init__(self, events: Iterable[Event]) -> None:
        self._lasting: list[LastingEvent] = []
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

    def now(self, t: float, marks: Marks) -> list[LastingEvent]:
        """What lasts at ``t``, plant time in s."""
        return [event for event in self._lasting if _lasts(event.when, t, marks)]

    def take_due(self, t: float, marks: Marks) -> list[Jump]:
        """What has come due since the last time it was asked, in order of time."""
        due = [event for event in self._due if _lasts(event.when._replace(end=math.inf), t, marks)]
        self._due = [event for event in self._due if event not in due]
        return sorted(due, key=lambda event: event.when.begin)


def _lasts(when: When, t: float, marks: Marks) -> bool:
    since = 0.0 if when.after is After.START else marks.armed if when.after is After.ARMED else marks.offboard
    return since is not None and when.begin <= t - since + ROUNDING < when.end
