"""Who has been heard lately: the ground station and the companion, by their heartbeats, and what is said of it."""

from __future__ import annotations

from companion.mavlink_common import MAV_TYPE_GCS, MAV_TYPE_ONBOARD_CONTROLLER, MavSeverity
from sim_bridge.autopilot.commander.commander import Commander
from sim_bridge.autopilot.parameters import Parameters

COMPANION_LOST_AFTER = 5.0
"""s without a heartbeat of the companion (PX4: onboard controller timeout, 5 s)."""


class Contacts:
    """Tells the commander whether the ground station is lost. A companion that falls silent is only spoken of."""

    def __init__(self, parameters: Parameters, commander: Commander) -> None:
        self._parameters = parameters
        self._commander = commander
        self._heard: dict[int, float] = {}
        self._lost: set[int] = set()

    def notice_heartbeat(self, kind: int, t: float) -> None:
        """A heartbeat of a MAV_TYPE at ``t`` (s)."""
        if kind not in (MAV_TYPE_GCS, MAV_TYPE_ONBOARD_CONTROLLER):
            return
        if kind in self._lost:
            self._lost.discard(kind)
            name = "GCS connection" if kind == MAV_TYPE_GCS else "Onboard controller"
            self._commander.say(MavSeverity.INFO, f"{name} regained\t")
        self._heard[kind] = t
        if kind == MAV_TYPE_GCS:
            self._commander.failsafe_flags.gcs_connection_lost = False

    def update(self, t: float) -> None:
        """Look at the clock."""
        if self._is_silent(MAV_TYPE_GCS, t, self._parameters["COM_DL_LOSS_T"]):
            self._commander.failsafe_flags.gcs_connection_lost = True
            self._commander.say(MavSeverity.INFO, "Connection to ground station lost\t")
        if self._is_silent(MAV_TYPE_ONBOARD_CONTROLLER, t, COMPANION_LOST_AFTER):
            self._commander.say(MavSeverity.CRITICAL, "Connection to mission computer lost\t")

    def _is_silent(self, kind: int, t: float, limit: float) -> bool:
        """Whether one that was heard has just been silent for too long."""
        if kind in self._lost or kind not in self._heard or t - self._heard[kind] <= limit:
            return False
        self._lost.add(kind)
        return True
