"""PX4's health and arming checks: battery, contacts, fence, sticks and tilt, looked at one after another."""

from __future__ import annotations

from companion.frames import Vec3
from companion.mavlink.modes import Mode
from companion.mavlink_common import MavSeverity
from sim_bridge.autopilot.commander.battery import Battery, ChargeState
from sim_bridge.autopilot.commander.commander import Commander, Text
from sim_bridge.autopilot.commander.contacts import Contacts
from sim_bridge.autopilot.commander.fence_watch import FenceWatch
from sim_bridge.autopilot.commander.health_report import Health, HealthEvent, HealthReport
from sim_bridge.autopilot.commander.tilt_watch import TiltWatch
from sim_bridge.autopilot.flight_modes.manual_control import ManualControl
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.sensors import Estimate

LOW_BATTERY = {
    ChargeState.LOW: Text(MavSeverity.CRITICAL, "Low battery\t"),
    ChargeState.CRITICAL: Text(MavSeverity.CRITICAL, "Critical battery\t"),
    ChargeState.EMERGENCY: Text(MavSeverity.EMERGENCY, "Emergency battery level\t"),
}


class HealthAndArmingChecks:
    """Keeps the commander's failsafe flags up to date, and tells the health report."""

    def __init__(
        self, parameters: Parameters, commander: Commander, battery: Battery, fence: FenceWatch, sticks: ManualControl
    ) -> None:
        self._parameters, self._commander = parameters, commander
        self._battery, self._fence, self._sticks = battery, fence, sticks
        self._tilt = TiltWatch(parameters)
        self._report = HealthReport()
        self.contacts = Contacts(parameters, commander)

    def update(self, passed: float, t: float, now: Estimate, home_n: Vec3 | None, rates_alone: bool) -> None:
        """``passed`` s after the last time. ``home_n``: m, NED; None: not known. ``rates_alone``: nobody controls the
        attitude, offboard flies rates or motors."""
        commander, flags = self._commander, self._commander.failsafe_flags
        self._battery.update(passed, commander.armed)
        self.contacts.update(t)
        self._fence.update(t, now.p_n, home_n)
        if self._battery.state is not flags.battery_warning:
            flags.battery_warning = self._battery.state
            if flags.battery_warning in LOW_BATTERY:
                commander.say(*LOW_BATTERY[flags.battery_warning])
        flags.manual_control_signal_lost = self._sticks.is_lost(t)
        attitude_is_controlled = commander.armed and not (commander.mode is Mode.ACRO or rates_alone)
        flags.fd_critical_failure = self._tilt.update(t, now.q_nb, attitude_is_controlled)

    def report(self, t: float) -> list[HealthEvent]:
        """What the health report says at ``t`` (s)."""
        commander, flags, parameters = self._commander, self._commander.failsafe_flags, self._parameters
        health = Health(
            ready=commander.is_ready(t),
            armed=commander.armed,
            mode=commander.mode,
            manual_control=not flags.manual_control_signal_lost,
            offboard_signal=not flags.offboard_control_signal_lost,
            mission=not flags.auto_mission_missing,
            gcs_connection=not flags.gcs_connection_lost,
            gcs_needed=bool(parameters["NAV_DLL_ACT"]),
            mission_needed=bool(parameters["COM_ARM_MIS_REQ"]),
        )
        return self._report.update(t, health)
