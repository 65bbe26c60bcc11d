"""One flight of a table: who flies what where, and the figures it ends with. Values, for several processes."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from typing import NamedTuple

from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.plan import prepared
from companion.vehicle import OutputLevel, Vehicle
from companion.world import Link, Way, World
from companion.world.events import After, Event, Hold, Push, When
from trials.rivals import plant_place, px4_position, rotorpy_place
from trials.rivals.ablation import without
from trials.rivals.course import Course
from trials.rivals.figures import Figures, figures
from trials.rivals.tracker import tracking

PX4, TRACKER, ATTITUDE, RATES, ITS_OWN = (
    "PX4 position control", "SE(3) tracker", "the law, attitude", "the law, rates", "RotorPy's SE3Control"
)  # fmt: skip
DEAD_TIME = 0.02
"""s, from a state to the effect of its setpoint, beyond what the vehicle needs itself."""
CONTROL_RATE = 100.0
LOST_FIGURES = Figures(math.inf, math.inf, math.inf, math.inf, math.inf, math.inf, True)


class Sortie(NamedTuple):
    """``who``: one of the names above, or "without: REMEDY". ``place``: a name of PLACES. ``settle``: s of following
    before the figures begin. ``held``, ``pushed``: from and to, s of following."""

    who: str
    place: str
    course: Course
    seconds: float = 25.0
    settle: float = 12.0
    seed: int = 0
    held: tuple[float, float] | None = None
    pushed: tuple[float, float] | None = None


class Place(NamedTuple):
    """What the companion is told of the vehicle, and the world as it is."""

    vehicle: Vehicle
    world: World


def flown(sortie: Sortie) -> Figures:
    """Fly it. A flight that fails is lost."""
    course, seconds, settle = sortie.course, sortie.seconds, sortie.settle
    if sortie.place.startswith("RotorPy"):
        return _in_rotorpy(sortie)
    vehicle, world = PLACES[sortie.place]()
    believed = sortie.place.startswith("SIH")
    world = dataclasses.replace(world, events=(*world.events, *_events(sortie)))
    try:
        if sortie.who == PX4:
            return figures(course, px4_position.fly(course, vehicle, world, seconds, sortie.seed, believed), settle)
        level = OutputLevel.ATTITUDE if sortie.who == ATTITUDE else OutputLevel.RATES
        steering = None
        if sortie.who == TRACKER:
            steering = partial(tracking, course=course)
        elif sortie.who.startswith("without: "):
            steering = without(sortie.who.removeprefix("without: "))
        track = plant_place.fly(course, vehicle, world, seconds, sortie.seed, level, steering, believed)
    except (RuntimeError, ValueError, ArithmeticError):
        return LOST_FIGURES
    if track[-1].t - track[0].t < seconds - 1.0:
        return LOST_FIGURES  # its guards ended the flight
    return figures(course, track, settle)


def _events(sortie: Sortie) -> tuple[Event, ...]:
    events: list[Event] = []
    if sortie.held is not None:
        events.append(Hold(When(*sortie.held, After.OFFBOARD)))
    if sortie.pushed is not None:
        events.append(Push(When(*sortie.pushed, After.OFFBOARD), (5.0, 0.0, 0.0)))
    return tuple(events)


def _in_rotorpy(sortie: Sortie) -> Figures:
    course = sortie.course
    wind = 5.0 if sortie.place.endswith("wind") else 0.0
    place = rotorpy_place.Place(wind_n=(wind, 0.0, 0.0), held=sortie.held)
    if sortie.who == ITS_OWN:
        place = dataclasses.replace(place, abstraction="cmd_motor_speeds", track=[])
        return figures(course, rotorpy_place.fly_its_own(course, place, sortie.seconds), sortie.settle)
    vehicle = rotorpy_place.hummingbird(dead_time=DEAD_TIME)
    plan = prepared(course.mission(), vehicle, OutputLevel.RATES, (0.0, 0.0, 0.0))
    if sortie.who == TRACKER:
        plan = dataclasses.replace(plan, steering=tracking(plan, course))
    try:
        return figures(course, rotorpy_place.fly_steered(course, place, plan, sortie.seconds, DEAD_TIME), sortie.settle)
    except (ValueError, ArithmeticError):
        return LOST_FIGURES


def _sih() -> Place:
    """Nothing known but a hover thrust of 0.5 (the true one is 0.4905): neither its drag nor anything else."""
    known, world = load_vehicle("sih"), load_world("sih")
    truth = dataclasses.replace(world.truth, drag=known.drag)
    return Place(dataclasses.replace(known, drag=0.0), dataclasses.replace(world, truth=truth))


def _sih_rough() -> Place:
    vehicle, world = _sih()
    link = Link(Way(0.02, loss=0.1), Way(0.024, loss=0.1))
    return Place(
        dataclasses.replace(vehicle, dead_time=0.044), dataclasses.replace(world, wind_n=(-5.0, 0.0, 0.0), link=link)
    )


def _told() -> Vehicle:
    """An x500 of which neither drag nor anything else is known, over a link of LINK_DELAY."""
    known = load_vehicle("x500")
    return dataclasses.replace(known, drag=0.0, state_rate=CONTROL_RATE, dead_time=DEAD_TIME)


def _outdoor(**truth: object) -> Place:
    world = load_world("outdoor")
    down, up = (dataclasses.replace(way, delay=0.5 * DEAD_TIME) for way in (world.link.down, world.link.up))
    true = dataclasses.replace(world.truth, drag=load_vehicle("x500").drag, **truth)  # type: ignore[arg-type]
    return Place(_told(), dataclasses.replace(world, link=Link(down, up), truth=true))


def _calm(**truth: object) -> Place:
    return Place(_told(), dataclasses.replace(_outdoor(**truth).world, wind_n=(0.0, 0.0, 0.0), gusts=None,
                                             estimate=World().estimate))  # fmt: skip


def _slow_link() -> Place:
    place = _outdoor()
    return place._replace(world=dataclasses.replace(place.world, link=Link(Way(0.025), Way(0.025))))


_X500 = load_vehicle("x500")
_HEAVIER, _LIGHTER = 1.2 * _X500.mass, 0.8 * _X500.mass
PLACES = {
    "SIH": _sih,
    "SIH, wind 5 m/s, 20 ms each way, 10 % loss": _sih_rough,
    "outdoor": _outdoor,
    "calm": _calm,
    "mass +20 %": lambda: _outdoor(mass=_HEAVIER),
    "mass -20 %": lambda: _outdoor(mass=_LIGHTER),
    "inertia +30 %": lambda: _outdoor(inertia=tuple(1.3 * j for j in _X500.inertia)),
    "motor lag 60 ms, told 25": lambda: _outdoor(motor_lag=0.06),
    "delay 50 ms, told 20": _slow_link,
}
