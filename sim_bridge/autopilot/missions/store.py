"""The three lists a vehicle keeps: mission, geofence, rally points; and which item of the mission is current."""

from __future__ import annotations

import enum

from sim_bridge.autopilot.missions.items import Item


class Kind(enum.IntEnum):
    """MAV_MISSION_TYPE."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


MOST = {Kind.MISSION: 500, Kind.FENCE: 64, Kind.RALLY: 32}
"""How many items each list takes."""
ALL = 255
"""MAV_MISSION_TYPE_ALL."""


class Store:
    """``items`` and ``ids`` by kind; an id is 0 while a list is empty. ``current``: the mission item flown next.

    ``editions``: counts the changes of each list. ``transferring``: whether some link is taking a list in.
    """

    def __init__(self) -> None:
        self.items: dict[Kind, tuple[Item, ...]] = dict.fromkeys(Kind, ())
        self.ids = dict.fromkeys(Kind, 0)
        self.editions = dict.fromkeys(Kind, 0)
        self.current = 0
        self.told_current = 0
        """Counts the times somebody has told which item is current."""
        self.transferring = False

    def put(self, kind: Kind, items: tuple[Item, ...], identity: int, current: int | None = None) -> None:
        """A list is complete. One that is there already changes nothing, unless it names a current item."""
        if kind is Kind.MISSION:
            wanted = self.current if current is None else current
            self.current = max(0, min(wanted, len(items) - 1))
            if current is not None and items:
                self.told_current += 1
        if identity == self.ids[kind] and items:
            return
        self.items[kind], self.ids[kind] = items, identity
        self.editions[kind] += 1

    def clear(self, kind: Kind) -> None:
        """An empty list."""
        self.put(kind, (), 0)

    def set_current(self, index: int) -> bool:
        """Make an item of the mission the next. False: there is no such item."""
        if not 0 <= index < len(self.items[Kind.MISSION]):
            return False
        self.current = index
        self.told_current += 1
        return True
