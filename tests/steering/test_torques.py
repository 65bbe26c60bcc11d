"""Torques and thrust for PX4's allocator: what it makes of them are the commands that motors would get."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from companion.config.syntax.document import parse
from companion.config.syntax.file_lookup import find
from companion.config.vehicle import vehicle_from
from companion.frames import Vec3
from companion.px4_allocation import Px4Allocation
from companion.steering.torques import TorqueSteering
from companion.vehicle import MotorSetpoint, Spin, TorqueSetpoint, Vehicle


def shipped(name: str) -> Vehicle:
    path = find(name, "vehicles")
    return vehicle_from(parse(path.read_text(encoding="utf-8"), str(path)))


def px4_mixes(vehicle: Vehicle, torque: Vec3, thrust: float) -> list[float]:
    """PX4's normalised mixer of a symmetric quad X: thrust + yaw + (roll, pitch)/sqrt(2), by each rotor's corner."""
    return [
        thrust
        + rotor.spin.reaction * torque[2]
        - math.copysign(math.sqrt(0.5), rotor.position_b[1]) * torque[0]
        + math.copysign(math.sqrt(0.5), rotor.position_b[0]) * torque[1]
        for rotor in vehicle.rotors
    ]


@pytest.mark.parametrize("name", ["x500", "sih"])
def test_of_a_quad_x_it_is_px4s_mixer(name: str) -> None:
    """Torque 1 = 4 T_max l / sqrt(2) about roll and pitch (l: the lever), 4 T_max kappa about yaw."""
    vehicle, rng = shipped(name), random.Random(1)
    allocation = Px4Allocation(vehicle)
    rotor = vehicle.rotors[0]
    lever = abs(rotor.position_b[1])
    for _ in range(20):
        torque = (rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), rng.uniform(-0.1, 0.1))
        thrust = rng.uniform(0.2, 0.8)
        mixed = px4_mixes(vehicle, torque, thrust)
        assert allocation.commands(torque, thrust) == pytest.approx(mixed, abs=1e-9)
        back, share = allocation.setpoint(allocation.commands(torque, thrust))
        assert (*back, share) == pytest.approx((*torque, thrust), abs=1e-12)
    one_roll = allocation.wrench((1.0, 0.0, 0.0), 0.0)[1]
    one_yaw = allocation.wrench((0.0, 0.0, 1.0), 0.0)[3]
    assert one_roll == pytest.approx(4.0 * rotor.thrust_max * lever / math.sqrt(2.0))
    assert one_yaw == pytest.approx(4.0 * rotor.thrust_max * rotor.torque_per_thrust)


def test_rotors_that_sit_anywhere_get_their_commands_too() -> None:
    vehicle = shipped("x500")
    rotors = tuple(
        replace(rotor, position_b=(x, y, 0.0), spin=spin)
        for rotor, (x, y), spin in zip(
            vehicle.rotors,
            [(0.15, 0.25), (-0.2, -0.22), (0.15, -0.25), (-0.2, 0.22)],
            [Spin.CCW, Spin.CCW, Spin.CW, Spin.CW],
            strict=True,
        )
    )
    allocation = Px4Allocation(replace(vehicle, rotors=rotors))
    commands = (0.3, 0.5, 0.42, 0.61)
    torque, thrust = allocation.setpoint(commands)
    assert allocation.commands(torque, thrust) == pytest.approx(commands)


def test_what_motors_would_be_told_is_told_to_px4s_allocator() -> None:
    vehicle = shipped("x500")
    told = MotorSetpoint((0.3, 0.5, 0.4, 0.6))
    motors: Any = SimpleNamespace(level_setpoint=lambda state, memory=None: told)
    steering = TorqueSteering(motors, Px4Allocation(vehicle))
    level = steering.level_setpoint(None)
    assert isinstance(level, TorqueSetpoint)
    assert level.thrust == pytest.approx(0.45)
    assert Px4Allocation(vehicle).commands(level.torque_b, level.thrust) == pytest.approx(told.commands)
