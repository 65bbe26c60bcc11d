"""The commander's facts, brought up to date: battery, contacts, fence, sticks, tilt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from companion.mavlink.modes import Mode
from companion.mavlink_common import MavSeverity
from sim_bridge.autopilot.commander.battery import ChargeState
from sim_bridge.autopilot.commander.commander import Text
from sim_bridge.autopilot.commander.health_report import Known
from sim_bridge.autopilot.flight_modes.setpoints import MotorDemand, RateDemand

if TYPE_CHECKING:
    from sim_bridge.autopilot.autopilot import Autopilot

LOW_BATTERY = {
    ChargeState.LOW: Text(MavSeverity.CRITICAL, "Low battery\t"),
    ChargeState.CRITICAL: Text(MavSeverity.CRITICAL, "Critical battery\t"),
    ChargeState.EMERGENCY: Text(MavSeverity.EMERGENCY, "Emergency battery level\t"),
}


def gather(autopilot: Autopilot, passed: float) -> None:
    """``passed`` s after the last time."""
    commander, now, t = autopilot.commander, autopilot.estimate, autopilot.t
    flags = commander.failsafe_flags
    autopilot.battery.update(passed, commander.armed)
    autopilot.contacts.update(t)
    home_is_known = autopilot.home_position.home_set_us is not None
    autopilot.fence.update(t, now.p_n, autopilot.guidance.home_n if home_is_known else None)
    if autopilot.battery.state is not flags.battery_warning:
        flags.battery_warning = autopilot.battery.state
        if flags.battery_warning in LOW_BATTERY:
            commander.say(*LOW_BATTERY[flags.battery_warning])
    flags.manual_control_signal_lost = autopilot.sticks.is_lost(t)
    rates_alone = commander.mode is Mode.ACRO or isinstance(autopilot.demand, RateDemand | MotorDemand)
    flags.fd_critical_failure = autopilot.tilt.update(t, now.q_nb, commander.armed and not rates_alone)


def known_to_the_health_report(autopilot: Autopilot) -> Known:
    """What the health report is made from."""
    commander, flags, parameters = autopilot.commander, autopilot.commander.failsafe_flags, autopilot.parameters
    return Known(
        ready=commander.is_ready(autopilot.t),
        armed=commander.armed,
        mode=commander.mode,
        sticks=not flags.manual_control_signal_lost,
        stream=not flags.offboard_control_signal_lost,
        mission=not flags.auto_mission_missing,
        operator=not flags.gcs_connection_lost,
        operator_needed=bool(parameters["NAV_DLL_ACT"]),
        mission_needed=bool(parameters["COM_ARM_MIS_REQ"]),
    )
