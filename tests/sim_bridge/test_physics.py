"""The plant's physics against closed forms, conservation laws and sums done by hand."""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import replace

import numpy as np
import pytest

from companion.config.vehicle import load_vehicle
from companion.frames import Vec3, euler_from_rotation, quaternion_from_euler, rotation_matrix, tilt, to_world
from companion.vehicle import Rotor, Spin, Vehicle
from companion.world import Deviations, World
from sim_bridge.integrate import Motion, runge_kutta
from sim_bridge.plant import BODY_RATE_MAX, Plant
from sim_bridge.rigid_body import Body, body_of, derivative_of
from sim_bridge.rotors import Four, lagging

STILL: Vec3 = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)
OFF: Four = (0.0, 0.0, 0.0, 0.0)
VEHICLES = ("x500", "sih", "paper")


def bare(name: str = "x500", **changes: float) -> Vehicle:
    """A shipped vehicle without lag and drag, unless ``changes`` says otherwise."""
    return replace(load_vehicle(name), **{"motor_lag": 0.0, "drag": 0.0, **changes})


def in_the_air(vehicle: Vehicle, world: World | None = None, height: float = 100.0, **state: object) -> Plant:
    plant = Plant(vehicle, world or World(), 250)
    given = {"p_n": (0.0, 0.0, -height), "v_n": STILL, "q_nb": LEVEL, "w_b": STILL, "thrusts": OFF, **state}
    plant.fly(**given)  # type: ignore[arg-type]
    return plant


def accelerations(vehicle: Vehicle, thrusts: Four, w_b: Vec3 = STILL) -> tuple[Vec3, Vec3]:
    """(v_n', w_b') of a level vehicle at rest."""
    rates = derivative_of(body_of(vehicle))(
        *STILL, *LEVEL, *w_b, *thrusts, 0.0, 0.0, vehicle.gravity, 0.0
    )  # fmt: skip
    return rates[0:3], rates[7:10]


def test_free_fall_is_a_parabola() -> None:
    plant = in_the_air(bare(), v_n=(3.0, -2.0, 1.0))
    for _ in range(500):
        plant.step(OFF)
    g = plant.vehicle.gravity
    assert plant.truth.t_boot == 2.0
    assert plant.truth.p_n == pytest.approx((6.0, -4.0, -100.0 + 2.0 + 2.0 * g), abs=1e-10)
    assert plant.truth.v_n == pytest.approx((3.0, -2.0, 1.0 + 2.0 * g), abs=1e-11)
    assert plant.truth.a_n == pytest.approx((0.0, 0.0, g), abs=1e-9)


def test_drag_brings_a_falling_body_to_the_speed_of_the_wind() -> None:
    wind = (4.0, -3.0, 0.5)
    plant = in_the_air(bare(drag=0.8), World(wind_n=wind))
    for _ in range(250):
        plant.step(OFF)
    g, c, gone = plant.vehicle.gravity, 0.8, 1.0 - math.exp(-0.8)
    assert plant.truth.v_n == pytest.approx((wind[0] * gone, wind[1] * gone, (wind[2] + g / c) * gone), abs=1e-9)


def test_a_tumbling_body_keeps_its_energy_and_angular_momentum() -> None:
    vehicle = replace(bare(), inertia=(0.02, 0.03, 0.045))
    plant = in_the_air(vehicle, w_b=(1.0, 4.0, 0.5))

    def energy_and_momentum() -> tuple[float, Vec3]:
        truth = plant.truth
        j, w = vehicle.inertia, truth.w_b
        height = -truth.p_n[2]
        kinetic = 0.5 * vehicle.mass * sum(v * v for v in truth.v_n) + 0.5 * sum(
            a * b * b for a, b in zip(j, w, strict=True)
        )
        turning = (j[0] * w[0], j[1] * w[1], j[2] * w[2])
        return kinetic + vehicle.weight * height, to_world(rotation_matrix(truth.q_nb), turning)

    energy, momentum = energy_and_momentum()
    turned = 0.0
    for _ in range(1000):
        plant.step(OFF)
        turned = max(turned, abs(plant.truth.w_b[0]))
    assert turned > 1.1  # it did tumble: the spin moved between the axes
    energy_after, momentum_after = energy_and_momentum()
    assert energy_after == pytest.approx(energy, rel=1e-9)
    assert momentum_after == pytest.approx(momentum, rel=1e-6)


