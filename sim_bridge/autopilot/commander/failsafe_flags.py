"""PX4's failsafe flags, as far as this vehicle can raise them. Who watches something writes its flag."""

from __future__ import annotations

from dataclasses import dataclass

from sim_bridge.autopilot.commander.battery import ChargeState


@dataclass(slots=True)
class FailsafeFlags:
    """What is wrong with the vehicle and its links, under the names of PX4's message failsafe_flags."""

    manual_control_signal_lost: bool = True
    gcs_connection_lost: bool = True
    offboard_control_signal_lost: bool = True
    auto_mission_missing: bool = True
    mission_failure: bool = False
    mission_finished: bool = False
    geofence_breached: bool = False
    fd_critical_failure: bool = False
    battery_warning: ChargeState = ChargeState.OK
