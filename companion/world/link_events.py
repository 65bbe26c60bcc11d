"""What becomes of datagrams while it lasts: each event says which traffic it concerns, and what happens to that.

Several at once act one after the other, in the order in which they are written.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.world.when import When

ALL: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class LinkEvent:
    """Something happens on a link. ``down``: vehicle to companion, ``up``: the other way; ``companion``,
    ``ground_station``: whose link. ``messages``: only datagrams that begin with a message of one of these names; all
    where empty."""

    when: When
    down: bool = True
    up: bool = True
    companion: bool = True
    ground_station: bool = False
    messages: frozenset[str] = ALL


@dataclass(frozen=True, slots=True)
class LinkCut(LinkEvent):
    """Nothing comes through, each way by itself."""


@dataclass(frozen=True, slots=True)
class LinkDuplicate(LinkEvent):
    """Every datagram comes a second time, ``delay`` s after the first: a network with two routes."""

    delay: float = 0.0


@dataclass(frozen=True, slots=True)
class LinkRepeat(LinkEvent):
    """In the place of every datagram comes the first one of its message again: a relay that hangs on its last."""


@dataclass(frozen=True, slots=True)
class LinkDelay(LinkEvent):
    """Everything comes ``delay`` s later, and ``growth`` s more for each second that it lasts; the order is kept."""

    delay: float = 0.0
    growth: float = 0.0


@dataclass(frozen=True, slots=True)
class LinkThin(LinkEvent):
    """Of each message not more than ``rate`` a second come through: a radio that has no room."""

    rate: float = 10.0


@dataclass(frozen=True, slots=True)
class LinkRecut(LinkEvent):
    """The bytes come cut anew into datagrams of ``size`` bytes, what is left over after ``wait`` s: a bridge from a
    serial line to WiFi, which knows nothing of messages."""

    size: int = 64
    wait: float = 0.005
