"""M and M^-1, and what saturation takes."""

from __future__ import annotations

import dataclasses
import math
import random

import numpy as np
import pytest

from companion.allocation import Allocation, AllocationError, mixing_matrix
from companion.config.vehicle import load_vehicle
from companion.vehicle import Rotor, Spin, Vehicle
from sim_bridge.rigid_body import body_of, derivative_of


def random_vehicle(rng: random.Random) -> Vehicle:
    """Rotors anywhere round the centre, not symmetric, in any order of quadrants, each with its own figures."""
    rotors = []
    for index in range(4):
        around = math.pi / 4 + index * math.pi / 2 + rng.uniform(-0.4, 0.4)
        arm = rng.uniform(0.1, 0.4)
        spin = Spin.CCW if index % 2 == 0 else Spin.CW
        place = (arm * math.cos(around), arm * math.sin(around), rng.uniform(-0.05, 0.05))
        rotors.append(Rotor(place, spin, rng.uniform(4.0, 9.0), rng.uniform(0.01, 0.03)))
    return Vehicle("random", 1.0, (0.02, 0.02, 0.03), tuple(rotors))


def test_the_papers_matrix_falls_out_of_its_vehicle_file() -> None:
    c, d = 60.0, 0.1
    paper = np.array([[c, c, c, c], [0, -c * d, 0, c * d], [c * d, 0, -c * d, 0], [1, -1, 1, -1]])
    assert np.allclose(mixing_matrix(load_vehicle("paper")), paper, rtol=1e-12)


def test_signs_of_an_x() -> None:
    """PX4's order: front right, rear left, front left, rear right."""
    M = np.array(mixing_matrix(load_vehicle("x500")))
    assert list(np.sign(M[1])) == [-1, 1, 1, -1]  # a rotor on the right rolls left
    assert list(np.sign(M[2])) == [1, -1, 1, -1]  # a rotor in front pitches up
    assert list(np.sign(M[3])) == [1, 1, -1, -1]  # a counter-clockwise rotor yaws right


@pytest.mark.parametrize("seed", range(20))
def test_inverse_and_round_trip_for_any_geometry(seed: int) -> None:
    rng = random.Random(seed)
    vehicle = random_vehicle(rng)
    allocation = Allocation(vehicle)
    assert np.allclose(np.array(mixing_matrix(vehicle)) @ np.array(allocation.inverse), np.eye(4), atol=1e-9)
    u = (12.0, rng.gauss(0, 0.2), rng.gauss(0, 0.2), rng.gauss(0, 0.02))
    assert allocation.wrench(allocation.commands(u)) == pytest.approx(u, abs=1e-9)
    assert tuple(np.array(mixing_matrix(vehicle)) @ np.array(allocation.motor_torques(u))) == pytest.approx(u)


@pytest.mark.parametrize("seed", range(20))
def test_two_derivations_of_the_wrench(seed: int) -> None:
    """Random motor commands give the same wrench through M and through the plant's own sum over its rotors."""
    rng = random.Random(seed)
    vehicle = random_vehicle(rng)
    commands = (rng.random(), rng.random(), rng.random(), rng.random())
    thrusts = [c * rotor.thrust_max for c, rotor in zip(commands, vehicle.rotors, strict=True)]
    level_and_still = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    rates = derivative_of(body_of(vehicle))(*level_and_still, *thrusts, 0.0, 0.0, vehicle.gravity, 0.0)
    thrust, *torque = Allocation(vehicle).wrench(commands)
    assert vehicle.mass * (vehicle.gravity - rates[2]) == pytest.approx(thrust)
    assert [j * w for j, w in zip(vehicle.inertia, rates[7:], strict=True)] == pytest.approx(torque)


@pytest.mark.parametrize("seed", range(200))
def test_saturation_keeps_limits_and_tells_what_it_took(seed: int) -> None:
    rng = random.Random(seed)
    vehicle = load_vehicle("x500") if seed % 2 else random_vehicle(rng)
    allocation = Allocation(vehicle)
    u = (rng.uniform(-5, 45), rng.gauss(0, 2), rng.gauss(0, 2), rng.gauss(0, 0.6))
    commands, lost, saturated = allocation.allocate(u)
    assert all(-1e-12 <= c <= 1.0 + 1e-12 for c in commands)
    made = allocation.wrench(commands)
    assert tuple(m + x for m, x in zip(made, lost, strict=True)) == pytest.approx(u, abs=1e-9)
    fits = all(0.0 <= c <= 1.0 for c in allocation.commands(u))
    assert saturated is not fits
    if fits:
        assert lost == (0.0, 0.0, 0.0, 0.0)


def test_yaw_goes_first_then_thrust_then_roll_and_pitch() -> None:
    allocation = Allocation(load_vehicle("x500"))
    thrust, roll, pitch, yaw = allocation.wrench(allocation.allocate((20.0, 0.5, -0.3, 5.0)).commands)
    assert (thrust, roll, pitch) == pytest.approx((20.0, 0.5, -0.3))
    assert 0.0 < yaw < 5.0
    thrust, roll, pitch, yaw = allocation.wrench(allocation.allocate((34.0, 1.0, 0.0, 0.1)).commands)
    assert (roll, pitch) == pytest.approx((1.0, 0.0), abs=1e-9)
    assert thrust < 34.0
    _, roll, pitch, _ = allocation.wrench(allocation.allocate((20.0, 9.0, 4.5, 0.0)).commands)
    assert 0.0 < roll < 9.0
    assert roll / pitch == pytest.approx(2.0, rel=1e-6)  # the direction stays


def test_rotors_that_cannot_yaw_are_refused() -> None:
    x500 = load_vehicle("x500")
    same = tuple(dataclasses.replace(rotor, spin=Spin.CW) for rotor in x500.rotors)
    with pytest.raises(AllocationError, match="cannot make every"):
        _ = Allocation(dataclasses.replace(x500, rotors=same)).inverse


@pytest.mark.parametrize("name", ["x500", "sih"])
@pytest.mark.parametrize("weak", range(4))
def test_the_weakest_rotor_is_told_from_where_the_frame_dips(name: str, weak: int) -> None:
    vehicle = load_vehicle(name)
    allocation = Allocation(vehicle)
    asked = (vehicle.weight, 0.05, -0.08, 0.01)
    commands = list(allocation.commands(asked))
    commands[weak] *= 0.5
    _, roll, pitch, _ = allocation.wrench((commands[0], commands[1], commands[2], commands[3]))
    assert allocation.weakest(asked, (asked[1] - roll, asked[2] - pitch)) == pytest.approx(0.5)
    assert allocation.weakest(asked, (0.0, 0.0)) == 1.0
