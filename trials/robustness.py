"""Many seeded flights outdoors with a machine that is not as its file says: how far off the path, how many lost.

Each flight draws, from its seed: mass +-20 %, inertia +-30 %, motor lag 15-60 ms, link delay 0-50 ms there and back,
and a path (circle r 5 at 3 or 6 m/s, figure-eight at 3 m/s). The vehicle file stays as it is: nothing of this is told.
"""

from __future__ import annotations

import dataclasses
import random
from typing import NamedTuple

from companion.vehicle import OutputLevel
from companion.world import Deviations, Link
from trials.measured import Measured, course, machine, measure_flight, world

COURSES = (("circle_r5", 3.0), ("circle_r5", 6.0), ("figure8", 3.0))


class Drawn(NamedTuple):
    """One flight's chances. ``delay``: s there and back."""

    mission: str
    speed: float
    truth: Deviations
    delay: float


def drawn(seed: int) -> Drawn:
    """What a seed brings."""
    rng = random.Random(f"robustness {seed}")
    vehicle = machine("x500")
    jx, jy, jz = vehicle.inertia
    factor = rng.uniform(0.7, 1.3)
    truth = Deviations(
        mass=vehicle.mass * rng.uniform(0.8, 1.2),
        inertia=(jx * factor, jy * factor, jz * factor),
        motor_lag=rng.uniform(0.015, 0.06),
    )
    mission, speed = COURSES[seed % len(COURSES)]
    return Drawn(mission, speed, truth, rng.uniform(0.0, 0.05))


def flown(seed: int, duration: float = 25.0, settle: float = 10.0) -> Measured:
    """The flight of a seed."""
    case = drawn(seed)
    outdoor = world("outdoor")
    way = dataclasses.replace(outdoor.link.down, delay=0.5 * case.delay, jitter=min(0.003, 0.5 * case.delay))
    where = dataclasses.replace(outdoor, truth=case.truth, link=Link(way, way))
    return measure_flight(
        course(case.mission, case.speed), machine("x500"), where, OutputLevel.RATES,
        seed=seed, duration=duration, settle=settle,
    )  # fmt: skip
