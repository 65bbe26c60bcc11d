"""Whether the vehicle is where it may be: the uploaded geofence and the greatest distances from home."""

from __future__ import annotations

import math

from companion.frames import Vec3
from companion.geodesy import MapProjection
from companion.mavlink_common import MavSeverity
from sim_bridge.autopilot.commander.commander import Commander
from sim_bridge.autopilot.missions.fence import Area, allowed, areas_of
from sim_bridge.autopilot.missions.store import Kind, Store
from sim_bridge.autopilot.parameters import Parameters

PERIOD = 0.2
"""s between two looks."""
TEXTS = {
    "distance": "Geofence: exceeding maximum distance to Home",
    "height": "Geofence: exceeding maximum altitude above Home",
    "area": "Geofence: approaching or outside geofence",
}


class FenceWatch:
    """Keeps the commander's flag ``geofence_breached`` up to date and says why."""

    def __init__(
        self, parameters: Parameters, store: Store, projection: MapProjection, commander: Commander
    ) -> None:  # fmt: skip
        self._parameters, self._store = parameters, store
        self._projection, self._commander = projection, commander
        self._areas: tuple[Area, ...] = ()
        self._edition = 0
        self._look_at = 0.0
        self._broken: frozenset[str] = frozenset()

    def update(self, t: float, place: Vec3, home_n: Vec3 | None) -> None:
        """Look at a vehicle at ``place`` whose home is at ``home_n`` (m, NED; None: not known)."""
        if self._edition != self._store.editions[Kind.FENCE]:
            self._renew(place, home_n)
        if t < self._look_at:
            return
        self._look_at = t + PERIOD
        broken = frozenset() if not self._parameters["GF_ACTION"] else self.broken_at(place, home_n)
        for what in sorted(broken - self._broken):
            self._commander.say(MavSeverity.CRITICAL, TEXTS[what])
        self._broken = broken
        self._commander.failsafe_flags.geofence_breached = bool(broken)

    def broken_at(self, place: Vec3, home_n: Vec3 | None) -> frozenset[str]:
        """Which of the limits a place breaks."""
        north, east, down = place
        limits = self._parameters
        broken = set() if allowed(self._areas, (north, east)) else {"area"}
        if home_n is not None:
            far, high = limits["GF_MAX_HOR_DIST"], limits["GF_MAX_VER_DIST"]
            if far > 0.0 and math.hypot(north - home_n[0], east - home_n[1]) >= far:
                broken.add("distance")
            if high > 0.0 and home_n[2] - down >= high:
                broken.add("height")
        return frozenset(broken)

    def _renew(self, place: Vec3, home_n: Vec3 | None) -> None:
        """Another fence has come in. An area that would be broken at once, or by home, does not count."""
        self._edition = self._store.editions[Kind.FENCE]
        kept = []
        for area in areas_of(self._store.items[Kind.FENCE], self._projection.project):
            if home_n is not None and not area.allows(home_n[:2]):
                self._commander.say(MavSeverity.CRITICAL, "Geofence invalid, doesn't contain Home position\t")
            elif self._parameters["GF_ACTION"] and not self._commander.landed and not area.allows(place[:2]):
                text = "Geofence invalid, doesn't contain current vehicle position\t"
                self._commander.say(MavSeverity.CRITICAL, text)
            else:
                kept.append(area)
        self._areas = tuple(kept)
