"""The items of a mission, one after another: which is flown, whether it is reached, what comes next.

It says where to go (a ``Leg``) and what else is to be done (``orders``); flying there is the guidance's business.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Vec3
from companion.geodesy import MapProjection
from companion.mavlink_common import (
    MAV_CMD_DO_JUMP,
    MAV_CMD_NAV_DELAY,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_LOITER_TIME,
    MAV_CMD_NAV_LOITER_UNLIM,
    MAV_CMD_NAV_TAKEOFF,
    MAV_CMD_NAV_WAYPOINT,
)
from sim_bridge.autopilot.missions.checks import altitude_of
from sim_bridge.autopilot.missions.items import Item
from sim_bridge.autopilot.missions.store import Kind, Store
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.sensors import Estimate

NO_MISSION = 1  # MISSION_STATE_NO_MISSION
NOT_STARTED = 2  # MISSION_STATE_NOT_STARTED
ACTIVE = 3  # MISSION_STATE_ACTIVE
PAUSED = 4  # MISSION_STATE_PAUSED
COMPLETE = 5  # MISSION_STATE_COMPLETE
EXECUTING = "Executing Mission\t"
_STAYS = {MAV_CMD_NAV_LOITER_UNLIM}
_WAITS = {MAV_CMD_NAV_WAYPOINT, MAV_CMD_NAV_LOITER_TIME}
"""Commands whose first parameter is a time (s) to spend there."""
_JUMPS_IN_A_ROW = 10
"""DO_JUMP without another item between them: more never come to an end."""


class Leg(NamedTuple):
    """Where to go next (m, NED; None: stay), facing where (rad; None: where it goes), and whether to the ground."""

    place: Vec3 | None
    heading: float | None
    lands: bool = False
    takes_off: bool = False


class MissionFlight:
    """The flight of the mission in ``store``. ``sea_level``: m above the sea of the local frame's origin.

    ``orders``: items that are commands, to be carried out by whoever reads and clears them; ``notes``: what is told to
    the operator, likewise.
    """

    def __init__(self, parameters: Parameters, store: Store, projection: MapProjection, sea_level: float) -> None:
        self._parameters, self._store = parameters, store
        self._projection, self._sea_level = projection, sea_level
        self.home_altitude = sea_level
        self.is_valid = False
        self.is_flown = False
        self.reached = -1
        self.finished = False
        self.orders: list[Item] = []
        self.notes: list[str] = []
        self.interest: Vec3 | None = None  # the region of interest: what the nose points at
        self._edition = -1
        self._told_current = 0
        self._jumped: dict[int, int] = {}
        self._place: Vec3 | None = None
        self._climbs_to: float | None = None  # m down, before the item itself
        self._crossing = 0.0  # m down: the height at which a landing place is flown to
        self._arrived_at: float | None = None
        self._faces = False
        self._begun_before = self._disarmed_since = False

    @property
    def state(self) -> int:
        """MISSION_STATE."""
        if not self._items or not self.is_valid:
            return NO_MISSION
        if self.finished:
            return COMPLETE
        if self.is_flown:
            return ACTIVE
        return PAUSED if self.reached >= 0 else NOT_STARTED

    @property
    def item(self) -> Item | None:
        """The item that is flown."""
        return self._items[self._store.current] if self._store.current < len(self._items) else None

    @property
    def _items(self) -> tuple[Item, ...]:
        return self._store.items[Kind.MISSION]

    def renew(self) -> None:
        """Another mission has come in."""
        self.reached, self.finished = -1, False
        self._jumped.clear()
        self._begun_before = False

    def forget_jumps(self) -> None:
        """Jumps that were made do not count any more."""
        self._jumped.clear()

    def notice_disarming(self) -> None:
        """The vehicle stands: a mission that was at its end begins again."""
        self._disarmed_since = True

    def begin(self, now: Estimate) -> None:
        """Begin, or go on, with the current item."""
        at_the_end = self._store.current + 1 == len(self._items)
        if self._begun_before and self._disarmed_since and at_the_end:
            self._store.current, self.reached, self.finished = 0, -1, False
            self._jumped.clear()
        self._begun_before, self._disarmed_since = True, False
        self._edition, self._told_current = self._store.editions[Kind.MISSION], self._store.told_current
        self.finished = False
        self._place = None
        self.notes.append(EXECUTING)
        self._resolve()
        self._set(now, climb=True)

    def leg(self, now: Estimate, t: float, landed: bool) -> Leg:
        """What to fly at ``t`` (s)."""
        store = self._store
        if (self._edition, self._told_current) != (store.editions[Kind.MISSION], store.told_current):
            self.begin(now)
            self.notes.remove(EXECUTING)  # that has been said before
        for _ in range(len(self._items) + _JUMPS_IN_A_ROW):
            item = self.item
            if item is None or self.finished or not self._is_done(item, now, t, landed):
                break
            if self._climbs_to is not None:
                self._climbs_to = None
                self._set(now, climb=False, again=True)
                continue
            self.reached = store.current
            if not item.autocontinue:
                break
            self._advance(now, landed)
        return self._update_leg(now)

    def _advance(self, now: Estimate, landed: bool) -> None:
        before = self._store.current
        if before + 1 < len(self._items):
            self._store.current += 1
            if self._resolve():
                self._set(now, climb=False)
                return
        self._store.current, self.finished = before, True
        self.notes.append(f"Mission finished, {'landed' if landed else 'loitering'}\t")

    def _resolve(self) -> bool:
        """Follow jumps until an item to fly is current. False: there is none."""
        for _ in range(_JUMPS_IN_A_ROW):
            index = self._store.current
            if index >= len(self._items):
                return False
            item = self._items[index]
            if item.command != MAV_CMD_DO_JUMP:
                return True
            target, repeats = int(item.params[0]), int(item.params[1])
            done = self._jumped.get(index, 0)
            if 0 <= target < len(self._items) and (repeats < 0 or done < repeats):
                self._jumped[index] = done + 1
                self._store.current = target
            else:
                self._store.current = index + 1
        return False

    def _set(self, now: Estimate, climb: bool, again: bool = False) -> None:
        """Begin the current item. ``climb``: straight up to its height first, if that is higher."""
        self._arrived_at, self._faces = None, False
        self._crossing = now.p_n[2]
        item = self.item
        if item is None or again:
            if item is not None and item.has_place:
                self._place = self._place_of(item, now)
            return
        if item.has_place:
            place = self._place_of(item, now)
            below = now.p_n[2] - place[2]
            if (climb or item.command == MAV_CMD_NAV_TAKEOFF) and below > self._parameters["NAV_MC_ALT_RAD"]:
                self._climbs_to = place[2]
                height = altitude_of(item, self.home_altitude) - self.home_altitude
                self.notes.append(f"Climb to {height:.1f} meters above home\t")
                self._place = (now.p_n[0], now.p_n[1], place[2])
            else:
                self._climbs_to = None
                self._place = place
        else:
            self._climbs_to = None
            if item.command != MAV_CMD_NAV_DELAY:
                self.orders.append(item)

    def _place_of(self, item: Item, now: Estimate) -> Vec3:
        """Where an item is; coordinates that say nothing mean here."""
        down = self._sea_level - altitude_of(item, self.home_altitude)
        if (item.x, item.y) == (0.0, 0.0) or not (math.isfinite(item.x) and math.isfinite(item.y)):
            return (now.p_n[0], now.p_n[1], down)
        return (*self._projection.project(item.x, item.y), down)

    def _is_done(self, item: Item, now: Estimate, t: float, landed: bool) -> bool:
        limits = self._parameters
        if item.command == MAV_CMD_NAV_DELAY:
            if self._arrived_at is None:
                self._arrived_at = t
            return t - self._arrived_at >= max(0.0, item.params[0])
        if not item.has_place:
            return True
        if item.command in _STAYS:
            return False
        if self._climbs_to is not None:
            return not landed and now.p_n[2] - self._climbs_to < limits["NAV_MC_ALT_RAD"]
        if item.command == MAV_CMD_NAV_LAND:
            return landed and self._arrived_at is not None
        if landed or self._place is None:
            return False
        if self._arrived_at is None:
            if not self._is_near(now, self._radius(item)):
                return False
            self._arrived_at = t
        if not self._faces:
            self._faces = self._faces_right(item, now)
        wait = item.params[0] if item.command in _WAITS else 0.0
        return self._faces and t - self._arrived_at >= (wait if math.isfinite(wait) else 0.0)

    def _is_near(self, now: Estimate, radius: float) -> bool:
        assert self._place is not None
        north, east, down = self._place
        level = math.hypot(now.p_n[0] - north, now.p_n[1] - east)
        return level <= radius and abs(now.p_n[2] - down) <= self._parameters["NAV_MC_ALT_RAD"]

    def _radius(self, item: Item) -> float:
        own = item.params[1] if item.command == MAV_CMD_NAV_WAYPOINT else 0.0
        return own if math.isfinite(own) and own > 0.0 else self._parameters["NAV_ACC_RAD"]

    def _faces_right(self, item: Item, now: Estimate) -> bool:
        """Whether the heading an item names is taken, or not waited for."""
        wanted = self._yaw(item)
        if wanted is None or self._parameters["MIS_YAW_TMT"] >= 0.0:
            return True
        w, x, y, z = now.q_nb
        heading = math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
        return abs(math.remainder(wanted - heading, math.tau)) < math.radians(self._parameters["MIS_YAW_ERR"])

    def _yaw(self, item: Item) -> float | None:
        """The heading an item names, rad."""
        if item.command not in (MAV_CMD_NAV_WAYPOINT, MAV_CMD_NAV_LOITER_UNLIM, MAV_CMD_NAV_LAND):
            return None
        return math.radians(item.params[3]) if math.isfinite(item.params[3]) else None

    def _update_leg(self, now: Estimate) -> Leg:
        item = self.item
        if item is None:
            return Leg(None, None)
        if self._climbs_to is not None:
            return Leg(self._place, None, takes_off=True)
        heading = self._heading(item, now)
        if item.command == MAV_CMD_NAV_LAND and not self.finished and self._place is not None:
            place = self._place
            far = math.hypot(now.p_n[0] - place[0], now.p_n[1] - place[1])
            if self._arrived_at is None and far <= self._parameters["NAV_ACC_RAD"]:
                self._arrived_at, self.reached = now.time_us * 1e-6, self._store.current
            if self._arrived_at is None:  # across first, at the height it has
                return Leg((place[0], place[1], min(place[2], self._crossing)), heading)
            return Leg(place, heading, lands=True)
        return Leg(self._place, heading)

    def _heading(self, item: Item, now: Estimate) -> float | None:
        if self.interest is not None and item.command not in (MAV_CMD_NAV_LAND, MAV_CMD_NAV_TAKEOFF):
            north, east = self.interest[0] - now.p_n[0], self.interest[1] - now.p_n[1]
            if math.hypot(north, east) > 0.1:
                return math.atan2(east, north)
        return self._yaw(item)
