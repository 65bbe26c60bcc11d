"""What a vehicle says of its missions, message by message."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import MavMissionResult
from sim_bridge.autopilot.missions.items import ITEM, ITEM_INT, Item, values
from sim_bridge.autopilot.missions.store import Kind, Store

ACK, COUNT, CURRENT = (message(f"MISSION_{name}") for name in ("ACK", "COUNT", "CURRENT"))
REQUEST, REQUEST_INT = message("MISSION_REQUEST"), message("MISSION_REQUEST_INT")
REACHED = message("MISSION_ITEM_REACHED")
NONE_TOTAL = 65535
"""MISSION_CURRENT's total: there is no mission."""
FLOWN = 1
"""MISSION_CURRENT's mission_mode: in mission mode."""
NOT_FLOWN = 2
"""MISSION_CURRENT's mission_mode: suspended."""

Send = Callable[[Format, tuple[Value, ...]], None]
Peer = tuple[int, int]
"""System and component."""


class Progress(Protocol):
    """How far the flight of the mission has come."""

    @property
    def reached(self) -> int:
        """The last item reached; -1 none."""

    @property
    def finished(self) -> bool:
        """Whether the last item has been flown."""

    @property
    def state(self) -> int:
        """MISSION_STATE."""

    @property
    def is_flown(self) -> bool:
        """Whether the mission is being flown now."""


class MissionMessages:
    """Speaks of ``store`` and of the ``progress`` of its mission, by ``send``. ``kind``: MAV_MISSION_TYPE."""

    def __init__(self, store: Store, progress: Progress, send: Send) -> None:
        self._store, self._progress, self._send = store, progress, send

    def ask(self, whom: Peer, kind: int, index: int, whole: bool) -> None:
        """For an item, with whole-number coordinates or without."""
        fmt = REQUEST_INT if whole else REQUEST
        self._send(fmt, fmt.values(seq=index, **_to(whom, kind)))

    def count(self, whom: Peer, kind: int, count: int) -> None:
        """How long a list is."""
        identity = self._store.ids[Kind(kind)] if kind in tuple(Kind) else 0
        self._send(COUNT, COUNT.values(count=count, opaque_id=identity, **_to(whom, kind)))

    def item(self, whom: Peer, kind: int, index: int, item: Item, whole: bool) -> None:
        """One item."""
        others = {"seq": index, "current": int(self._store.current == index)} | _to(whom, kind)
        self._send(ITEM_INT if whole else ITEM, values(item, whole, others))

    def acknowledge(self, whom: Peer, kind: int, answer: MavMissionResult, identity: int = 0) -> None:
        """How it went."""
        self._send(ACK, ACK.values(type=answer.value, opaque_id=identity, **_to(whom, kind)))

    def say_reached(self, index: int) -> None:
        """MISSION_ITEM_REACHED."""
        self._send(REACHED, REACHED.values(seq=index))

    def current(self) -> None:
        """How the mission goes."""
        store, progress = self._store, self._progress
        self._send(CURRENT, CURRENT.values(
            seq=store.current, total=len(store.items[Kind.MISSION]) or NONE_TOTAL, mission_state=progress.state,
            mission_mode=FLOWN if progress.is_flown else NOT_FLOWN, mission_id=store.ids[Kind.MISSION],
            fence_id=store.ids[Kind.FENCE], rally_points_id=store.ids[Kind.RALLY],
        ))  # fmt: skip


def _to(whom: Peer, kind: int) -> dict[str, Value]:
    return {"target_system": whom[0], "target_component": whom[1], "mission_type": kind & 0xFF}
