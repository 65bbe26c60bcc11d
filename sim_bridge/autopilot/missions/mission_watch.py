"""The mission beside its flight: checked when it comes in, its orders carried out, ended in HOLD."""

from __future__ import annotations

from typing import TYPE_CHECKING

from companion.mavlink.modes import Mode
from companion.mavlink_common import MavSeverity
from sim_bridge.autopilot.missions.checks import fault_of
from sim_bridge.autopilot.missions.do_commands import carry_out
from sim_bridge.autopilot.missions.store import Kind

if TYPE_CHECKING:
    from sim_bridge.autopilot.autopilot import Autopilot

COUNTS_AS_MISSION = (Mode.MISSION, Mode.TAKEOFF, Mode.LAND)
"""Modes in which MISSION_CURRENT tells that a mission is flown, as in PX4."""


def look_after(autopilot: Autopilot) -> None:
    """Once in a while, whatever is flown."""
    commander, mission, store = autopilot.commander, autopilot.mission, autopilot.missions
    mission.home_altitude = autopilot.home_altitude
    state = (store.editions[Kind.MISSION], store.editions[Kind.FENCE], autopilot.home_position.home_set_us is not None)
    if state != autopilot.mission_checked:
        _check(autopilot, is_new=autopilot.mission_checked[:1] != state[:1])
        autopilot.mission_checked = state
    commander.failsafe_flags.auto_mission_missing = not mission.is_valid
    commander.failsafe_flags.mission_finished = mission.finished
    mission.is_flown = commander.mode in COUNTS_AS_MISSION
    orders, mission.orders = mission.orders, []
    notes = [*mission.notes, *autopilot.guidance.notes]
    mission.notes.clear()
    autopilot.guidance.notes.clear()
    for note in notes:
        commander.say(MavSeverity.INFO, note)
    for order in orders:
        carry_out(order, autopilot)
    if not commander.armed:
        mission.disarmed()
    elif commander.user_intended_mode is Mode.MISSION and mission.finished and not commander.landed:
        commander.mission_is_over()


def _check(autopilot: Autopilot, is_new: bool) -> None:
    """Whether the mission can be flown; if not, why not is said."""
    items = autopilot.missions.items[Kind.MISSION]

    def may_be_at(latitude: float, longitude: float, altitude: float) -> bool:
        place = (*autopilot.projection.project(latitude, longitude), autopilot.home.altitude - altitude)
        return not autopilot.parameters["GF_ACTION"] or not autopilot.fence.broken_at(place, autopilot.guidance.home_n)

    fault = fault_of(
        items, home_is_known=autopilot.home_position.home_set_us is not None, home_altitude=autopilot.home_altitude,
        landed=autopilot.commander.landed, may_be_at=may_be_at,
    )  # fmt: skip
    commander = autopilot.commander
    if items and fault is not None and fault.endswith("\t"):
        commander.say(MavSeverity.CRITICAL, fault)
    if fault is not None and commander.armed and commander.mode is Mode.MISSION:
        then = "refusing takeoff" if commander.landed else "loitering"
        commander.say(MavSeverity.CRITICAL, f"No valid mission available, {then}\t")
    if is_new:
        autopilot.mission.renew()
    autopilot.mission.is_valid = bool(items) and fault is None
