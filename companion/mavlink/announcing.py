"""What the ground station sees of us: words, and the errors as named numbers, which PX4 also writes to its own log."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import MavSeverity

TEXT, NAMED = message("STATUSTEXT"), message("NAMED_VALUE_FLOAT")
TEXT_SIZE = 50
"""characters of a STATUSTEXT."""
TEXT_PERIOD = 0.5
"""s between two texts; a radio link is narrow."""
WAITING_MAX = 8
"""texts that wait; the oldest are left out."""
SAME_AGAIN = 5.0
"""s before the same text is said again."""
NUMBERS_PERIOD = 0.2
"""s between two rounds of NAMED_VALUE_FLOAT: 5 Hz."""


@dataclass
class Announcer:
    """``send`` queues a message."""

    send: Callable[[Format, tuple[Value, ...]], None]
    _waiting: deque[tuple[int, str]] = field(default_factory=lambda: deque(maxlen=WAITING_MAX))
    _said: dict[str, float] = field(default_factory=dict)
    _next_text: float = -math.inf
    _next_numbers: float = -math.inf
    _count: int = 0

    def say(self, text: str, now: float, severity: int = MavSeverity.INFO) -> None:
        """Say something, unless it was said just now. What has to wait too long is left out, the oldest first."""
        if now - self._said.get(text, -math.inf) >= SAME_AGAIN:
            self._said = {known: at for known, at in self._said.items() if now - at < SAME_AGAIN} | {text: now}
            self._waiting.append((severity, text))

    def on_timer(self, now: float) -> None:
        """Send the text that is due."""
        if not self._waiting or now < self._next_text:
            return
        self._next_text = now + TEXT_PERIOD
        severity, text = self._waiting.popleft()
        raw = text.encode("utf-8", "replace")[: 4 * TEXT_SIZE]
        pieces = [raw[i : i + TEXT_SIZE] for i in range(0, len(raw), TEXT_SIZE)] or [b""]
        number = 0
        if len(pieces) > 1:
            self._count = self._count % 0xFFFF + 1
            number = self._count
        for sequence, piece in enumerate(pieces):
            self.send(TEXT, TEXT.values(severity=severity, text=piece, id=number, chunk_seq=sequence))

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        return self._next_text if self._waiting else math.inf

    def are_numbers_due(self, now: float) -> bool:
        """Whether NUMBERS_PERIOD s have passed since the last numbers."""
        return now >= self._next_numbers

    def numbers(self, now: float, t_boot: float, named: dict[str, float]) -> None:
        """Send numbers by name (10 characters)."""
        self._next_numbers = now + NUMBERS_PERIOD
        stamp = round(t_boot * 1e3) & 0xFFFFFFFF
        for name, value in named.items():
            self.send(NAMED, (stamp, value, name.encode("ascii")))
