"""The level of motors: as near to the path as rates, in noise and with dead time; what it learns."""

from __future__ import annotations

import dataclasses
import math

import pytest

from companion.estimation.learned import Learned
from companion.plan import prepared
from companion.steering.motor_memory import MotorMemory
from companion.vehicle import MotorInterface, OutputLevel, VehicleState
from companion.world import Link, Way
from trials.measured import Measured, course, machine, measure_flight, world

RATES_ON_SIH_NOISY = 0.0201
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
    memory = done.conductor.memory
    assert memory is not None
    assert isinstance(memory.steering.memory, MotorMemory)
    assert memory.steering.memory.estimate.body_state.damping[:2] == pytest.approx((1.0, 1.0), abs=0.2)  # SIH_KDW


def test_where_it_leans_steeply_it_keeps_away_from_the_tilt_at_which_it_is_handed_back() -> None:
    """The circle at 7 m/s wants 51 deg. A vehicle that PX4 would not catch from more than 55 is flown slower, its poles
    are lowered, and it is flown whole: this seed was handed back when it had come to its speed, its tilt told as 58."""
    handed_back = math.radians(55.0)
    done = measure_flight(
        course("circle_r5", 7.0, OutputLevel.TORQUES), machine("sih"), world("sih_noisy"), OutputLevel.TORQUES,
        seed=1, duration=20.0, over_xrce=True,
    )  # fmt: skip
    assert done.reason is None
    assert done.believed is not None and done.estimates is not None and done.conductor.plan is not None
    assert done.conductor.plan.conduct.limits.tilt == pytest.approx(handed_back)
    assert done.believed.path < 0.035
    assert done.conductor.plan.path_pole == pytest.approx(-7.0)
    assert -7.0 < done.estimates.path_pole < -6.5


def test_what_was_learned_of_the_loops_it_does_not_fly_is_kept() -> None:
    """A flight at motors flies neither the tilting loops nor the yaw loop: what rates found of them stays."""
    vehicle = machine("sih", motors=MotorInterface.DIRECT)
    mission = course("circle_r5", 3.0, OutputLevel.MOTORS)
    known = Learned(0.49, 1.0, 0.065, yaw_lag=0.31)
    steering = prepared(mission, vehicle, OutputLevel.MOTORS, (0.0, 0.0, 0.0), learned=known).steering
    memory = steering.begin(
        VehicleState(0.0, (0.0, 5.0, -10.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    )
    estimate = memory.estimate
    settled = estimate.motion.estimator._replace(flight_time=20.0)
    settled = settled._replace(belief=settled.belief._replace(T=(1e-4, 0.0, 1e-3)))
    memory = memory._replace(estimate=estimate._replace(motion=estimate.motion._replace(estimator=settled)))
    learned = steering.learned_values(memory)
    assert learned is not None
    assert (learned.rate_lag, learned.yaw_lag) == (0.065, 0.31)
