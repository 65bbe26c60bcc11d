"""Motor commands: the paper's own chain. Snap -> torques and thrust -> M^-1 -> commands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from companion.allocation import Allocation, Four
from companion.estimation.predictor import extrapolate
from companion.estimation.translation import acceleration
from companion.frames import Vec3, rotation_matrix, upright_error
from companion.law.flight import Flying, Law
from companion.law.hold import HoldLaw
from companion.steering.steering import Aim, Along, Steered
from companion.thrust_range import ThrustRange, thrust_range
from companion.vehicle import MotorSetpoint, Vehicle, VehicleState

NO_DISTURBANCE: Vec3 = (0.0, 0.0, 0.0)
"""m/s^2, NED: motors are flown without an estimate of it."""
LEVEL_FREQUENCY = 6.0
"""rad/s of the PD law that levels, critically damped. Engineering choice: PX4's MC_ROLL_P is 6.5 1/s."""
YAW_DAMPING = 4.0
"""1/s, with which it stops the turning. Engineering choice."""


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
        predicted = state
        if dt != 0.0:
            horizon = half + self.vehicle.motor_lag
            until_then = _mean(acting, sent, horizon, self.vehicle.motor_lag)
            predicted = extrapolate(state, *self._motion(state, until_then), horizon)
        flying = Flying(
            p_n=predicted.p_n,
            v_n=predicted.v_n,
            r_nb=rotation_matrix(predicted.q_nb),
            zeta=middle,
            w_b=predicted.w_b,
            zeta_dot=zeta_dot + half * zeta_ddot,
            drag=self.vehicle.drag,
            s=aim.s if isinstance(aim, Along) else 0.0,
        )
        command = self.law(flying, aim.speed_scale) if isinstance(aim, Along) else self.hold(flying, *aim)
        later, later_dot, bound = self.range.twice_integrated(zeta, zeta_dot, command.zeta_derivative, dt)
        allocated = self.allocation.allocate((middle, *command.turn))
        sent = self.allocation.wrench(allocated.commands)
        return Steered(
            setpoint=MotorSetpoint(allocated.commands),
            memory=Extension(later, sent, acting, later_dot, command.zeta_derivative),
            command=command,
            zeta=later,
            zeta_dot=later_dot,
            thrust_n=sent[0] if allocated.saturated else middle,
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
        vehicle, r = self.vehicle, state.r_nb
        thrust, u2, u3, u4 = acting
        f = thrust / vehicle.mass
        thrust_n = (f * r[2], f * r[5], f * r[8])
        jx, jy, jz = vehicle.inertia
        p, q, w = state.w_b
        return acceleration(thrust_n, state.v_n, vehicle.gravity, vehicle.drag, NO_DISTURBANCE), (
            (u2 - (jz - jy) * q * w) / jx,
            (u3 - (jx - jz) * w * p) / jy,
            (u4 - (jy - jx) * p * q) / jz,
        )

    def _levelling_torque(self, state: VehicleState) -> Vec3:
        """N m: a PD law on the thrust axis, critically damped, without a heading."""
        error_x, error_y = upright_error(state.r_nb)
        p, q, r = state.w_b
        jx, jy, jz = self.vehicle.inertia
        k = LEVEL_FREQUENCY
        return (
            jx * (k * k * error_x - 2.0 * k * p), jy * (k * k * error_y - 2.0 * k * q), -jz * YAW_DAMPING * r
        )  # fmt: skip


def _lagged(acting: Four, sent: Four, dt: float, lag: float) -> Four:
    """What rotors with a first-order ``lag`` (s) make ``dt`` later of what is sent."""
    return _between(sent, acting, math.exp(-dt / lag) if lag > 0.0 else 0.0)


def _mean(acting: Four, sent: Four, horizon: float, lag: float) -> Four:
    """The mean of it over ``horizon`` (s)."""
    ratio = lag / horizon * -math.expm1(-horizon / lag) if lag > 0.0 else 0.0
    return _between(sent, acting, ratio)


def _between(a: Four, b: Four, ratio: float) -> Four:
    (a1, a2, a3, a4), (b1, b2, b3, b4) = a, b
    return (a1 + (b1 - a1) * ratio, a2 + (b2 - a2) * ratio, a3 + (b3 - a3) * ratio, a4 + (b4 - a4) * ratio)


def motor_steering(law: Law, hold: HoldLaw, vehicle: Vehicle) -> MotorSteering:
    """Steering for ``vehicle``. AllocationError: rotors that cannot make every thrust and torque."""
    allocation = Allocation(vehicle)
    _ = allocation.inverse
    return MotorSteering(law, hold, vehicle, allocation, thrust_range(vehicle))
