"""Motor commands: the paper's own chain. Snap -> torques and thrust -> M^-1 -> commands."""

from __future__ import annotations

from dataclasses import dataclass

from companion.allocation import Allocation, Four
from companion.frames import upright_error
from companion.law.flight import ImplicitLaw, Ramp, Thrust
from companion.steering.steering import Steered
from companion.vehicle import MotorSetpoint, Vehicle, VehicleState

ZETA_MIN, ZETA_MAX, THRUST_SHARE_MAX = 0.25, 1.9, 0.95
"""zeta is kept between these shares of the weight, and below this share of the largest thrust."""
ZETA_DOT_MAX = 3.0
"""weights a second."""
NO_DISTURBANCE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ThrustRange:
    """Where the extension's state may be; on a bound zeta_dot is zero, so that nothing winds up behind it."""

    low: float
    high: float
    rate: float

    def advanced(self, thrust: Thrust, zeta_ddot: float, dt: float) -> tuple[Thrust, bool]:
        """The state ``dt`` later, and whether a bound was met (Eq. 4: two integrators before the thrust)."""
        zeta_dot = thrust.zeta_dot + zeta_ddot * dt
        limited = max(-self.rate, min(self.rate, zeta_dot))
        zeta = thrust.zeta + 0.5 * (thrust.zeta_dot + limited) * dt
        if not self.low <= zeta <= self.high:
            return Thrust(max(self.low, min(self.high, zeta)), 0.0), True
        return Thrust(zeta, limited), limited != zeta_dot


@dataclass(frozen=True, slots=True)
class MotorSteering:
    """The law at the level of motors for one vehicle. Without limits (``range`` None) it is the bare mathematics."""

    law: ImplicitLaw
    vehicle: Vehicle
    allocation: Allocation
    range: ThrustRange | None

    def begin(self) -> Thrust:
        """zeta = m g, zeta_dot = 0 (the paper's section V)."""
        return Thrust(self.vehicle.weight, 0.0)

    def steer(self, thrust: Thrust, state: VehicleState, dt: float, ramp: Ramp) -> Steered:
        """Motor commands for ``state``. Raises LawError."""
        command = self.law(state.p_n, state.v_n, state.r_nb, state.w_b, thrust, NO_DISTURBANCE, ramp)
        saturated = False
        # the command acts from now until the next step, so it carries the thrust of the middle of that time
        middle = thrust.zeta + 0.5 * dt * thrust.zeta_dot
        if self.range is None:
            following = Thrust(
                thrust.zeta + dt * thrust.zeta_dot + 0.5 * dt * dt * command.zeta_derivative,
                thrust.zeta_dot + dt * command.zeta_derivative,
            )
        else:
            following, saturated = self.range.advanced(thrust, command.zeta_derivative, dt)
        allocated = self.allocation.allocate((middle, *command.turn))
        return Steered(MotorSetpoint(allocated.commands), following, command, middle, saturated or allocated.saturated)

    def level(self, state: VehicleState | None) -> MotorSetpoint:
        """Hover thrust, and from a fresh state the torques that turn the thrust axis up and stop the turning."""
        torque = (0.0, 0.0, 0.0) if state is None else self._levelling_torque(state)
        u: Four = (self.vehicle.weight, *torque)
        return MotorSetpoint(self.allocation.allocate(u).commands)

    def _levelling_torque(self, state: VehicleState) -> tuple[float, float, float]:
        """A PD law on the thrust axis, critically damped at 6 rad/s, without a heading."""
        error_x, error_y = upright_error(state.r_nb)
        p, q, r = state.w_b
        jx, jy, jz = self.vehicle.inertia
        return (jx * (36.0 * error_x - 12.0 * p), jy * (36.0 * error_y - 12.0 * q), -jz * 4.0 * r)


def motor_steering(law: ImplicitLaw, vehicle: Vehicle) -> MotorSteering:
    """Steering for ``vehicle``. AllocationError: rotors that cannot make every thrust and torque."""
    allocation = Allocation(vehicle)
    _ = allocation.inverse
    thrust_range = None
    if vehicle.limits is not None:
        high = min(ZETA_MAX * vehicle.weight, THRUST_SHARE_MAX * vehicle.thrust_max)
        thrust_range = ThrustRange(ZETA_MIN * vehicle.weight, high, ZETA_DOT_MAX * vehicle.weight)
    return MotorSteering(law, vehicle, allocation, thrust_range)
