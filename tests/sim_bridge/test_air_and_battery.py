"""Chance, gusts, drag, the rotors' own motion, the battery."""

from __future__ import annotations

import itertools
import math
import statistics
from typing import Any

import numpy as np
import pytest

from companion.config.vehicle import load_vehicle
from companion.frames import Vec3
from companion.world import Battery, Deviations, Event, World
from companion.world.air import DrydenGusts, Gusts
from companion.world.machine import RotorDynamics
from sim_bridge.gusts import GustyAir
from sim_bridge.noise import FirstOrder, RandomStream, SecondOrder, normals
from sim_bridge.plant import Plant
from sim_bridge.rotors import spinning
from tests.support.plant_client import Client

STILL: Vec3 = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)


def hovering(*events: Event, vehicle: str = "x500", **world: Any) -> Client:
    return Client(vehicle, World(events=events, **world), endpoints=2)


# Chance


@pytest.mark.parametrize("a", [0.01, 0.3, 2.0])
def test_processes_have_their_variance_and_memory_whatever_the_step(a: float) -> None:
    draw = normals(1, RandomStream.GUSTS)
    one, two = FirstOrder(draw, a, 1.0), SecondOrder(draw, a, 1.0)
    n = 40_000
    x, y = [], []
    for _ in range(n):
        x.append(one.update())
        two.update()
        y.append((two.x, two.y))
    few = 4.0 / math.sqrt(n * min(1.0, a))
    assert statistics.pvariance(x, 0.0) == pytest.approx(1.0, abs=2 * few)
    covariance = np.array(y).T @ np.array(y) / n
    assert covariance == pytest.approx(np.array([[1.0, 0.5], [0.5, 0.5]]), abs=2 * few)
    lagged = sum(p * q for p, q in itertools.pairwise(x)) / n
    assert lagged == pytest.approx(math.exp(-a), abs=2 * few)


def test_a_process_is_the_same_whether_it_goes_in_one_step_or_in_many() -> None:
    """The exact solution: means after two half steps are those of a whole one."""
    half, whole = SecondOrder(lambda: 0.0, 0.5, 1.0), SecondOrder(lambda: 0.0, 1.0, 1.0)
    for process in (half, whole):
        process.x, process.y = 2.0, -1.0
    half.update()
    half.update()
    whole.update()
    assert (half.x, half.y) == pytest.approx((whole.x, whole.y))


# Air

TICK = 0.05


def flown_through(gusts: Gusts | DrydenGusts, wind_n: Vec3, airspeed: float, seconds: float) -> np.ndarray:  # type: ignore[type-arg]
    air = GustyAir(gusts, wind_n, TICK, normals(3, RandomStream.GUSTS))
    return np.array([air.update(10.0, (airspeed, 0.0, 0.0)) for _ in range(round(seconds / TICK))])


def test_gusts_have_drydens_strength_in_the_winds_own_axes() -> None:
    felt = flown_through(Gusts((2.0, 1.0, 0.5), (10.0, 10.0, 10.0)), (3.0, 4.0, 0.0), 10.0, 1500.0)
    along = felt @ np.array([0.6, 0.8, 0.0])
    across = felt @ np.array([-0.8, 0.6, 0.0])
    assert [along.std(), across.std(), felt[:, 2].std()] == pytest.approx([2.0, 1.0, 0.5], rel=0.08)
    assert abs(np.mean(along * across)) < 0.15


def test_gusts_have_drydens_spectra() -> None:
    """MIL-F-8785C's forms, by the autocorrelation: exp(-x) along, exp(-x) (1 - x / 2) across, x = V t / L."""
    felt = flown_through(Gusts((1.0, 1.0, 1.0), (10.0, 10.0, 10.0)), (5.0, 0.0, 0.0), 10.0, 2500.0)
    for x in (0.5, 1.0, 2.0, 3.0):
        lag = round(x / TICK)
        north, east, down = (np.mean(felt[lag:, i] * felt[:-lag, i]) for i in range(3))
        assert north == pytest.approx(math.exp(-x), abs=0.08)
        assert east == pytest.approx(math.exp(-x) * (1.0 - x / 2.0), abs=0.08)
        assert down == pytest.approx(math.exp(-x) * (1.0 - x / 2.0), abs=0.08)


def test_the_low_altitude_model_is_mil_f_8785cs() -> None:
    """At 200 ft and 30 knots at 20 ft: sigma_w = 3 kn, sigma_u = 3 / (0.177 + 0.1646)^0.4, L_u = 200 / 0.3416^1.2."""
    knots, feet = 0.514444, 0.3048
    gusts = DrydenGusts(30.0 * knots).at(200.0 * feet)
    assert gusts.sigma == pytest.approx((4.610 * knots, 4.610 * knots, 3.0 * knots), rel=1e-3)
    assert gusts.length == pytest.approx((725.8 * feet, 725.8 * feet, 200.0 * feet), rel=1e-3)
    assert DrydenGusts(5.0).at(0.0) == DrydenGusts(5.0).at(3.0)


def test_drag_in_the_rotors_plane_leaves_the_climb_alone() -> None:
    vehicle = load_vehicle("x500")
    world = World(wind_n=(5.0, 0.0, -4.0), truth=Deviations(drag=0.0, rotor_drag=0.3))
    plant = Plant(vehicle, world, 250)
    plant.fly((0.0, 0.0, -100.0), STILL, LEVEL, STILL, (0.0,) * 4)
    for _ in range(250):
        plant.step(None)
    g = vehicle.gravity
    assert plant.truth.v_n == pytest.approx((5.0 * (1.0 - math.exp(-0.3)), 0.0, g), rel=1e-9)