def test_the_integrator_is_of_fourth_order() -> None:
    """Halving the step divides the error of a lively motion by 16."""
    body = replace(body_of(bare()), drag=0.5, angular_drag=0.01)

    def after_one_second(steps: int) -> np.ndarray:  # type: ignore[type-arg]
        advance = runge_kutta(derivative_of(body), 1.0 / steps)
        course = lagging(1.0 / steps, 0.3)
        motion: Motion = (*STILL, 1.0, 0.0, 0.0, *LEVEL, 0.5, -1.0, 2.0)
        now: Four = (0.0, 2.0, 4.0, 6.0)
        for _ in range(steps):
            thrusts = course(now, (5.0, 5.1, 4.9, 5.2))
            motion, now = advance(motion, thrusts, (3.0, 0.0, 0.0), (0.0, 0.0, body.gravity), 0.0), thrusts[2]
        return np.array(motion)

    exact = after_one_second(2000)
    errors = [np.abs(after_one_second(n) - exact).max() for n in (25, 50, 100, 200)]
    orders = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert orders == pytest.approx([4.0, 4.0, 4.0], abs=0.25)
    assert errors[-1] < 1e-7


@pytest.mark.parametrize(
    ("rotor", "turns"),
    [
        (0, (-0.174, 0.174, 0.016)),  # front right, ccw: rolls left, pitches up, yaws right
        (1, (0.174, -0.174, 0.016)),  # rear left, ccw
        (2, (0.174, 0.174, -0.016)),  # front left, cw
        (3, (-0.174, -0.174, -0.016)),  # rear right, cw
    ],
)
def test_each_rotor_of_an_x_turns_the_body_as_by_hand(rotor: int, turns: Vec3) -> None:
    vehicle = bare("x500")
    thrusts = tuple(3.0 if i == rotor else 0.0 for i in range(4))
    linear, angular = accelerations(vehicle, thrusts)  # type: ignore[arg-type]
    jx, jy, jz = vehicle.inertia
    assert linear == pytest.approx((0.0, 0.0, 9.80665 - 3.0 / 2.0))
    assert angular == pytest.approx((3.0 * turns[0] / jx, 3.0 * turns[1] / jy, 3.0 * turns[2] / jz))


def test_each_rotor_of_a_plus_turns_the_body_as_by_hand() -> None:
    vehicle = bare("paper")
    by_hand = ((0.0, 0.1, 1 / 60), (-0.1, 0.0, -1 / 60), (0.0, -0.1, 1 / 60), (0.1, 0.0, -1 / 60))
    for rotor, torque in enumerate(by_hand):
        thrusts = tuple(10.0 if i == rotor else 0.0 for i in range(4))
        _, angular = accelerations(vehicle, thrusts)  # type: ignore[arg-type]
        assert angular == pytest.approx(tuple(10.0 * t / 1.2416 for t in torque))


def test_any_geometry_gives_the_sum_of_the_rotors_cross_products() -> None:
    rng = random.Random(5)
    for _ in range(50):
        rotors = tuple(
            Rotor(
                (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(-0.1, 0.1)),
                rng.choice(list(Spin)), 20.0, rng.uniform(0.005, 0.05),
            )
            for _ in range(4)
        )  # fmt: skip
        vehicle = replace(bare(), rotors=rotors, inertia=(0.02, 0.03, 0.04))
        thrusts = tuple(rng.uniform(-10.0, 10.0) for _ in range(4))
        w = np.array([rng.uniform(-5.0, 5.0) for _ in range(3)])
        j = np.diag(vehicle.inertia)
        torque = -np.cross(w, j @ w)
        for rotor, thrust in zip(rotors, thrusts, strict=True):
            torque += np.cross(rotor.position_b, (0.0, 0.0, -thrust))
            clockwise = 1.0 if rotor.spin is Spin.CCW else -1.0  # the frame turns against the rotor
            torque += np.array([0.0, 0.0, clockwise * rotor.torque_per_thrust * thrust])
        linear, angular = accelerations(vehicle, thrusts, tuple(w))  # type: ignore[arg-type]
        assert np.array(angular) == pytest.approx(np.linalg.solve(j, torque))
        assert linear == pytest.approx((0.0, 0.0, vehicle.gravity - sum(thrusts) / vehicle.mass))


