"""How near path and speed a vehicle with the sensors of a real frame stays, as it believes: docs/estimation.md, of which
these are single flights (``python -m bench.noisy_flights plain`` has the means)."""

from __future__ import annotations

import dataclasses
import math

import pytest

from trials.measured import course, machine, measure_flight, world


@pytest.mark.parametrize(
    ("mission", "speed", "seed", "path", "speed_share", "heading_deg"),
    [
        ("circle_r5", 3.0, 1, 0.018, 0.023, 0.8),
        ("circle_r5", 5.0, 1, 0.020, 0.018, 1.3),
        ("circle_r5", 7.0, 1, 0.025, 0.025, 3.0),
        ("figure8", 3.0, 1, 0.020, 0.026, 1.3),
    ],
)
def test_paths_under_the_noise_of_a_real_frame(
    mission: str, speed: float, seed: int, path: float, speed_share: float, heading_deg: float
) -> None:
    """Right vehicle file, still air, rates, from 10 s on. 7 m/s needs a tilt of 60 deg in the vehicle file."""
    vehicle = machine("sih", hover_thrust=0.4905)
    assert vehicle.limits is not None
    if speed >= 7.0:
        vehicle = dataclasses.replace(vehicle, limits=dataclasses.replace(vehicle.limits, tilt=math.radians(60.0)))
    done = measure_flight(course(mission, speed), vehicle, world("sih_noisy"), seed=seed, duration=40.0)
    assert done.reason is None
    assert done.believed is not None
    assert done.believed.path < path
    assert done.believed.speed < speed_share * speed
    assert math.degrees(done.believed.yaw) < heading_deg


def test_the_yaw_loop_and_the_damping_of_its_turning_are_found() -> None:
    """PX4's simulated quadrotor: T 0.375 s, a torque that is 0.135 s late, damping 0.025 N m s over 0.03 kg m^2 and the
    rotors'. As the model has them each is 1 + 0.135 times the damping more or less (see ``yaw_loop_identification``)."""
    vehicle = machine("sih", hover_thrust=0.4905)
    done = measure_flight(course("figure8", 3.0), vehicle, world("sih_noisy"), seed=2, duration=40.0)
    assert done.conductor.memory is not None and done.conductor.memory.steering.memory is not None
    loop = done.conductor.memory.steering.memory.estimate.rate_loop
    late = 1.0 + 0.135 * 0.83
    assert loop.yaw_lag == pytest.approx(0.375 * late, rel=0.15)
    assert loop.yaw_torque_lag == pytest.approx(0.135 / late, abs=0.025)
    assert loop.yaw_damping == pytest.approx(0.83 / late, abs=0.3)
