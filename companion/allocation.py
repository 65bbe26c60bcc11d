"""M and M^-1: motor torques to thrust and body torques and back (the paper's section II), limits, and what they took.

The paper's tau are motor torques: a rotor with torque per thrust k = 1/c makes the thrust f = tau/k. M follows from
where the rotors sit and how they turn; the paper's own matrix falls out of ``configs/vehicles/paper.yaml``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from companion.vehicle import CompanionError, Vehicle

Four = tuple[float, float, float, float]
Matrix4 = tuple[Four, Four, Four, Four]


class AllocationError(CompanionError):
    """Rotors that cannot make every thrust and torque."""


class Allocated(NamedTuple):
    """``commands``: in each rotor's command range. ``lost``: what saturation took from the thrust (N) and torques (N m)
    asked for. ``saturated``: whether any rotor stands at its limit."""

    commands: Four
    lost: Four
    saturated: bool


def mixing_matrix(vehicle: Vehicle) -> Matrix4:
    """M: (u1, u2, u3, u4) = M (tau_1, .., tau_4), thrust along -z_b and torques about the body axes.

    A rotor at (x, y) lifting f puts r x F = (-y f, x f) about roll and pitch; its drag puts +-tau about yaw.
    """
    columns = []
    for rotor in vehicle.rotors:
        c = 1.0 / rotor.torque_per_thrust
        x, y, _ = rotor.position_b
        columns.append((c, 0.0 - y * c, 0.0 + x * c, rotor.spin.reaction))
    return tuple(zip(*columns, strict=True))  # type: ignore[return-value]


@dataclass(frozen=True)
class Allocation:
    """M^-1 of one vehicle, with its command limits."""

    vehicle: Vehicle

    @cached_property
    def inverse(self) -> Matrix4:
        """M^-1. AllocationError: the rotors do not span thrust and torques."""
        M = np.array(mixing_matrix(self.vehicle))
        scaled = M / np.linalg.norm(M, axis=1, keepdims=True)
        if np.linalg.cond(scaled) > 1e6:
            raise AllocationError(f"{self.vehicle.name}: its rotors cannot make every thrust and torque")
        return tuple(tuple(float(v) for v in row) for row in np.linalg.inv(M))  # type: ignore[return-value]

    @cached_property
    def _to_commands(self) -> Matrix4:
        """M^-1 with a command in the place of each motor torque."""
        scaled = (
            tuple(entry / (rotor.torque_per_thrust * rotor.thrust_max) for entry in row)
            for rotor, row in zip(self.vehicle.rotors, self.inverse, strict=True)
        )
        return tuple(scaled)  # type: ignore[return-value]

    @cached_property
    def effectiveness(self) -> Matrix4:
        """M with a command in the place of each motor torque: thrust (N) and torques (N m) per command."""
        rows = (
            tuple(
                m * rotor.torque_per_thrust * rotor.thrust_max
                for m, rotor in zip(row, self.vehicle.rotors, strict=True)
            )
            for row in mixing_matrix(self.vehicle)
        )
        return tuple(rows)  # type: ignore[return-value]

    @cached_property
    def thrust_max(self) -> float:
        """N, all rotors at the top of their command range."""
        return self.vehicle.thrust_max

    @cached_property
    def _ranges(self) -> tuple[tuple[float, float], ...]:
        return tuple(rotor.command for rotor in self.vehicle.rotors)

    def motor_torques(self, u: Four) -> Four:
        """tau = M^-1 u, N m, without limits."""
        return _times(self.inverse, u)

    def commands(self, u: Four) -> Four:
        """The commands that make thrust and torques ``u`` (N, N m), without limits."""
        return _times(self._to_commands, u)

    def wrench(self, commands: Four) -> Four:
        """(thrust N, torques N m) of rotor commands."""
        return _times(self.effectiveness, commands)

    def weakest(self, u: Four, missing: tuple[float, float]) -> float:
        """The share of its thrust that the weakest rotor gives, 1 at most: where ``u`` (N, N m) was asked of sound ones
        and ``missing`` (N m) of its roll and pitch did not come, it is the one that sits where the frame dips."""
        mx, my = missing
        dips = [
            ((my * x - mx * y) / (x * x + y * y), rotor.thrust_max * command)
            for rotor, command in zip(self.vehicle.rotors, self.commands(u), strict=True)
            for x, y, _ in (rotor.position_b,)
        ]
        lost, asked = max(dips)
        return 1.0 - max(lost, 0.0) / asked if asked > lost else 0.0

    def allocate(self, u: Four) -> Allocated:
        """Commands within their ranges, giving up yaw first, then thrust, then roll and pitch.

        The direction of the thrust carries the vehicle: yaw can wait, and a thrust that is a little off comes back
        sooner than an attitude that is.
        """
        wanted = self.commands(u)
        if self._within(wanted):
            return Allocated(wanted, (0.0, 0.0, 0.0, 0.0), False)
        base = self.commands((0.0, u[1], u[2], 0.0))
        thrust_only = self.commands((1.0, 0.0, 0.0, 0.0))
        yaw_only = self.commands((0.0, 0.0, 0.0, u[3]))
        share = 1.0  # of roll and pitch
        thrust = self._thrust_for(base, thrust_only, u[0])
        if thrust is None:
            low, high = 0.0, 1.0
            for _ in range(30):
                middle = 0.5 * (low + high)
                fits = self._thrust_for(_scaled(base, middle), thrust_only, u[0]) is not None
                low, high = (middle, high) if fits else (low, middle)
            share = low
            thrust = self._thrust_for(_scaled(base, share), thrust_only, u[0])
            assert thrust is not None
        carried = _sum(_scaled(base, share), _scaled(thrust_only, thrust))
        commands = self._clamped(_sum(carried, _scaled(yaw_only, self._share_for(carried, yaw_only))))
        achieved = self.wrench(commands)
        a, b, c, d = (asked - made for asked, made in zip(u, achieved, strict=True))
        return Allocated(commands, (a, b, c, d), True)

    def _within(self, commands: Four) -> bool:
        a, b, c, d = commands
        (a0, a1), (b0, b1), (c0, c1), (d0, d1) = self._ranges
        return a0 <= a <= a1 and b0 <= b <= b1 and c0 <= c <= c1 and d0 <= d <= d1

    def _clamped(self, commands: Four) -> Four:
        a, b, c, d = (
            min(max(command, rotor.command[0]), rotor.command[1])
            for rotor, command in zip(self.vehicle.rotors, commands, strict=True)
        )
        return (a, b, c, d)

    def _thrust_for(self, base: Four, per_newton: Four, wanted: float) -> float | None:
        """The thrust nearest to ``wanted`` that leaves room for ``base`` on every rotor; None if there is none."""
        low, high = -float("inf"), float("inf")
        for rotor, offset, slope in zip(self.vehicle.rotors, base, per_newton, strict=True):
            bounds = sorted(((rotor.command[0] - offset) / slope, (rotor.command[1] - offset) / slope))
            low, high = max(low, bounds[0]), min(high, bounds[1])
        return min(max(wanted, low), high) if low <= high else None

    def _share_for(self, base: Four, extra: Four) -> float:
        """The largest share 0..1 of ``extra`` that fits on top of ``base``."""
        share = 1.0
        for rotor, offset, add in zip(self.vehicle.rotors, base, extra, strict=True):
            if add > 0.0:
                share = min(share, (rotor.command[1] - offset) / add)
            elif add < 0.0:
                share = min(share, (rotor.command[0] - offset) / add)
        return max(share, 0.0)


def _times(matrix: Matrix4, u: Four) -> Four:
    (a1, a2, a3, a4), (b1, b2, b3, b4), (c1, c2, c3, c4), (d1, d2, d3, d4) = matrix
    x, y, z, w = u
    return (
        a1 * x + a2 * y + a3 * z + a4 * w,
        b1 * x + b2 * y + b3 * z + b4 * w,
        c1 * x + c2 * y + c3 * z + c4 * w,
        d1 * x + d2 * y + d3 * z + d4 * w,
    )


def _scaled(values: Four, factor: float) -> Four:
    return (values[0] * factor, values[1] * factor, values[2] * factor, values[3] * factor)


def _sum(a: Four, b: Four) -> Four:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3])
