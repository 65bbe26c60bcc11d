"""Motor commands: the paper's own chain. Snap -> torques and thrust -> M^-1 -> commands."""

from __future__ import annotations

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
    """The thrust the law integrates (zeta N, zeta_dot N/s), its last zeta_ddot, and the torques last sent (N m)."""

    zeta: float
    zeta_dot: float = 0.0
    zeta_ddot: float = 0.0
    torque: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class MotorSteering:
    """The law at the level of motors for one vehicle.

    A command is held until the next one, so it acts as if it came half a step late. The law is therefore evaluated at
    the state in the middle of that time; at 1 kHz the paper's case 2 then flies within 0.001 deg of its exact tilt.
    """

    law: Law
    hold: HoldLaw
    vehicle: Vehicle
    allocation: Allocation
    range: ThrustRange

    def begin(self, state: VehicleState) -> Extension:
        """zeta = m g, zeta_dot = 0 (the paper's section V)."""
        return Extension(self.vehicle.weight)

    def steer(
        self, memory: Extension, state: VehicleState, dt: float, aim: Aim, link_delay: float | None = None
    ) -> Steered:
        """See Steering."""
        half = 0.5 * dt
        zeta, zeta_dot, zeta_ddot, _ = memory
        middle = zeta + half * zeta_dot
        there = state if dt == 0.0 else advanced(state, *self._motion(state, memory), half)
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
            memory=Extension(later, later_dot, command.zeta_derivative, command.turn),
            command=command,
            zeta=later,
            zeta_dot=later_dot,
            thrust_n=middle,
            saturated=bound or allocated.saturated,
            thrust_share=middle / self.vehicle.thrust_max,
        )

    def level(self, state: VehicleState | None, memory: Extension | None = None) -> MotorSetpoint:
        """Hover thrust, and from a fresh state the torques that turn the thrust axis up and stop the turning."""
        torque = (0.0, 0.0, 0.0) if state is None else self._levelling_torque(state)
        u: Four = (self.vehicle.weight, *torque)
        return MotorSetpoint(self.allocation.allocate(u).commands)

    def _motion(self, state: VehicleState, memory: Extension) -> tuple[Vec3, Vec3]:
        """Acceleration (world) and body acceleration under the command that acts now (Eqs. 1 and 2)."""
        vehicle = self.vehicle
        r = state.r_nb
        lift = memory.zeta / vehicle.mass
        c = vehicle.drag
        vx, vy, vz = state.v_n
        acceleration = (-lift * r[2] - c * vx, -lift * r[5] - c * vy, vehicle.gravity - lift * r[8] - c * vz)
        jx, jy, jz = vehicle.inertia
        p, q, w = state.w_b
        u2, u3, u4 = memory.torque
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


def motor_steering(law: Law, hold: HoldLaw, vehicle: Vehicle) -> MotorSteering:
    """Steering for ``vehicle``. AllocationError: rotors that cannot make every thrust and torque."""
    allocation = Allocation(vehicle)
    _ = allocation.inverse
    return MotorSteering(law, hold, vehicle, allocation, thrust_range(vehicle))
