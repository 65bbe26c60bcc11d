"""The radio or cable between vehicle and companion: what becomes of a datagram."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Way:
    """One way of a link. ``delay`` s; ``jitter``: at most so much more, s, order kept; ``loss``, ``duplicated``,
    ``reordered``: the share of datagrams that are lost, come twice, come 20 ms late and so behind those sent after.
    ``duplicate_delay``: s that the second of two comes after the first."""

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    duplicated: float = 0.0
    reordered: float = 0.0
    duplicate_delay: float = 0.0

    def __bool__(self) -> bool:
        return any((self.delay, self.jitter, self.loss, self.duplicated, self.reordered))


@dataclass(frozen=True, slots=True)
class Link:
    """``down``: vehicle to companion; ``up``: companion to vehicle. The ground station's link is the same."""

    down: Way = field(default_factory=Way)
    up: Way = field(default_factory=Way)
