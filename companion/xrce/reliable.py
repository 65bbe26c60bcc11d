"""Reliable streams: each message once and in order, whatever the link loses. Two halves, of either side.

Numbers wrap at 2^16. PX4's client holds four messages a stream (its history), so that no more are under way.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.xrce.messages import Acknack, Heartbeat, Submessage

HISTORY = 4
"""Messages of a reliable stream that may be under way unacknowledged (uxrce_dds_client, STREAM_HISTORY)."""
WINDOW = 16
"""Messages ahead of the next one that are kept: as many as an ACKNACK has bits."""
HEARTBEAT_PERIOD = 0.03
"""s after which what was not acknowledged is announced again (engineering choice; the client gives a CREATE 1 s)."""
WAITING_MAX = 256
"""Submessages that wait to be sent: PX4 makes 197 objects in all, at most four messages of them at a time."""
NUMBERS = 1 << 16


def ahead(number: int, of: int) -> int:
    """How far a number lies ahead of another, 0 to 65535."""
    return (number - of) % NUMBERS


@dataclass(slots=True)
class Incoming:
    """What comes. ``first``: the next number."""

    first: int = 0
    _kept: dict[int, Sequence[Submessage]] = field(default_factory=dict)

    def receive(self, number: int, submessages: Sequence[Submessage]) -> list[Submessage]:
        """What can be read now that a message has come; nothing, where it came before or others are missing."""
        if ahead(number, self.first) < WINDOW:
            self._kept[number] = submessages
        read: list[Submessage] = []
        while self.first in self._kept:
            read += self._kept.pop(self.first)
            self.first = ahead(self.first + 1, 0)
        return read

    def acknack(self, last: int | None = None) -> Acknack:
        """What is here, and what is missing up to ``last``, the number of a HEARTBEAT. Nothing missing below it would
        tell the sender that all has come, and lose the message for good."""
        furthest = max((ahead(number, self.first) for number in self._kept), default=-1)
        if last is not None and ahead(last, self.first) < WINDOW:
            furthest = max(furthest, ahead(last, self.first))
        gaps = (bit for bit in range(furthest + 1) if ahead(self.first + bit, 0) not in self._kept)
        return Acknack(self.first, sum(1 << bit for bit in gaps))


@dataclass(slots=True)
class Outgoing:
    """What goes: at most HISTORY messages unacknowledged, the others wait. ``next_at``: s, when to say so again."""

    next_at: float = math.inf
    _number: int = 0
    _waiting: deque[Submessage] = field(default_factory=deque)
    _sent: dict[int, Submessage] = field(default_factory=dict)
    _again: list[int] = field(default_factory=list)

    @property
    def busy(self) -> bool:
        """Whether ``due`` has something to do: anything waits, or was under way when it was called last."""
        return bool(self._waiting) or self.next_at < math.inf

    def send(self, submessage: Submessage) -> None:
        """Have one sent. Where too many wait already, the other side does not listen, and it is left out."""
        if len(self._waiting) < WAITING_MAX:
            self._waiting.append(submessage)

    def take_acknack(self, acknack: Acknack) -> None:
        """What the other side has, and what it misses."""
        for number in [each for each in self._sent if 0 < ahead(acknack.first, each) <= HISTORY]:
            del self._sent[number]
        missing = (ahead(acknack.first + bit, 0) for bit in range(WINDOW) if acknack.missing >> bit & 1)
        self._again = [number for number in missing if number in self._sent]

    def due(self, now: float) -> tuple[list[tuple[int, Submessage]], Heartbeat | None]:
        """What is to be sent now, with its numbers, and what is to be said of what is under way."""
        messages = [(number, self._sent[number]) for number in self._again]
        self._again = []
        while self._waiting and len(self._sent) < HISTORY:
            self._sent[self._number] = self._waiting.popleft()
            messages.append((self._number, self._sent[self._number]))
            self._number = ahead(self._number + 1, 0)
        if not self._sent:
            self.next_at = math.inf
            return messages, None
        heartbeat = None
        if now >= self.next_at:
            heartbeat = Heartbeat(next(iter(self._sent)), next(reversed(self._sent)))
        if messages or heartbeat is not None:
            self.next_at = now + HEARTBEAT_PERIOD
        return messages, heartbeat
