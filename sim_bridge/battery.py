"""What the battery gives: a voltage that falls with charge and current, and with it the thrust."""

from __future__ import annotations

from companion.world.machine import Battery


class Cells:
    """The battery of one flight, whose rotors give ``thrust_max`` N in all when it is full.

    ``voltage`` V and ``current`` A as they are now, ``charge`` 0..1.
    """

    __slots__ = ("_battery", "_thrust_max", "charge", "current", "voltage")

    def __init__(self, battery: Battery, thrust_max: float) -> None:
        self._battery = battery
        self._thrust_max = thrust_max
        self.charge = battery.charge
        self.current = battery.idle_current
        self.voltage = self._open_circuit() - battery.resistance * self.current

    @property
    def strength(self) -> float:
        """Thrust over what a full battery gives: a rotor's speed goes with the voltage, its thrust with the square."""
        share = max(0.0, self.voltage / self._battery.full)
        return share * share

    def update(self, thrust: float, step: float) -> None:
        """``step`` s at a thrust (N) of all rotors. The power of lift goes with thrust to 3/2."""
        battery = self._battery
        share = max(0.0, thrust / self._thrust_max)
        self.current = battery.idle_current + battery.full_current * share * share**0.5
        self.charge = max(0.0, self.charge - self.current * step / battery.capacity)
        self.voltage = self._open_circuit() - battery.resistance * self.current

    def _open_circuit(self) -> float:
        battery = self._battery
        return battery.empty + (battery.full - battery.empty) * self.charge if self.charge > 0.0 else 0.0
