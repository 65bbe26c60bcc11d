"""What the autopilot knows of its battery.

A world's battery is measured: voltage and current as they are, and what the current has taken. Otherwise, as in PX4's
simulation, it empties while the vehicle is armed, from full to empty in SIM_BAT_DRAIN seconds, but never below
SIM_BAT_MIN_PCT, its voltage with it, and is full again on the ground.
"""

from __future__ import annotations

import enum

from sim_bridge.autopilot.parameters import Parameters

AVERAGED_OVER = 50.0
"""s, time constant of the current the time that is left is reckoned with."""


class ChargeState(enum.IntEnum):
    """MAV_BATTERY_CHARGE_STATE."""

    OK = 1
    LOW = 2
    CRITICAL = 3
    EMERGENCY = 4


class Battery:
    """``remaining``: 1 full, 0 empty. ``voltage`` V and ``current`` A where they are measured, else None.

    ``consumed``: what a measured current has taken, mAh.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.remaining = 1.0
        self.voltage: float | None = None
        self.current: float | None = None
        self.consumed = 0.0
        self._usual = parameters["BAT_AVRG_CURRENT"]  # A

    def measure(self, voltage: float, current: float, remaining: float) -> None:
        """What the world's battery is now."""
        self.voltage, self.current, self.remaining = voltage, current, remaining

    def update(self, passed: float, armed: bool) -> None:
        """``passed`` s more."""
        if self.current is not None:
            self.consumed += self.current * passed / 3.6
            if armed:
                self._usual += passed / (AVERAGED_OVER + passed) * (self.current - self._usual)
            return
        limits = self._parameters
        if not armed or not limits["SIM_BAT_ENABLE"]:
            self.remaining = 1.0
            return
        least = max(0.0, min(100.0, limits["SIM_BAT_MIN_PCT"])) / 100.0
        self.remaining = max(least, self.remaining - passed / max(1.0, limits["SIM_BAT_DRAIN"]))

    @property
    def time_left(self) -> float | None:
        """s that the charge lasts at the usual current; None: the capacity is not known."""
        capacity = self._parameters["BAT1_CAPACITY"]
        return 3.6 * capacity * self.remaining / max(1e-3, self._usual) if capacity > 0.0 else None

    @property
    def state(self) -> ChargeState:
        """How bad it is, by the BAT_* thresholds."""
        limits = self._parameters
        if self.remaining < limits["BAT_EMERGEN_THR"]:
            return ChargeState.EMERGENCY
        if self.remaining < limits["BAT_CRIT_THR"]:
            return ChargeState.CRITICAL
        return ChargeState.LOW if self.remaining < limits["BAT_LOW_THR"] else ChargeState.OK
