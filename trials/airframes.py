"""Quadrotors of any size of which the companion is told a rough file, in air that moves, with sensors that shake.

Each draws, from its seed: mass 0.6 to 3.5 kg, thrust to weight 1.7 to 2.8, inertia +-40 % of what a frame of its mass has,
torque over thrust 0.01 to 0.03 m (its file knows it, and nothing at the level of rates asks), motor lag 15 to 60 ms, drag 0.1 to 1.2 1/s, a thrust curve of 0 or 0.3 that PX4 does not
know of, rate gains 0.9 to 1.6 of the usual ones by axis, wind to 4 m/s an axis. Its file: mass +-5 %, inertia +-30 %, drag
0.2, hover thrust auto, yaw rate as PX4 has it. Nothing of it was learned before.
"""

from __future__ import annotations

import dataclasses
import math
import random
from functools import cache
from typing import NamedTuple

from companion.feasibility.demand import compute_demand
from companion.feasibility.stations import Stations, places, stations_along
from companion.mission import Mission
from companion.profiles.yaw import TangentYaw
from companion.vehicle import GRAVITY, Vehicle
from companion.world import Deviations, World
from sim_bridge.rigid_body import true_vehicle
from trials.measured import Measured, course, machine, measure_flight, world

YAW_RATE_MAX = math.radians(200.0)
"""rad/s. PX4's default MC_YAWRATE_MAX: the bends of the figure-eight ask for 130 deg/s of heading rate at 3 m/s."""


class Airframe(NamedTuple):
    """A machine, and what its file says of it. ``torque_per_thrust``: m, the true one."""

    told: Vehicle
    where: World
    torque_per_thrust: float

    def words(self) -> str:
        """What was drawn, for a table."""
        truth = self.where.truth
        p, q, r = truth.rate_gains
        weight = self.told.thrust_max / (truth.mass or 1.0) / GRAVITY
        north, east, _ = self.where.wind_n
        return (
            f"{truth.mass:5.2f} kg T/W {weight:4.2f} lag {1e3 * (truth.motor_lag or 0.0):3.0f} ms drag {truth.drag:4.2f} "
            f"curve {truth.thrust_curve:3.1f} gains {p:4.2f} {q:4.2f} {r:4.2f} torque/thrust {1e3 * self.torque_per_thrust:4.1f} mm "
            f"wind {north:4.1f} {east:4.1f}"
        )


def drawn(seed: int) -> Airframe:
    """The airframe of a seed."""
    rng = random.Random(f"airframe {seed}")
    usual = machine("x500")
    mass = 0.6 * (3.5 / 0.6) ** rng.random()
    thrust = rng.uniform(1.7, 2.8) * mass * usual.gravity / 4.0
    jx, jy, jz = (j * mass / usual.mass * rng.uniform(0.6, 1.4) for j in usual.inertia)
    jz = min(jz, 0.98 * (jx + jy))
    torque = rng.uniform(0.01, 0.03)
    truth = Deviations(
        mass=mass, inertia=(jx, jy, jz), motor_lag=rng.uniform(0.015, 0.06), drag=rng.uniform(0.1, 1.2),
        thrust_curve=rng.choice((0.0, 0.3)),
        rate_gains=(rng.uniform(0.9, 1.6), rng.uniform(0.9, 1.6), rng.uniform(0.9, 1.6)),
    )  # fmt: skip
    around, about = rng.uniform(0.7, 1.3), rng.uniform(0.7, 1.3)
    rotors = tuple(dataclasses.replace(r, thrust_max=thrust, torque_per_thrust=torque) for r in usual.rotors)
    assert usual.limits is not None
    limits = dataclasses.replace(usual.limits, body_rates=(*usual.limits.body_rates[:2], YAW_RATE_MAX))
    told = dataclasses.replace(
        usual, limits=limits, mass=mass * rng.uniform(0.95, 1.05),
        inertia=(jx * around, jy * around, min(jz * about, 0.98 * (jx + jy) * around)), rotors=rotors, drag=0.2, hover_thrust=None,
    )  # fmt: skip
    where = world("sih_noisy", wind_n=(rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0), 0.0), truth=truth)
    return Airframe(told, where, torque)


def eight(speed: float = 3.0) -> Mission:
    """The figure-eight of 6 by 3 m with the nose along the path."""
    return dataclasses.replace(course("figure8", speed), yaw=TangentYaw())


@cache
def _stations() -> Stations:
    mission = eight()
    return stations_along(mission, places(mission))


def motor_share(airframe: Airframe) -> float:
    """The largest share of any motor's range that the figure-eight asks for, flown exactly by the true machine in its
    wind: beyond 1 the yaw torque does not allow it, as ``companion check`` has it."""
    machine_ = true_vehicle(airframe.told, airframe.where.truth)
    asked = compute_demand(dataclasses.replace(_stations(), wind_n=airframe.where.wind_n), machine_)
    return float(asked.motors.max())


def flown(seed: int, *, circle: bool = False, duration: float = 25.0, settle: float = 15.0) -> Measured:
    """The flight of a seed: the figure-eight with its nose along the path, or the circle at 3 m/s; errors from
    ``settle`` s of following on."""
    airframe = drawn(seed)
    mission = course("circle_r5", 3.0) if circle else eight()
    return measure_flight(mission, airframe.told, airframe.where, seed=seed, duration=duration, settle=settle)
