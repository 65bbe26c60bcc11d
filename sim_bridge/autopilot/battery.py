"""What the autopilot knows of its battery.

A world's battery is measured. Otherwise, as in PX4's simulation, it empties while the vehicle is armed, from full to
empty in SIM_BAT_DRAIN seconds, but never below SIM_BAT_MIN_PCT, and is full again on the ground.
"""

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
    """``remaining``: 1 full, 0 empty. ``voltage`` V and ``current`` A where they are measured, else None."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.remaining = 1.0
        self.voltage: float | None = None
        self.current: float | None = None

    def measure(self, voltage: float, current: float, remaining: float) -> None:
        """What the world's battery is now."""
        self.voltage, self.current, self.remaining = voltage, current, remaining

    def update(self, passed: float, armed: bool) -> None:
        """``passed`` s more."""
        if self.voltage is not None:
            return
        limits = self._parameters
        if not armed or not limits["SIM_BAT_ENABLE"]:
            self.remaining = 1.0
            return
        least = max(0.0, min(100.0, limits["SIM_BAT_MIN_PCT"])) / 100.0
        self.remaining = max(least, self.remaining - passed / max(1.0, limits["SIM_BAT_DRAIN"]))

    @property
    def state(self) -> ChargeState:
        """How bad it is, by the BAT_* thresholds."""
        limits = self._parameters
        if self.remaining < limits["BAT_EMERGEN_THR"]:
            return ChargeState.EMERGENCY
        if self.remaining < limits["BAT_CRIT_THR"]:
            return ChargeState.CRITICAL
        return ChargeState.LOW if self.remaining < limits["BAT_LOW_THR"] else ChargeState.OK
