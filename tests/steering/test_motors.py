"""The level of motors: as near to the path as rates, in noise and with dead time; what it learns."""

from __future__ import annotations

import dataclasses
import math

import pytest

from companion.vehicle import OutputLevel
from companion.world import Link, Way
from trials.measured import Measured, course, machine, measure_flight, world

RATES_ON_SIH_NOISY = 0.0242
"""m RMS of the believed path error at rates, circle_r5 at 3 m/s, seed 0, from 10 s to 40 s of following."""


def flown(where: str, duration: float = 30.0, up: float = 0.004, drag: float = 1.0) -> Measured:
    """``up``: s, of the link to the vehicle. ``drag``: of the vehicle file, of the true one."""
    air, true = world(where, link=Link(up=Way(delay=up))), machine("sih")
    air = dataclasses.replace(air, truth=dataclasses.replace(air.truth, drag=true.drag))
    told = dataclasses.replace(true, drag=drag * true.drag)
    return measure_flight(
        course("circle_r5", 3.0, OutputLevel.MOTORS), told, air, OutputLevel.MOTORS, duration=duration
    )  # fmt: skip


def test_in_noise_it_is_as_near_to_the_path_as_rates() -> None:
    """Within 1.3, with a command that acts 8 ms after its state; the file's drag is half the true one."""
    done = flown("sih_noisy", up=0.008, drag=0.5)
    assert done.believed is not None
    assert done.estimates is not None
    assert done.believed.path < 1.3 * RATES_ON_SIH_NOISY
    assert done.believed.yaw < math.radians(1.0)
    assert done.estimates.thrust_scale == pytest.approx(1.0, abs=0.04)


def test_in_a_quiet_world_it_is_nearer_than_a_centimetre() -> None:
    done = flown("sih", duration=20.0)
    assert done.believed is not None
    assert done.believed.path < 0.01
    learned = done.conductor.learned
    assert learned is not None
    assert learned.hover_thrust == pytest.approx(0.4905, rel=0.02)
    assert learned.drag == pytest.approx(1.0, abs=0.1)
    assert learned.rate_lag == 0.071  # of the rate loop, which was not flown: as told
