"""The mission beside its flight: checked when it comes in, its orders carried out, ended in HOLD."""

from __future__ import annotations

from companion.geodesy import MapProjection
from companion.mavlink.modes import Mode
from companion.mavlink_common import MavSeverity
from companion.world import Home
from sim_bridge.autopilot.commander.commander import Commander
from sim_bridge.autopilot.commander.fence_watch import FenceWatch
from sim_bridge.autopilot.commander.home_position import HomePosition
from sim_bridge.autopilot.flight_modes.guidance import Guidance
from sim_bridge.autopilot.missions.checks import fault_of
from sim_bridge.autopilot.missions.do_commands import DoCommands
from sim_bridge.autopilot.missions.flight import MissionFlight
from sim_bridge.autopilot.missions.store import Kind, Store
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.sensors import Estimate

COUNTS_AS_MISSION = (Mode.MISSION, Mode.TAKEOFF, Mode.LAND)
"""Modes in which MISSION_CURRENT tells that a mission is flown, as in PX4."""


class MissionWatch:
    """Looks after the mission once in a while, whatever is flown. ``do_commands``: who carries its orders out."""

    def __init__(
        self, parameters: Parameters, commander: Commander, store: Store, mission: MissionFlight, guidance: Guidance,
        home: HomePosition, fence: FenceWatch, ground: Home, projection: MapProjection,
    ) -> None:  # fmt: skip
        self._parameters, self._commander, self._store, self._mission = parameters, commander, store, mission
        self._guidance, self._home, self._fence = guidance, home, fence
        self._ground, self._projection = ground, projection
        self.do_commands = DoCommands(commander, mission, guidance, home, ground, projection)
        self._checked: tuple[object, ...] = ()

    def update(self, now: Estimate, t: float) -> None:
        """Check a mission that has come in, say and do what its flight asks for, end it."""
        commander, mission, editions = self._commander, self._mission, self._store.editions
        mission.home_altitude = self._home.altitude
        state = (editions[Kind.MISSION], editions[Kind.FENCE], self._home.p_n is not None)
        if state != self._checked:
            self._check(is_new=self._checked[:1] != state[:1])
            self._checked = state
        commander.failsafe_flags.auto_mission_missing = not mission.is_valid
        commander.failsafe_flags.mission_finished = mission.finished
        mission.is_flown = commander.mode in COUNTS_AS_MISSION
        orders, mission.orders = mission.orders, []
        notes = [*mission.notes, *self._guidance.notes]
        mission.notes.clear()
        self._guidance.notes.clear()
        for note in notes:
            commander.say(MavSeverity.INFO, note)
        for order in orders:
            self.do_commands.carry_out(order, now, t)
        if not commander.armed:
            mission.notice_disarming()
        elif commander.user_intended_mode is Mode.MISSION and mission.finished and not commander.landed:
            commander.finish_mode(Mode.MISSION)

    def _check(self, is_new: bool) -> None:
        """Whether the mission can be flown; if not, why not is said."""
        items, commander = self._store.items[Kind.MISSION], self._commander
        fault = fault_of(
            items, home_is_known=self._home.p_n is not None, home_altitude=self._home.altitude,
            landed=commander.landed, may_be_at=self._may_be_at,
        )  # fmt: skip
        if items and fault is not None and fault.endswith("\t"):
            commander.say(MavSeverity.CRITICAL, fault)
        if fault is not None and commander.armed and commander.mode is Mode.MISSION:
            then = "refusing takeoff" if commander.landed else "loitering"
            commander.say(MavSeverity.CRITICAL, f"No valid mission available, {then}\t")
        if is_new:
            self._mission.renew()
        self._mission.is_valid = bool(items) and fault is None

    def _may_be_at(self, latitude: float, longitude: float, altitude: float) -> bool:
        """Whether the geofence allows a place (degrees, m above the sea)."""
        place = (*self._projection.project(latitude, longitude), self._ground.altitude - altitude)
        return not self._parameters["GF_ACTION"] or not self._fence.broken_at(place, self._guidance.home_n)