def test_thrust_pushes_along_the_bodys_own_axis() -> None:
    vehicle = bare()
    q_nb = quaternion_from_euler(0.7, -0.3, 0.4)
    rates = derivative_of(body_of(vehicle))(*STILL, *q_nb, *STILL, 5.0, 5.0, 5.0, 5.0, 0.0, 0.0, vehicle.gravity, 0.0)
    push = to_world(rotation_matrix(q_nb), (0.0, 0.0, -20.0 / vehicle.mass))
    assert rates[0:3] == pytest.approx((push[0], push[1], push[2] + vehicle.gravity))


@pytest.mark.parametrize("name", VEHICLES)
def test_hover_thrust_holds_the_vehicle_still(name: str) -> None:
    vehicle = load_vehicle(name)
    each = vehicle.weight / 4.0
    plant = in_the_air(vehicle, thrusts=(each,) * 4)
    for _ in range(1000):
        plant.step((each / vehicle.rotors[0].thrust_max,) * 4)
    assert plant.truth.p_n == pytest.approx((0.0, 0.0, -100.0), abs=1e-9)
    assert plant.truth.thrust == pytest.approx(vehicle.weight)


@pytest.mark.parametrize("steps_per_second", [100, 250, 1000])
def test_motor_lag_is_exact_whatever_the_step(steps_per_second: int) -> None:
    plant = Plant(bare(motor_lag=0.05), World(), steps_per_second)
    for _ in range(steps_per_second // 10):
        plant.step((0.2, 0.1, 0.0, 0.0))
    risen = 1.0 - math.exp(-2.0)
    assert plant.truth.rotor_thrusts == pytest.approx((0.2 * 8.54858 * risen, 0.1 * 8.54858 * risen, 0.0, 0.0))


def test_commands_saturate_at_the_rotors_range() -> None:
    plant = in_the_air(bare("x500"))
    plant.step((2.0, -1.0, math.nan, math.inf))
    assert plant.truth.rotor_thrusts == pytest.approx((8.54858, 0.0, 0.0, 8.54858))
    plant = in_the_air(bare("paper"))
    plant.step((-0.5, -3.0, 0.1, 1.0))
    assert plant.truth.rotor_thrusts == pytest.approx((-125.0, -250.0, 25.0, 250.0))


def test_a_rotor_that_idles_stands_still_when_it_is_switched_off() -> None:
    vehicle = bare("x500")
    idling = replace(vehicle, rotors=tuple(replace(rotor, command=(0.1, 1.0)) for rotor in vehicle.rotors))
    plant = Plant(idling, World(), 250)
    plant.step((0.0, 0.0, 0.0, 0.0))
    assert plant.truth.thrust == pytest.approx(0.1 * vehicle.thrust_max)
    plant.step(None)
    assert plant.truth.thrust == 0.0


def test_body_rates_stay_where_the_step_resolves_them() -> None:
    plant = in_the_air(bare("paper"), height=1e5)
    for _ in range(2500):
        plant.step((1.0, -1.0, -1.0, 1.0))
    assert all(math.isfinite(x) for x in (*plant.truth.p_n, *plant.truth.v_n, *plant.truth.q_nb))
    assert max(map(abs, plant.truth.w_b)) <= BODY_RATE_MAX


def test_a_dropped_vehicle_comes_to_rest_and_stays() -> None:
    plant = in_the_air(bare(), height=2.0, q_nb=quaternion_from_euler(1.0, 0.2, -0.3), w_b=(0.1, 0.0, 0.2))
    for _ in range(500):
        plant.step(OFF)
    truth = plant.truth
    assert truth.on_ground
    assert truth.p_n[2] == 0.0
    assert truth.v_n == truth.w_b == truth.a_n == STILL
    assert tilt(rotation_matrix(truth.q_nb)) < 1e-6
    for _ in range(250):
        plant.step((0.3, 0.3, 0.3, 0.3))  # less than its weight
    assert plant.truth.p_n == truth.p_n


def test_the_legs_keep_the_heading() -> None:
    plant = in_the_air(bare(), height=1e-3, q_nb=quaternion_from_euler(2.0, 0.3, 0.0))
    for _ in range(500):
        plant.step(OFF)
    psi, theta, phi = euler_from_rotation(rotation_matrix(plant.truth.q_nb))
    assert (psi, theta, phi) == pytest.approx((2.0, 0.0, 0.0), abs=1e-6)


def test_it_leaves_the_ground_when_the_rotors_lift_more_than_it_weighs() -> None:
    vehicle = bare(motor_lag=0.025)
    plant = Plant(vehicle, World(), 250)
    up = 1.2 * vehicle.weight / vehicle.thrust_max
    while plant.truth.on_ground:
        assert plant.truth.p_n == STILL
        plant.step((up, up, up, up))
    assert plant.truth.thrust > vehicle.weight
    start = plant.truth.t_boot
    while plant.truth.t_boot < start + 1.0:
        plant.step((up, up, up, up))
    assert not plant.truth.on_ground
    assert -plant.truth.p_n[2] == pytest.approx(0.5 * 0.2 * vehicle.gravity, rel=0.1)


def test_a_vehicle_on_its_back_lies_there() -> None:
    plant = in_the_air(bare(), height=0.5, q_nb=quaternion_from_euler(0.0, 0.0, 2.9))
    for _ in range(500):
        plant.step((1.0, 1.0, 1.0, 1.0))
    assert plant.truth.on_ground
    assert plant.truth.p_n[2] == 0.0
    assert tilt(rotation_matrix(plant.truth.q_nb)) == pytest.approx(2.9)


def test_a_start_below_the_ground_plane_has_no_ground() -> None:
    plant = in_the_air(bare(), height=-5.0)
    for _ in range(250):
        plant.step(OFF)
    assert not plant.truth.on_ground
    assert plant.truth.p_n[2] == pytest.approx(5.0 + 0.5 * plant.vehicle.gravity)


def test_the_true_machine_differs_where_the_world_says_so() -> None:
    truth = Deviations(mass=3.0, inertia=(0.1, 0.2, 0.25), motor_lag=0.5, drag=1.0, thrust_scale=0.5, angular_drag=0.2)
    plant = in_the_air(bare(), World(truth=truth), w_b=(0.0, 0.0, 1.0))
    assert plant.vehicle.weight == pytest.approx(3.0 * 9.80665)
    assert plant.vehicle.thrust_max == pytest.approx(2.0 * 8.54858)
    for _ in range(250):
        plant.step((1.0, 1.0, 1.0, 1.0))
    assert plant.truth.rotor_thrusts[0] == pytest.approx(0.5 * 8.54858 * (1.0 - math.exp(-2.0)))
    assert plant.truth.w_b == pytest.approx((0.0, 0.0, math.exp(-0.2 / 0.25)))


def test_the_plant_flies_quadrotors_only() -> None:
    vehicle = bare()
    with pytest.raises(ValueError, match="6 rotors"):
        body_of(replace(vehicle, rotors=vehicle.rotors + vehicle.rotors[:2]))


def test_a_body_holds_what_its_vehicle_says() -> None:
    vehicle = load_vehicle("sih")
    assert body_of(vehicle, Deviations(angular_drag=0.025)) == Body(
        1.0, (0.025, 0.025, 0.03), 9.80665, 1.0, 0.025,
        ((-0.2, 0.2, 0.02), (0.2, -0.2, 0.02), (0.2, 0.2, -0.02), (-0.2, -0.2, -0.02)),
    )  # fmt: skip