def test_quadratic_drag_has_its_terminal_speed() -> None:
    vehicle = load_vehicle("x500")
    plant = Plant(vehicle, World(truth=Deviations(drag=0.0, quadratic_drag=0.1)), 250)
    plant.fly((0.0, 0.0, -1000.0), STILL, LEVEL, STILL, (0.0,) * 4)
    terminal = math.sqrt(vehicle.gravity / 0.1)
    for _ in range(250):
        plant.step(None)
    assert plant.truth.v_n[2] == pytest.approx(terminal * math.tanh(vehicle.gravity / terminal), rel=1e-8)


# Rotors and battery


def test_the_papers_rotors_follow_their_equation() -> None:
    """I_rz Omega' = -b Omega |Omega| + tau in small Euler steps, through zero and back."""
    rotors = load_vehicle("paper").rotors
    dynamics = RotorDynamics(inertia=2e-4, thrust_factor=1e-4)
    step, small = 0.02, 2_000
    course = spinning(step, rotors, dynamics)
    thrusts = (9.0, 0.0, -4.0, 2.0)
    omega = [math.copysign(math.sqrt(abs(f) / 1e-4), f) for f in thrusts]
    for wanted in ((5.0, 5.0, 5.0, 0.0), (-20.0, -1.0, 30.0, 0.5), (0.0, 2.0, -30.0, -0.5)):
        _, middle, thrusts = course(thrusts, wanted)
        for i in range(small):
            for j, (rotor, goal) in enumerate(zip(rotors, wanted, strict=True)):
                tau = goal * rotor.torque_per_thrust
                b = dynamics.thrust_factor * rotor.torque_per_thrust
                omega[j] += step / small * (tau - b * omega[j] * abs(omega[j])) / dynamics.inertia
            if i == small // 2 - 1:
                assert middle == pytest.approx([1e-4 * w * abs(w) for w in omega], abs=5e-3)
        assert thrusts == pytest.approx([1e-4 * w * abs(w) for w in omega], abs=5e-3)


def test_the_frame_feels_the_motors_torque_not_the_rotors_drag() -> None:
    vehicle = load_vehicle("x500")
    plant = Plant(vehicle, World(truth=Deviations(drag=0.0, rotors=RotorDynamics(1e-4, 8.5e-6))), 1000)
    plant.fly((0.0, 0.0, -100.0), STILL, LEVEL, STILL, (0.0,) * 4)
    plant.step((1.0, 1.0, 0.0, 0.0))  # both ccw
    torque = 2.0 * 0.016 * 8.54858
    assert plant.truth.w_b[2] == pytest.approx(torque / 0.04 * 1e-3, rel=1e-6)
    assert plant.truth.thrust < 0.1  # they have hardly begun to turn


def test_a_vehicle_with_the_papers_rotors_flies() -> None:
    client = hovering(truth=Deviations(rotors=RotorDynamics(4e-5, 8.5e-6)))
    client.run(3.0)
    assert client.bridge.truth.p_n == pytest.approx((0.0, 0.0, -10.0), abs=0.05)


BATTERY = Battery(capacity=600.0, resistance=0.03, full_current=60.0, idle_current=0.5)


def test_a_battery_sags_with_the_current_and_thrust_with_the_voltage() -> None:
    vehicle = load_vehicle("x500")
    plant = Plant(vehicle, World(battery=BATTERY), 250)
    plant.fly((0.0, 0.0, -100.0), STILL, LEVEL, STILL, (0.0,) * 4)
    assert plant.cells is not None
    for _ in range(250):
        plant.step((0.6, 0.6, 0.6, 0.6))
    cells = plant.cells
    share = plant.truth.thrust / vehicle.thrust_max
    assert share == pytest.approx(0.6 * (cells.voltage / 16.2) ** 2, rel=1e-3)
    assert cells.current == pytest.approx(0.5 + 60.0 * share**1.5, rel=1e-9)
    assert cells.voltage == pytest.approx(14.4 + 1.8 * cells.charge - 0.03 * cells.current)
    assert cells.charge == pytest.approx(1.0 - cells.current / 600.0, abs=0.01)


def test_the_battery_is_told_and_the_vehicle_holds_its_height_on_what_is_left() -> None:
    client = hovering(battery=BATTERY)
    client.run(8.0)
    said = client.last("SYS_STATUS")
    cells = client.bridge.plant.cells
    assert cells is not None
    assert said["voltage_battery"] == pytest.approx(1e3 * cells.voltage, abs=60)
    assert said["current_battery"] == pytest.approx(1e2 * cells.current, abs=100)
    assert said["battery_remaining"] == pytest.approx(100.0 * cells.charge, abs=2.0)
    assert client.command(512, 147) == 0
    values = client.last("BATTERY_STATUS")
    assert values["voltages"][0] < 16_000
    assert values["battery_remaining"] == pytest.approx(100.0 * cells.charge, abs=2.0)
    taken = (BATTERY.charge - cells.charge) * BATTERY.capacity / 3.6
    assert values["current_consumed"] == pytest.approx(taken, rel=0.02)
    assert 5 <= values["time_remaining"] <= 600
    parameters = client.bridge.autopilot.parameters
    assert parameters["BAT1_CAPACITY"] == pytest.approx(600.0 / 3.6)
    assert (parameters["BAT1_N_CELLS"], parameters["BAT1_V_CHARGED"]) == (4, 4.05)
    assert client.height == pytest.approx(10.0, abs=0.3)


def test_a_battery_too_weak_to_fly_is_refused() -> None:
    with pytest.raises(ValueError, match="expected it to be able to fly"):
        hovering(battery=Battery(600.0, 0.03, 60.0, full=16.2, empty=8.0, charge=0.1))
