"""The plant against RotorPy's multirotor, an independent derivation: z up, rotors from the left, SciPy's integrator."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rotorpy.vehicles.hummingbird_params import quad_params as hummingbird
from rotorpy.vehicles.multirotor import Multirotor

from companion.config.vehicle import load_vehicle
from companion.frames import Vec3, normalised
from companion.vehicle import Vehicle
from companion.world import World
from sim_bridge.plant import Plant, Truth

FLIP = np.array([1.0, -1.0, -1.0])
"""Between FRD in NED and FLU in a frame with z up: a half turn about x, in both frames at once."""
THRUST_FACTOR = 1e-5
COMMANDED_EVERY = 0.1


def rotorpy_of(vehicle: Vehicle) -> Any:
    """The same machine in RotorPy, without aerodynamics, at a tight tolerance."""
    jx, jy, jz = vehicle.inertia
    ratio = vehicle.rotors[0].torque_per_thrust
    own = {
        "mass": vehicle.mass, "Ixx": jx, "Iyy": jy, "Izz": jz,
        "rotor_pos": {f"r{i}": FLIP * rotor.position_b for i, rotor in enumerate(vehicle.rotors, 1)},
        "rotor_directions": np.array([-rotor.spin.reaction for rotor in vehicle.rotors]),
        "k_eta": THRUST_FACTOR, "k_m": ratio * THRUST_FACTOR, "rotor_speed_max": 1e4,
    }  # fmt: skip
    tight = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    return Multirotor(hummingbird | own, aero=False, integrator_kwargs=tight)


def flown_by_rotorpy(vehicle: Vehicle, commands: list[tuple[float, ...]], v_n: Vec3, w_b: Vec3) -> list[Any]:
    """(p, v, q wxyz, w) in NED and FRD after each command, the rotors turning as told at once."""
    machine = rotorpy_of(vehicle)
    state = {
        "x": FLIP * (0.0, 0.0, -5000.0), "v": FLIP * v_n, "q": np.array([0.0, 0.0, 0.0, 1.0]), "w": FLIP * w_b,
        "wind": np.zeros(3), "rotor_speeds": np.zeros(4),
    }  # fmt: skip
    after = []
    for command in commands:
        thrusts = [c * rotor.thrust_max for c, rotor in zip(command, vehicle.rotors, strict=True)]
        speeds = np.sqrt(np.array(thrusts) / THRUST_FACTOR)
        state = machine.step(state | {"rotor_speeds": speeds}, {"cmd_motor_speeds": speeds}, COMMANDED_EVERY)
        x, y, z, w = state["q"]
        after.append((FLIP * state["x"], FLIP * state["v"], np.array([w, x, -y, -z]), FLIP * state["w"]))
    return after


def flown_by_the_plant(
    vehicle: Vehicle, commands: list[tuple[float, ...]], v_n: Vec3, w_b: Vec3, steps_per_second: int
) -> list[Truth]:  # fmt: skip
    plant = Plant(vehicle, World(), steps_per_second)
    plant.fly((0.0, 0.0, -5000.0), v_n, (1.0, 0.0, 0.0, 0.0), w_b, (0.0,) * 4)
    after = []
    for a, b, c, d in commands:
        for _ in range(round(COMMANDED_EVERY * steps_per_second)):
            plant.step((a, b, c, d))
        after.append(plant.truth)
    return after


def apart(theirs: Any, ours: Truth) -> float:
    """The largest difference of any number of the state; q and -q are the same attitude."""
    p, v, q, w = theirs
    q = q if np.dot(q, ours.q_nb) > 0.0 else -q
    pairs = ((p, ours.p_n), (v, ours.v_n), (q, normalised(ours.q_nb)), (w, ours.w_b))
    return max(float(np.abs(a - np.array(b)).max()) for a, b in pairs)


@pytest.mark.parametrize("seed", [1, 2])
def test_ten_seconds_of_any_commands_are_rotorpys_to_a_micrometre(seed: int) -> None:
    rng = random.Random(seed)
    vehicle = replace(load_vehicle("x500"), motor_lag=0.0, drag=0.0, gravity=9.81, inertia=(0.02, 0.025, 0.04))
    hover = vehicle.weight / vehicle.thrust_max
    commands = [tuple(hover + rng.uniform(-0.05, 0.05) for _ in range(4)) for _ in range(100)]
    motion = ((3.0, -2.0, 1.0), (0.3, -0.5, 0.8))
    theirs = flown_by_rotorpy(vehicle, commands, *motion)
    errors = {}
    for steps_per_second in (250, 500):
        ours = flown_by_the_plant(vehicle, commands, *motion, steps_per_second)
        errors[steps_per_second] = max(apart(a, b) for a, b in zip(theirs, ours, strict=True))
    assert max(max(map(abs, truth.w_b)) for truth in ours) > 2.0  # it did not just hang there
    assert errors[250] < 1e-6  # at PX4's own step
    assert math.log2(errors[250] / errors[500]) > 3.7


@pytest.mark.parametrize("rotor", range(4))
def test_each_rotor_turns_the_machine_the_same_way(rotor: int) -> None:
    vehicle = replace(load_vehicle("x500"), motor_lag=0.0, drag=0.0, gravity=9.81)
    command = tuple(0.3 if i == rotor else 0.25 for i in range(4))
    theirs = flown_by_rotorpy(vehicle, [command], (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    ours = flown_by_the_plant(vehicle, [command], (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1000)
    assert apart(theirs[0], ours[0]) < 1e-9
