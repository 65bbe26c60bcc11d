"""Motor commands: the paper's own chain. Snap -> torques and thrust -> M^-1 -> commands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from companion.allocation import Allocation, Four
from companion.estimation.prediction import advanced
from companion.frames import Vec3, rotation_matrix, upright_error
from companion.law.flight import Flying, Law
from companion.law.hold import HoldLaw
from companion.steering.steering import Aim, Along, Steered
from companion.steering.thrust import ThrustRange, thrust_range
from companion.vehicle import MotorSetpoint, Vehicle, VehicleState


class Extension(NamedTuple):
    """The thrust the law integrates (zeta N, zeta_dot N/s) and its last zeta_ddot. ``sent``: thrust (N) and torques
    (N m) of the last setpoint; ``acting``: what the rotors, which lag behind, make of them."""

    zeta: float
    sent: Four
    acting: Four
    zeta_dot: float = 0.0
    zeta_ddot: float = 0.0


@dataclass(frozen=True, slots=True)
class MotorSteering:
    """The law at the level of motors for one vehicle.

    A command is held until the next one, so it acts as if it came half a step late, and the rotors follow it with a
    lag. The law is therefore evaluated at the state that much later; at 1 kHz the paper's case 2 (no lag) then flies
    within 0.001 deg of its exact tilt.
    """

    law: Law
    hold: HoldLaw
    vehicle: Vehicle
    allocation: Allocation
    range: ThrustRange

    def begin(self, state: VehicleState) -> Extension:
        """zeta = m g, zeta_dot = 0 (the paper's section V)."""
        hovering = (self.vehicle.weight, 0.0, 0.0, 0.0)
        return Extension(self.vehicle.weight, hovering, hovering)

    def steer(
        self, memory: Extension, state: VehicleState, dt: float, aim: Aim, link_delay: float | None = None
    ) -> Steered:
        """See Steering."""
        half = 0.5 * dt
        zeta, sent, acting, zeta_dot, zeta_ddot = memory
        acting = _lagged(acting, sent, dt, self.vehicle.motor_lag)
        middle = zeta + half * zeta_dot
        there = state
        if dt != 0.0:
            horizon = half + self.vehicle.motor_lag
            until_then = _mean(acting, sent, horizon, self.vehicle.motor_lag)
            there = advanced(state, *self._motion(state, until_then), horizon)
        flying = Flying(
            p_n=there.p_n,
            v_n=there.v_n,
            r_nb=rotation_matrix(there.q_nb),
            zeta=middle,
            w_b=there.w_b,
            zeta_dot=zeta_dot + half * zeta_ddot,
            drag=self.vehicle.drag,
            s=aim.s if isinstance(aim, Along) else 0.0,
        )
        command = self.law(flying, aim.ramp) if isinstance(aim, Along) else self.hold(flying, *aim)
        later, later_dot, bound = self.range.twice_integrated(zeta, zeta_dot, command.zeta_derivative, dt)
        allocated = self.allocation.allocate((middle, *command.turn))
        return Steered(
            setpoint=MotorSetpoint(allocated.commands),
            memory=Extension(
                later, self.allocation.wrench(allocated.commands), acting, later_dot, command.zeta_derivative
            ),
            command=command,
            zeta=later,
            zeta_dot=later_dot,
            thrust_n=middle,
            saturated=bound or allocated.saturated,
            thrust_share=middle / self.allocation.thrust_max,
        )

    def learn(self, memory: Extension) -> Extension:
        """See Steering: motor commands are flown as the vehicle file says."""
        return memory

    def level(self, state: VehicleState | None, memory: Extension | None = None) -> MotorSetpoint:
        """Hover thrust, and from a fresh state the torques that turn the thrust axis up and stop the turning."""
        torque = (0.0, 0.0, 0.0) if state is None else self._levelling_torque(state)
        u: Four = (self.vehicle.weight, *torque)
        return MotorSetpoint(self.allocation.allocate(u).commands)

    def learned(self, memory: Extension) -> None:
        """See Steering: nothing."""

    def _motion(self, state: VehicleState, acting: Four) -> tuple[Vec3, Vec3]:
        """Acceleration (world) and body acceleration under this thrust and these torques (Eqs. 1 and 2)."""
        vehicle = self.vehicle
        r = state.r_nb
        thrust, u2, u3, u4 = acting
        lift = thrust / vehicle.mass
        c = vehicle.drag
        vx, vy, vz = state.v_n
        acceleration = (-lift * r[2] - c * vx, -lift * r[5] - c * vy, vehicle.gravity - lift * r[8] - c * vz)
        jx, jy, jz = vehicle.inertia
        p, q, w = state.w_b
        return acceleration, (
            (u2 - (jz - jy) * q * w) / jx,
            (u3 - (jx - jz) * w * p) / jy,
            (u4 - (jy - jx) * p * q) / jz,
        )

    def _levelling_torque(self, state: VehicleState) -> Vec3:
        """A PD law on the thrust axis, critically damped at 6 rad/s, without a heading."""
        error_x, error_y = upright_error(state.r_nb)
        p, q, r = state.w_b
        jx, jy, jz = self.vehicle.inertia
        return (jx * (36.0 * error_x - 12.0 * p), jy * (36.0 * error_y - 12.0 * q), -jz * 4.0 * r)


def _lagged(acting: Four, sent: Four, dt: float, lag: float) -> Four:
    """What rotors with a first-order ``lag`` (s) make ``dt`` later of what is sent."""
    return _between(sent, acting, math.exp(-dt / lag) if lag > 0.0 else 0.0)


def _mean(acting: Four, sent: Four, horizon: float, lag: float) -> Four:
    """The mean of it over ``horizon`` (s)."""
    share = lag / horizon * -math.expm1(-horizon / lag) if lag > 0.0 else 0.0
    return _between(sent, acting, share)


def _between(a: Four, b: Four, share: float) -> Four:
    (a1, a2, a3, a4), (b1, b2, b3, b4) = a, b
    return (a1 + (b1 - a1) * share, a2 + (b2 - a2) * share, a3 + (b3 - a3) * share, a4 + (b4 - a4) * share)


def motor_steering(law: Law, hold: HoldLaw, vehicle: Vehicle) -> MotorSteering:
    """Steering for ``vehicle``. AllocationError: rotors that cannot make every thrust and torque."""
    allocation = Allocation(vehicle)
    _ = allocation.inverse
    return MotorSteering(law, hold, vehicle, allocation, thrust_range(vehicle))
