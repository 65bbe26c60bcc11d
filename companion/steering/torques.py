"""Torques and thrust: the law at the level of motors, with PX4's own allocator in the place of M^-1.

What the motors would be told is told to PX4 as the torque and thrust setpoint of which its allocator makes just these
motor commands. They lie within their ranges, so that it has nothing to give up.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.estimation.learned import Learned
from companion.px4_allocation import Px4Allocation
from companion.steering.motors import MotorSteering
from companion.steering.steering import Aim, Steered, SteeringMemory
from companion.vehicle import MotorSetpoint, Setpoint, TorqueSetpoint, VehicleState


@dataclass(frozen=True, slots=True)
class TorqueSteering:
    """Motor steering, told to PX4's allocator."""

    motors: MotorSteering
    allocation: Px4Allocation

    def begin(self, state: VehicleState) -> SteeringMemory:
        """See Steering."""
        return self.motors.begin(state)

    def steer(
        self, memory: SteeringMemory, state: VehicleState, dt: float, aim: Aim, round_trip: float | None = None
    ) -> Steered:
        """See Steering."""
        steered = self.motors.steer(memory, state, dt, aim, round_trip)
        return steered._replace(setpoint=self._torque_setpoint(steered.setpoint))

    def learn(self, memory: SteeringMemory) -> SteeringMemory:
        """See Steering."""
        return self.motors.learn(memory)

    def level_setpoint(self, state: VehicleState | None, memory: SteeringMemory | None = None) -> TorqueSetpoint:
        """See Steering."""
        return self._torque_setpoint(self.motors.level_setpoint(state, memory))

    def learned_values(self, memory: SteeringMemory) -> Learned | None:
        """See Steering."""
        return self.motors.learned_values(memory)

    def _torque_setpoint(self, setpoint: Setpoint) -> TorqueSetpoint:
        assert isinstance(setpoint, MotorSetpoint)
        a, b, c, d = setpoint.commands
        return TorqueSetpoint(*self.allocation.setpoint((a, b, c, d)))


def torque_steering(motors: MotorSteering) -> TorqueSteering:
    """``motors``, told to its vehicle's allocator."""
    return TorqueSteering(motors, Px4Allocation(motors.vehicle))
