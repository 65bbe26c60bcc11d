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
        ("circle_r5", 3.0, 1, 0.018, 0.023, 1.0),
        ("circle_r5", 5.0, 1, 0.020, 0.018, 2.0),
        ("circle_r5", 7.0, 1, 0.025, 0.05, 5.0),
        ("figure8", 3.0, 1, 0.020, 0.026, 1.8),
    ],
)
def test_paths_under_the_noise_of_a_real_frame(
    mission: str, speed: float, seed: int, path: float, speed_share: float, heading_deg: float
) -> None:
    """Right vehicle file, still air, rates, from 10 s on. 7 m/s needs a tilt of 60 deg in the vehicle file; there the speed
    gives way to what the tilt shakes."""
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
