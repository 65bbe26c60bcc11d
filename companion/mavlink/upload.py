"""A list of mission items to the vehicle (MAVLink's mission protocol), without sockets or clocks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL_INT

COUNT, ITEM, ACK = message("MISSION_COUNT"), message("MISSION_ITEM_INT"), message("MISSION_ACK")
REQUEST_INT, REQUEST = message("MISSION_REQUEST_INT"), message("MISSION_REQUEST")
WANTED = frozenset({REQUEST_INT.id, REQUEST.id, ACK.id})
CURVE_POINTS = 60
"""Waypoints of a curve that is drawn on a ground station's map. Engineering choice."""
RETRY_AFTER = 1.0
"""s without a request for the next item. Engineering choice."""
TRIES = 5
"""Tries before an upload is given up. Engineering choice."""
RESULTS = {0: "accepted", 1: "refused", 2: "frame not supported", 3: "not supported", 4: "no room", 5: "invalid",
           13: "out of sequence", 14: "denied", 15: "cancelled"}  # fmt: skip
"""MAV_MISSION_RESULT in words."""


class Place(NamedTuple):
    """A place on the earth: degrees, and m above mean sea level."""

    latitude: float
    longitude: float
    altitude: float


@dataclass
class Upload:
    """One upload of waypoints. ``send`` queues a message; ``outcome``: in words once it is over."""

    send: Callable[[Format, tuple[Value, ...]], None]
    places: Sequence[Place]
    system: int
    outcome: str | None = None
    _sent_at: float = -math.inf
    _tries: int = 0

    def on_timer(self, now: float) -> None:
        """Begin, or ask again."""
        if self.outcome is not None or now < self._sent_at + RETRY_AFTER:
            return
        if self._tries == TRIES:
            self.outcome = "the vehicle did not take the curve: no answer"
            return
        self._tries += 1
        self._sent_at = now
        self.send(COUNT, COUNT.values(target_system=self.system, target_component=1, count=len(self.places)))

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        return math.inf if self.outcome is not None else self._sent_at + RETRY_AFTER

    def receive(self, frame: Frame, now: float) -> None:
        """Answer the vehicle's requests."""
        if self.outcome is not None or frame.format.id not in WANTED:
            return
        values = frame.format.named(frame.values)
        if values.get("mission_type", 0) != 0:
            return
        if frame.format is ACK:
            result = RESULTS.get(values["type"], f"result {values['type']}")
            self.outcome = f"the curve on the ground station's map: {len(self.places)} waypoints {result}"
        elif 0 <= values["seq"] < len(self.places):
            self._sent_at = now
            place = self.places[values["seq"]]
            self.send(ITEM, ITEM.values(
                param4=math.nan, x=round(place.latitude * 1e7), y=round(place.longitude * 1e7), z=place.altitude,
                seq=values["seq"], command=MAV_CMD_NAV_WAYPOINT, target_system=self.system, target_component=1,
                frame=MAV_FRAME_GLOBAL_INT, autocontinue=1,
            ))  # fmt: skip
