"""The waypoints of a route, as values; and the items of a plan in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from companion.plans.items import Item, Key, Place
from companion.plans.payload import PayloadCommand

SHOWN_MAX = 5
"""Items that a note names."""


class Waypoint(NamedTuple):
    """A point of the route, and the leg that leads to it.

    ``speed``: m/s on the leg, None for the plan's own. ``heading``: degrees clockwise from north on the leg, or a place
    to face; None: along the leg. ``number``: of its item. ``payload``: what is to be done
    when it is reached.
    """

    place: Place
    speed: float | None
    heading: float | Place | None
    key: Key
    number: int = 0
    payload: tuple[PayloadCommand, ...] = ()


@dataclass(frozen=True, slots=True)
class Route:
    """``waypoints``: two at least. ``closed``: the last is joined to the first, whose leg that is. ``notes``: what of
    the plan is not flown."""

    waypoints: tuple[Waypoint, ...]
    closed: bool
    notes: tuple[str, ...]


def items_in_words(items: list[Item], line_of: Callable[[Key], int] | None) -> str:
    """(items 3, 5, 7 and 20 more, from line 57 on)"""
    if not items:
        return ""
    shown = ", ".join(str(item.number) for item in items[:SHOWN_MAX])
    more = f" and {len(items) - SHOWN_MAX} more" if len(items) > SHOWN_MAX else ""
    line = "" if line_of is None else f", line {line_of(items[0].key)}" + (" on" if len(items) > 1 else "")
    return f" (item{'s' if len(items) > 1 else ''} {shown}{more}{line})"
