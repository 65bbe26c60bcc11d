"""A mission and a vehicle, perhaps in a world -> the report of ``check``."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

from companion.config.syntax.faults import ConfigError, Fault
from companion.feasibility import report as feasibility
from companion.feasibility.report import Report
from companion.frames import Vec3
from companion.library.orders import Sortie
from companion.vehicle import Vehicle
from companion.world import World
from companion.world.machine import Deviations
from companion.world.words import air_in_words

GUSTS_RECKONED = 2.0
"""Standard deviations of the gusts on top of the mean wind (engineering choice: 5 % of the gusts are stronger)."""
STILL: Vec3 = (0.0, 0.0, 0.0)


class Air(NamedTuple):
    """The steady wind that is reckoned with, m/s, and where it comes from, in words."""

    wind_n: Vec3
    words: str


def air_of(world: World, height: float) -> Air:
    """The mean wind with twice the standard deviation of its gusts on top, at a height over the ground (m)."""
    mean = math.hypot(*world.wind_n)
    gusts = 0.0 if world.gusts is None else GUSTS_RECKONED * world.gusts.at(height).sigma[0]
    words = f"{world.name}: {air_in_words(world)}"
    if mean == 0.0 or gusts == 0.0:
        return Air(world.wind_n, words)
    x, y, z = (component * (mean + gusts) / mean for component in world.wind_n)
    return Air((x, y, z), f"{words}; looked at with {mean + gusts:.1f} m/s, the mean and twice the gusts")


def as_it_is(vehicle: Vehicle, truth: Deviations) -> Vehicle:
    """The vehicle with the true mass, inertia, drag and thrust of a world."""
    rotors = tuple(
        dataclasses.replace(rotor, thrust_max=rotor.thrust_max * truth.thrust_scale) for rotor in vehicle.rotors
    )
    return dataclasses.replace(
        vehicle,
        mass=vehicle.mass if truth.mass is None else truth.mass,
        inertia=vehicle.inertia if truth.inertia is None else truth.inertia,
        drag=vehicle.drag if truth.drag is None else truth.drag,
        rotors=rotors,
    )


def in_world(sortie: Sortie, world: World | None) -> tuple[Sortie, Air | None]:
    """The sortie with the true machine of a world, and the air to reckon with; None where no world is given."""
    if world is None:
        return sortie, None
    air = air_of(world, height=-sortie.mission.table.at(0.0)[0][2])
    return dataclasses.replace(sortie, vehicle=as_it_is(sortie.vehicle, world.truth)), air


def checked(sortie: Sortie, wind_n: Vec3 = STILL) -> tuple[Sortie, Report]:
    """What the mission asks of the vehicle; and the sortie with its speed known, where that was ``auto``. ConfigError:
    it cannot be looked at."""
    try:
        found = feasibility.check(sortie.mission, sortie.vehicle, wind_n=wind_n)
    except (ValueError, ArithmeticError) as error:
        line = 0 if sortie.mission_source.made else 1
        raise ConfigError([Fault(sortie.mission_source.name, line, "path", str(error))]) from None
    return dataclasses.replace(sortie, mission=found.mission), found
