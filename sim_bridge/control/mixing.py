"""Torques and thrust to motor commands, for four rotors placed anywhere, and what to give up when they saturate.

The rotors' effect is summed up from their geometry and inverted numerically; the columns are then scaled as PX4 scales
them, so that for a quad X a torque of 1 about roll or pitch moves each motor by 0.7071, about yaw by 1, and a thrust of
t gives every motor t. When commands leave their range, PX4's sequential desaturation applies: thrust is lowered (never
raised) for the sake of roll and pitch, roll and pitch before each other, yaw is given up first.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.frames import Vec3
from companion.vehicle import Rotor
from sim_bridge.rotors import Four, torque_per_newton

YAW_MARGIN = 0.15
"""The part of the command range yaw may use beyond its top, at the cost of thrust (PX4's MINIMUM_YAW_MARGIN)."""
WEAK = 0.2
"""A rotor that answers less than this to an axis is not asked to relieve saturation with it."""


class Mixer:
    """Mixes for ``rotors``. ValueError: the rotors cannot give every torque and a thrust.

    ``torque_per_unit``: N m a torque of 1 gives about each axis; ``thrust_per_unit``: N that a thrust of 1 gives.
    """

    def __init__(self, rotors: tuple[Rotor, ...]) -> None:
        full = [rotor.thrust_max * rotor.command[1] for rotor in rotors]
        effect = np.array([(*torque_per_newton(rotor), 1.0) for rotor in rotors]).T * full
        if np.linalg.cond(effect / np.abs(effect).max(axis=1, initial=1e-12, keepdims=True)) > 1e6:
            raise ValueError(
                "these rotors cannot turn the vehicle about every axis; expected positions and spins apart"
            )
        inverse = np.linalg.inv(effect)
        roll_pitch = max(_scale_of_a_tilting_axis(inverse[:, axis]) for axis in (0, 1))
        scale = (roll_pitch, roll_pitch, float(inverse[:, 2].max()), float(np.abs(inverse[:, 3]).mean()))
        columns = inverse / np.array(scale)
        self._roll, self._pitch, self._yaw, self._thrust = (_four(columns[:, axis]) for axis in range(4))
        self._back = tuple(_four(row) for row in np.linalg.inv(columns)[:3])
        self.torque_per_unit: Vec3 = (1.0 / scale[0], 1.0 / scale[1], 1.0 / scale[2])
        self.thrust_per_unit = 1.0 / scale[3]
        self._full = _four(rotor.command[1] for rotor in rotors)
        self._low = _four(rotor.command[0] / rotor.command[1] for rotor in rotors)

    def mix(self, torque: Vec3, thrust: float) -> tuple[Four, Vec3]:
        """Motor commands in the rotors' units, and the torque that saturation took away (in the same units of 1)."""
        l, m, n = torque  # noqa: E741  roll, pitch and yaw torque
        (r0, r1, r2, r3), (p0, p1, p2, p3), (t0, t1, t2, t3) = self._roll, self._pitch, self._thrust
        y0, y1, y2, y3 = self._yaw
        low0, low1, low2, low3 = self._low
        k0, k1, k2, k3 = self._full
        a0 = r0 * l + p0 * m + t0 * thrust
        a1 = r1 * l + p1 * m + t1 * thrust
        a2 = r2 * l + p2 * m + t2 * thrust
        a3 = r3 * l + p3 * m + t3 * thrust
        if low0 <= a0 <= 1.0 and low1 <= a1 <= 1.0 and low2 <= a2 <= 1.0 and low3 <= a3 <= 1.0:
            b0, b1, b2, b3 = a0 + y0 * n, a1 + y1 * n, a2 + y2 * n, a3 + y3 * n
            if low0 <= b0 <= 1.0 and low1 <= b1 <= 1.0 and low2 <= b2 <= 1.0 and low3 <= b3 <= 1.0:
                return (k0 * b0, k1 * b1, k2 * b2, k3 * b3), (0.0, 0.0, 0.0)
        (b0, b1, b2, b3), lost = self._mix_airmode_disabled((a0, a1, a2, a3), torque)
        return (k0 * b0, k1 * b1, k2 * b2, k3 * b3), lost

    def _mix_airmode_disabled(self, motors: Four, torque: Vec3) -> tuple[Four, Vec3]:
        """PX4's mixAirmodeDisabled, from the motors without yaw to the motors with as much yaw as is left."""
        low, high = self._low, (1.0, 1.0, 1.0, 1.0)
        down = _four(-t for t in self._thrust)
        motors = _desaturate(motors, down, low, high, increase_only=True)
        motors = _desaturate(motors, self._roll, low, high)
        motors = _desaturate(motors, self._pitch, low, high)
        motors = _four(a + y * torque[2] for a, y in zip(motors, self._yaw, strict=True))
        wider = _four(1.0 + YAW_MARGIN * (1.0 - bottom) for bottom in low)
        motors = _desaturate(motors, self._yaw, low, wider)
        motors = _desaturate(motors, down, low, high, increase_only=True)
        motors = _four(max(bottom, min(1.0, a)) for a, bottom in zip(motors, low, strict=True))
        roll, pitch, yaw = (
            wanted - sum(b * a for b, a in zip(row, motors, strict=True))
            for wanted, row in zip(torque, self._back, strict=True)
        )
        return motors, (_without_rounding(roll), _without_rounding(pitch), _without_rounding(yaw))


def _four(values: Iterable[float]) -> Four:
    a, b, c, d = map(float, values)
    return (a, b, c, d)


def _without_rounding(lost: float) -> float:
    """``lost``, or 0 where it is only the arithmetic's: a loss stops an integral, so it must be one."""
    return lost if abs(lost) > 1e-9 else 0.0


def _scale_of_a_tilting_axis(column: NDArray[Any]) -> float:
    """PX4's scale of the roll and pitch columns: their norm, over half the number of rotors that take part."""
    taking_part = int((np.abs(column) > 1e-3 * np.abs(column).max()).sum())
    return float(np.sqrt(column @ column / (taking_part / 2.0)))


def _desaturation_gain(motors: Four, along: Four, low: Four, high: Four) -> float:
    """How far to go ``along`` to bring the motors that are out of range closest to it, from both sides."""
    least = most = 0.0
    for motor, step, bottom, top in zip(motors, along, low, high, strict=True):
        if abs(step) < WEAK:
            continue
        if motor < bottom:
            k = (bottom - motor) / step
        elif motor > top:
            k = (top - motor) / step
        else:
            continue
        least, most = min(least, k), max(most, k)
    return least + most


def _desaturate(motors: Four, along: Four, low: Four, high: Four, increase_only: bool = False) -> Four:
    """Motors moved ``along`` a direction to relieve saturation; ``increase_only``: never against it."""
    gain = _desaturation_gain(motors, along, low, high)
    if increase_only and gain < 0.0:
        return motors
    a, b, c, d = (motor + gain * step for motor, step in zip(motors, along, strict=True))
    half = 0.5 * _desaturation_gain(
        (a, b, c, d), along, low, high
    )  # the second, halved pass balances what the first overdid
    return (a + half * along[0], b + half * along[1], c + half * along[2], d + half * along[3])
