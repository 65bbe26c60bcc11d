"""What the autopilot knows of its battery."""

from __future__ import annotations

import enum

from sim_bridge.autopilot.parameters import Parameters


class ChargeState(enum.IntEnum):
    """MAV_BATTERY_CHARGE_STATE."""

    OK = 1
    LOW = 2
    CRITICAL = 3
    EMERGENCY = 4


class Battery:
    """``remaining``: 1 full, 0 empty."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.remaining = 1.0

    @property
    def state(self) -> ChargeState:
        """How bad it is, by the BAT_* thresholds."""
        limits = self._parameters
        if self.remaining < limits["BAT_EMERGEN_THR"]:
            return ChargeState.EMERGENCY
        if self.remaining < limits["BAT_CRIT_THR"]:
            return ChargeState.CRITICAL
        return ChargeState.LOW if self.remaining < limits["BAT_LOW_THR"] else ChargeState.OK
