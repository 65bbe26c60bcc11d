"""The stream on which each message arrives once and in order: both ends of one client's."""

from __future__ import annotations

from companion.xrce.messages import Acknack, Heartbeat, Submessage

HISTORY = 4
"""messages that either end keeps (PX4's STREAM_HISTORY)."""
NUMBERS = 1 << 16
"""Sequence numbers begin again after so many."""
HEARTBEAT_US = 100_000
"""us between two heartbeats while something is not acknowledged (the client's default)."""


def ahead(of: int, number: int) -> int:
    """How far a sequence number is ahead of another; negative: behind it."""
    gap = (number - of) % NUMBERS
    return gap if gap <= NUMBERS // 2 else gap - NUMBERS


class ReliableOut:
    """What we send. ``is_full``: nothing more may be sent before something is acknowledged."""

    def __init__(self) -> None:
        self._first = self._next = 0
        self._kept: dict[int, bytes] = {}
        self._heartbeat_at_us: int | None = None

    @property
    def next_number(self) -> int:
        """The sequence number of the next message."""
        return self._next

    @property
    def is_full(self) -> bool:
        return ahead(self._first, self._next) >= HISTORY

    def keep(self, datagram: bytes) -> None:
        """The datagram with the next number is sent."""
        self._kept[self._next] = datagram
        self._next = (self._next + 1) % NUMBERS

    def heartbeat(self, now_us: int) -> Heartbeat | None:
        """What is due to be said of what has not been acknowledged."""
        if self._first == self._next:
            self._heartbeat_at_us = None
        elif self._heartbeat_at_us is None:
            self._heartbeat_at_us = now_us + HEARTBEAT_US
        elif now_us >= self._heartbeat_at_us:
            self._heartbeat_at_us = now_us + HEARTBEAT_US
            return Heartbeat(self._first, (self._next - 1) % NUMBERS)
        return None

    def take(self, said: Acknack) -> list[bytes]:
        """What the other end has; the datagrams to send again."""
        if 0 <= ahead(self._first, said.first) <= ahead(self._first, self._next):
            while self._first != said.first:
                self._kept.pop(self._first, None)
                self._first = (self._first + 1) % NUMBERS
        missing = [(said.first + bit) % NUMBERS for bit in range(16) if said.missing >> bit & 1]
        return [self._kept[number] for number in missing if number in self._kept]


class ReliableIn:
    """What the agent sends."""

    def __init__(self) -> None:
        self._handled = self._announced = NUMBERS - 1
        self._waiting: dict[int, tuple[Submessage, ...]] = {}

    def take(self, number: int, submessages: tuple[Submessage, ...]) -> list[Submessage]:
        """A message came: what there is to read now, in order."""
        if 0 < ahead(self._handled, number) <= HISTORY:
            self._waiting[number] = submessages
        self._announce(number)
        ready: list[Submessage] = []
        while (following := (self._handled + 1) % NUMBERS) in self._waiting:
            ready += self._waiting.pop(following)
            self._handled = following
        return ready

    def hear(self, said: Heartbeat) -> None:
        """What the agent says it has sent."""
        self._announce(said.last)

    def _announce(self, number: int) -> None:
        if ahead(self._announced, number) > 0:
            self._announced = number

    @property
    def acknack(self) -> Acknack:
        """What we have, and what of the announced is missing."""
        first = (self._handled + 1) % NUMBERS
        announced = ahead(self._handled, self._announced)
        missing = [bit for bit in range(min(16, announced)) if (first + bit) % NUMBERS not in self._waiting]
        return Acknack(first, sum(1 << bit for bit in missing))
