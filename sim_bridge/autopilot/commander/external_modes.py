"""Flight modes that others bring: registered, asked every 300 ms whether they can be flown, given up when silent.

PX4's ModeManagement and ExternalChecks. What such a mode flies are the topics it writes, at the level it has asked for;
nothing looks at how old those are: while its answers come, the last ones stand.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.mavlink.modes import Mode
from sim_bridge.autopilot.flight_modes.topics import Level
from sim_bridge.autopilot.parameters import Parameters

EXTERNAL = tuple(mode for mode in Mode if mode.name.startswith("EXTERNAL"))
"""Their modes, in order."""
FIRST_NAV_STATE = 23
"""VehicleStatus.NAVIGATION_STATE_EXTERNAL1."""
UPDATE_INTERVAL = 0.3
"""s between two questions."""
REQUEST_TIMEOUT = 0.05
"""s after which an answer has not come in time to count as one."""
REPLY_TIMEOUT = 0.3
"""s: an answer whose stamp is older does not count."""
UNANSWERED_AT_MOST = 3
"""Number of questions without an answer, one more than which makes a mode unresponsive."""
UNANSWERED_AT_FIRST = 10
"""The same before its first answer."""
RELAPSES = 3
"""How often a mode may become unresponsive and still be taken back."""
API_VERSION = 1
"""LATEST_PX4_ROS2_API_VERSION."""
FLAGS = {
    "flag_control_position_enabled": Level.POSITION,
    "flag_control_velocity_enabled": Level.VELOCITY,
    "flag_control_acceleration_enabled": Level.ACCELERATION,
    "flag_control_attitude_enabled": Level.ATTITUDE,
    "flag_control_rates_enabled": Level.RATES,
    "flag_control_allocation_enabled": Level.TORQUES,
}
"""The level a mode's setpoints begin at, by the first flag it sets in config_control_setpoints; motors without any."""

Fields = Mapping[str, Any]


@dataclass(slots=True)
class Registration:
    """One mode. ``missed``: questions in a row it did not answer; ``can_run``: its last answer."""

    name: bytes
    mode: Mode
    waits_for_first: bool = True
    missed: int = 0
    unresponsive: bool = False
    relapses: int = 0
    can_run: bool = False
    level: Level = Level.POSITION


class ExternalModes:
    """``outbox``: what the vehicle says to them: topics by name, and their fields."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._registered: dict[int, Registration] = {}
        self.outbox: list[tuple[str, dict[str, Any]]] = []
        self._request = 0
        self._asked_at: float | None = None
        self._answered: set[int] = set()
        self._counted = True

    def of(self, mode: Mode) -> Registration | None:
        """Who brings a mode."""
        for each in self._registered.values():
            if each.mode is mode:
                return each
        return None

    def can_run(self, mode: Mode) -> bool:
        """Whether a mode is there, answers and says that it can be flown."""
        found = self.of(mode)
        return found is not None and not found.unresponsive and found.can_run

    def register(self, asked: Fields, armed: bool) -> None:
        """register_ext_component_request. In flight only with COM_MODE_ARM_CHK, as in PX4 by default in simulation."""
        reply = {"success": False, "arming_check_id": -1, "mode_id": -1}
        may = not armed or self._parameters["COM_MODE_ARM_CHK"]
        taken = {each.mode for each in self._registered.values()}
        free = next((mode for mode in EXTERNAL if mode not in taken), None)
        if may and free is not None and asked["register_mode"] and asked["register_arming_check"]:
            place = next(place for place in range(len(EXTERNAL)) if place not in self._registered)
            self._registered[place] = Registration(asked["name"], free)
            reply = {"success": True, "arming_check_id": place, "mode_id": nav_state_of(free)}
        same = {"request_id": asked["request_id"], "name": asked["name"]}
        own = {"px4_ros2_api_version": API_VERSION, "mode_executor_id": -1}
        self.outbox.append(("register_ext_component_reply", same | own | reply))

    def unregister(self, asked: Fields) -> Mode | None:
        """unregister_ext_component; the mode that is gone."""
        found = self._registered.get(asked["arming_check_id"])
        if found is None or found.name != asked["name"] or nav_state_of(found.mode) != asked["mode_id"]:
            return None
        del self._registered[asked["arming_check_id"]]
        return found.mode

    def configure(self, asked: Fields) -> None:
        """config_control_setpoints: the level a mode's setpoints are at."""
        for each in self._registered.values():
            if nav_state_of(each.mode) == asked["source_id"]:
                each.level = next((level for flag, level in FLAGS.items() if asked[flag]), Level.MOTORS)

    def answer(self, said: Fields, age: float) -> None:
        """arming_check_reply. ``age``: s since its stamp."""
        found = self._registered.get(said["registration_id"])
        if found is None or said["request_id"] != self._request or age > REPLY_TIMEOUT:
            return
        self._answered.add(said["registration_id"])
        found.missed, found.waits_for_first, found.can_run = 0, False, said["can_arm_and_run"]
        if found.relapses <= RELAPSES:
            found.unresponsive = False

    def update(self, t: float, armed: bool, intended: Mode) -> None:
        """Ask, and count who has not answered. ``intended``: the mode that is selected, which is never forgotten."""
        if not self._registered:
            return
        if self._asked_at is not None and t > self._asked_at + REQUEST_TIMEOUT and not self._counted:
            self._counted = True
            for place in self._registered.keys() - self._answered:
                self._miss(self._registered[place])
        if not armed or self._parameters["COM_MODE_ARM_CHK"]:
            for place, each in list(self._registered.items()):
                if each.unresponsive and each.mode is not intended:
                    del self._registered[place]
        if self._asked_at is None or t > self._asked_at + UPDATE_INTERVAL:
            self._asked_at, self._counted = t, False
            self._answered.clear()
            self._request = (self._request + 1) % 256
            asked = sum(1 << place for place, each in self._registered.items() if not each.unresponsive)
            self.outbox.append(
                ("arming_check_request", {"request_id": self._request, "valid_registrations_mask": asked})
            )

    def _miss(self, one: Registration) -> None:
        at_most = UNANSWERED_AT_FIRST if one.waits_for_first else UNANSWERED_AT_MOST
        if not one.unresponsive:
            one.missed += 1
            if one.missed > at_most:
                one.unresponsive = True
                one.relapses += 1


def nav_state_of(mode: Mode) -> int:
    """VehicleStatus's number of an external mode."""
    return FIRST_NAV_STATE + EXTERNAL.index(mode)
