"""Items -> waypoints in the order they are flown, with the speed and the heading of each leg.

What is a path is honoured: waypoints, changes of speed, headings, points to face, jumps. What stops on the way (holds,
delays, loiters) is flown through with a note, what the payload does is kept at its place, what is not known and flies
nowhere is not carried out, with a note; what would
change where the vehicle flies and is not understood is refused.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable

from companion.mavlink_common import (
    MAV_CMD_CONDITION_DELAY,
    MAV_CMD_CONDITION_DISTANCE,
    MAV_CMD_CONDITION_YAW,
    MAV_CMD_DO_CHANGE_SPEED,
    MAV_CMD_DO_JUMP,
    MAV_CMD_DO_LAND_START,
    MAV_CMD_DO_SET_ROI,
    MAV_CMD_DO_SET_ROI_LOCATION,
    MAV_CMD_DO_SET_ROI_NONE,
    MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET,
    MAV_CMD_NAV_DELAY,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_LOITER_TIME,
    MAV_CMD_NAV_LOITER_TO_ALT,
    MAV_CMD_NAV_LOITER_TURNS,
    MAV_CMD_NAV_LOITER_UNLIM,
    MAV_CMD_NAV_PAYLOAD_PLACE,
    MAV_CMD_NAV_RETURN_TO_LAUNCH,
    MAV_CMD_NAV_SPLINE_WAYPOINT,
    MAV_CMD_NAV_TAKEOFF,
    MAV_CMD_NAV_WAYPOINT,
)
from companion.plans import items as c
from companion.plans.item_place import place_of
from companion.plans.items import Item, Key, Place, Plan, PlanError, Problem
from companion.plans.payload import PAYLOAD, PayloadCommand
from companion.plans.rest import rest_in_words
from companion.plans.waypoints import Route, Waypoint, items_in_words

STEPS_MAX = 200_000
"""Items executed, jumps and all."""


def route_of(plan: Plan, line_of: Callable[[Key], int] | None = None) -> Route:
    """The route of a plan. ``line_of``: of its file, where something of it stands, for its notes. PlanError with every
    reason why there is none."""
    return _Walk(plan, line_of).route()


class _Walk:
    """Executes the items in order, as the autopilot would."""

    def __init__(self, plan: Plan, line_of: Callable[[Key], int] | None) -> None:
        self._plan = plan
        self._line_of = line_of
        self._waypoints: list[Waypoint] = []
        self._problems: list[Problem] = []
        self._notes: dict[str, list[Item]] = defaultdict(list)
        self._speed: float | None = None
        self._roi: Place | None = None
        self._yaw: float | None = None
        self._closed_from: int | None = None
        self._first_payload: tuple[PayloadCommand, ...] = ()
        self._at = 0
        self._end: str | None = None

    def route(self) -> Route:
        """See ``route_of``."""
        items = self._plan.items
        index = {item.number: i for i, item in enumerate(items)}
        reached: dict[int, int] = {}  # the waypoints there were when an item was first executed
        jumps: dict[int, int] = {}
        steps = 0
        while self._at < len(items) and len(self._problems) < 20:
            item = items[self._at]
            steps += 1
            if steps > STEPS_MAX:
                self._problem(item, f"jumps make more than {STEPS_MAX} items")
                break
            reached.setdefault(self._at, len(self._waypoints))
            if item.command == MAV_CMD_DO_JUMP:
                if not self._jump(item, index, reached, jumps):
                    break
            elif self._execute(item):
                self._at += 1
            else:
                break
        if self._problems:
            raise PlanError(self._problems)
        return self._result([item for i, item in enumerate(items) if i > self._at and i not in reached])

    def _result(self, rest: list[Item]) -> Route:
        """The route. ``rest``: the items after the one that it ends with."""
        waypoints = self._waypoints
        closed = self._closed_from is not None
        if self._closed_from is not None:
            if self._closed_from:
                self._notes[f"what comes before the loop ({self._closed_from} waypoints) is not flown"] = []
            first = waypoints[self._closed_from]
            heading = self._facing(None) if first.heading is None else first.heading
            waypoints = [first._replace(speed=self._speed, heading=heading), *waypoints[self._closed_from + 1 :]]
        if waypoints and self._first_payload:
            waypoints = [waypoints[0]._replace(payload=self._first_payload + waypoints[0].payload), *waypoints[1:]]
        if len(waypoints) < (3 if closed else 2):
            if not waypoints and self._plan.fence:
                raise PlanError([Problem((), "it holds a fence, and no waypoints to fly")])
            found = "none" if not waypoints else "one" if len(waypoints) == 1 else f"{len(waypoints)} in a loop"
            raise PlanError(
                [Problem(self._plan.items_key, f"a path needs two waypoints (three in a loop), found {found}")]
            )
        said = [f"{words}{items_in_words(items, self._line_of)}" for words, items in self._notes.items()]
        if self._end is not None:
            said += rest_in_words(rest, self._end, self._line_of)
        return Route(tuple(waypoints), closed, (*self._plan.notes, *said))

    def _execute(self, item: Item) -> bool:
        """Whether the route goes on after ``item``."""
        command = item.command
        if command in c.MOVES:
            self._add_waypoint(item)
            if command == MAV_CMD_NAV_LOITER_UNLIM:
                self._note("the path ends where the plan loiters", item)
                self._end = "the loiter without an end"
                return False
        elif command == MAV_CMD_NAV_TAKEOFF:
            self._add_takeoff(item)
        elif command == MAV_CMD_NAV_LAND:
            self._add_landing(item)
            self._end = "the landing"
            return False
        elif command == MAV_CMD_NAV_RETURN_TO_LAUNCH:
            self._note("the path ends where the plan returns home; --finish says what follows", item)
            self._end = "the return"
            return False
        elif command in c.NOT_FOR_A_QUADROTOR:
            self._problem(item, f"{c.NOT_FOR_A_QUADROTOR[command]} (command {command}) is not for a quadrotor")
        elif command in _CHANGES:
            _CHANGES[command](self, item)
        elif command == MAV_CMD_NAV_PAYLOAD_PLACE or c.flies_somewhere(command):
            self._problem(item, f"command {command} says where to fly in a way that is not known here")
        elif command in PAYLOAD:
            self._trigger_payload(item)
        elif command != MAV_CMD_DO_LAND_START:
            self._note(f"command {command} is not known here and not carried out", item)
        return True

    def _trigger_payload(self, item: Item) -> None:
        """The payload does something where the waypoint before is reached."""
        given = tuple(value if math.isfinite(value) else 0.0 for value in item.params)
        order = PayloadCommand(item.command, given, item.number)
        if not self._waypoints:
            self._first_payload += (order,)
        else:
            last = self._waypoints[-1]
            self._waypoints[-1] = last._replace(payload=(*last.payload, order))

    def _add_waypoint(self, item: Item) -> None:
        place = self._place(item)
        if place is None:
            return
        if item.command == MAV_CMD_NAV_WAYPOINT and item.params[0] > 0.0:
            self._note("pauses are not made, the path is flown without a stop", item)
        elif item.command in (MAV_CMD_NAV_LOITER_TIME, MAV_CMD_NAV_LOITER_TURNS, MAV_CMD_NAV_LOITER_TO_ALT):
            self._note("loiters are flown through as waypoints", item)
        elif item.command == MAV_CMD_NAV_SPLINE_WAYPOINT:
            self._note("spline waypoints are flown as waypoints; say smooth: true for a smooth curve", item)
        self._waypoints.append(Waypoint(place, self._speed, self._facing(item), item.key, item.number))

    def _add_takeoff(self, item: Item) -> None:
        latitude, longitude, altitude = item.params[4:7]
        home = self._plan.home
        if not math.isfinite(latitude) or not math.isfinite(longitude) or latitude == longitude == 0.0:
            if home is None:
                self._note("the take-off has no place; the path begins at the waypoint after it", item)
                return
            item = item._replace(params=(*item.params[:4], home.latitude, home.longitude, altitude))
        place = self._place(item)
        if place is not None:
            self._waypoints.append(Waypoint(place, self._speed, self._facing(None), item.key, item.number))

    def _add_landing(self, item: Item) -> None:
        self._note("the path ends above the landing place; --finish says what follows", item)
        latitude, longitude = item.params[4:6]
        if (
            not self._waypoints
            or not math.isfinite(latitude)
            or not math.isfinite(longitude)
            or latitude == longitude == 0.0
        ):
            return
        place = self._place(item._replace(params=(*item.params[:6], 0.0)))
        before = self._waypoints[-1].place
        if place is not None:
            above = place._replace(altitude=before.altitude, amsl=before.amsl)
            self._waypoints.append(Waypoint(above, self._speed, self._facing(item), item.key, item.number))

    def _change_speed(self, item: Item) -> None:
        kind, speed = item.params[0], item.params[1]
        if kind not in (0.0, 1.0):
            self._note("speeds of climbing and sinking are not changed", item)
        elif not math.isfinite(speed) or speed == -2.0:
            self._speed = None
        elif speed > 0.0:
            self._speed = speed
        elif speed != -1.0:
            self._problem(item, f"a speed of {speed:g} m/s; expected more than 0, or -1 for no change")

    def _face_place(self, item: Item) -> None:
        if item.command == MAV_CMD_DO_SET_ROI and item.params[0] != 3.0:
            self._note("regions of interest that are not places are skipped", item)
            return
        self._roi = None if item.params[4] == item.params[5] == 0.0 else self._place(item)

    def _face_nothing(self, item: Item) -> None:
        self._roi = None

    def _face_next(self, item: Item) -> None:
        self._note("the camera's offset from the way of travel is not flown, the nose goes along the path", item)

    def _turn(self, item: Item) -> None:
        if item.params[3] == 1.0:
            self._note("turns by an angle are skipped", item)
        elif math.isfinite(item.params[0]):
            self._yaw = item.params[0] % 360.0

    def _pass_over_pause(self, item: Item) -> None:
        self._note("pauses are not made, the path is flown without a stop", item)

    def _jump(self, item: Item, index: dict[int, int], reached: dict[int, int], jumps: dict[int, int]) -> bool:
        """Whether the route goes on."""
        target, repeat = item.params[0], item.params[1]
        if not math.isfinite(target) or int(target) not in index:
            self._problem(item, f"jumps to item {target:g}, which is not in the plan")
            return False
        to = index[int(target)]
        if not math.isfinite(repeat) or repeat < 0.0:  # for ever
            if to not in reached:
                self._problem(item, "jumps forward for ever")
                return False
            self._closed_from = reached[to]
            self._end = "the loop without an end"
            return False
        done = jumps.get(self._at, 0)
        jumps[self._at] = done + 1
        self._at = to if done < int(repeat) else self._at + 1
        return True

    def _facing(self, item: Item | None) -> float | Place | None:
        if self._roi is not None:
            return self._roi
        if item is not None and item.command == MAV_CMD_NAV_WAYPOINT and math.isfinite(item.params[3]):
            self._yaw = None
            return item.params[3] % 360.0
        return self._yaw

    def _place(self, item: Item) -> Place | None:
        found = place_of(item)
        if isinstance(found, str):
            self._problem(item, found)
            return None
        return found

    def _problem(self, item: Item, message: str) -> None:
        self._problems.append(Problem(item.key, f"item {item.number}: {message}"))

    def _note(self, words: str, item: Item) -> None:
        if all(known.number != item.number for known in self._notes[words]):
            self._notes[words].append(item)


_CHANGES: dict[int, Callable[[_Walk, Item], None]] = {
    MAV_CMD_DO_CHANGE_SPEED: _Walk._change_speed,
    MAV_CMD_DO_SET_ROI_LOCATION: _Walk._face_place,
    MAV_CMD_DO_SET_ROI: _Walk._face_place,
    MAV_CMD_DO_SET_ROI_NONE: _Walk._face_nothing,
    MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET: _Walk._face_next,
    MAV_CMD_CONDITION_YAW: _Walk._turn,
    MAV_CMD_NAV_DELAY: _Walk._pass_over_pause,
    MAV_CMD_CONDITION_DELAY: _Walk._pass_over_pause,
    MAV_CMD_CONDITION_DISTANCE: _Walk._pass_over_pause,
}
