"""PX4's normalised allocation: torque and thrust setpoints <-> motor commands, of one vehicle.

PX4 (1.14 and later) takes the pseudo-inverse of its effectiveness matrix (CA_ROTOR*), and scales each axis so that a
torque of 1 is about what the motors can make: roll and pitch by one factor, yaw by the largest entry, thrust by the
mean. Source: ControlAllocationPseudoInverse::updateControlAllocationMatrixScale. Motors then are mix * setpoint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from companion.allocation import Allocation, Four
from companion.frames import Vec3
from companion.vehicle import Vehicle

NO_EFFECT = 1e-3
"""Ratio to an axis's largest entry below which a motor's does not count. PX4 has 1e-3 flat, for its CA_ROTOR_CT."""


def normalised_mix(effectiveness: NDArray[np.float64]) -> NDArray[np.float64]:
    """One row a rotor: its command from (roll, pitch, yaw, thrust along z) setpoints, all as shares. ``effectiveness``:
    what a command gives, one row an axis in the same order; its unit does not count."""
    inverse = np.asarray(np.linalg.pinv(effectiveness), dtype=np.float64)
    roll_pitch = max(_scale(inverse[:, 0]), _scale(inverse[:, 1]))
    scale = (roll_pitch, roll_pitch, np.max(inverse[:, 2]), np.mean(np.abs(inverse[:, 3])))
    mix: NDArray[np.float64] = inverse / np.array(scale)
    return mix


@dataclass(frozen=True)
class Px4Allocation:
    """The allocation that PX4 makes of a vehicle whose CA_ROTOR* say what its file says."""

    vehicle: Vehicle

    @cached_property
    def _allocation(self) -> Allocation:
        return Allocation(self.vehicle)

    @cached_property
    def _mix(self) -> NDArray[np.float64]:
        thrust, roll, pitch, yaw = np.array(self._allocation.effectiveness)
        return normalised_mix(np.array((roll, pitch, yaw, -thrust)))

    @cached_property
    def _inverse(self) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(row) for row in np.linalg.pinv(self._mix).tolist())

    def setpoint(self, commands: Four) -> tuple[Vec3, float]:
        """The torque setpoint (shares about the body axes) and the collective thrust (a share, up) of which PX4 makes
        ``commands``. AllocationError before: see ``Allocation.inverse``."""
        roll, pitch, yaw, thrust_z = (
            sum(entry * command for entry, command in zip(row, commands, strict=True)) for row in self._inverse
        )
        return (roll, pitch, yaw), -thrust_z

    def commands(self, torque: Vec3, thrust: float) -> Four:
        """The commands that PX4 makes of a torque setpoint and a collective thrust, none of them at a limit."""
        a, b, c, d = (self._mix @ np.array((*torque, -thrust))).tolist()
        return (a, b, c, d)

    def wrench(self, torque: Vec3, thrust: float) -> Four:
        """Thrust (N) and torques (N m) of the same."""
        return self._allocation.wrench(self.commands(torque, thrust))


def _scale(column: NDArray[np.float64]) -> float:
    """PX4's factor of roll or pitch: the root mean square over half of the motors that act on it."""
    acting = int(np.count_nonzero(np.abs(column) > NO_EFFECT * np.max(np.abs(column))))
    return math.sqrt(float(column @ column) / (acting / 2.0)) if acting else 1.0
