"""The project's own plant in lockstep, over the very datagrams UDP would carry, under any steering."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from companion.daemon.conductor import Conductor, Orders
from companion.law.gains import Level
from companion.library.lockstep import fly as fly_in_lockstep
from companion.library.simulation import start_of
from companion.mission import Origin
from companion.plan import Plan
from companion.steering.steering import Steering
from companion.vehicle import OutputLevel, Vehicle
from companion.world import World
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from trials.rivals.course import Course
from trials.rivals.figures import Sample
from trials.rivals.px4_position import sample

OVERHEAD = 60.0
"""s a flight may take beyond following."""


def fly(
    course: Course,
    vehicle: Vehicle,
    world: World,
    seconds: float,
    seed: int = 0,
    level: OutputLevel = OutputLevel.RATES,
    steering: Callable[[Plan], Steering] | None = None,
    believed: bool = False,
) -> list[Sample]:
    """The track from the beginning of following on: the true one, or as the vehicle believes. ``steering``: what to
    put in the place of the plan's own."""
    mission = course.mission(Level.MOTORS if level is OutputLevel.MOTORS else Level.RATES)
    bridge = Bridge(vehicle, world, seed=seed, direct=level is OutputLevel.MOTORS, start=start_of(mission), endpoints=1)
    orders = Orders(mission, vehicle, level, seconds, Origin.LOCAL, set_parameters=True)
    conductor = Conductor(orders, None, 0.0)
    track: list[Sample] = []
    swapped = steering is None

    def watch(conductor: Conductor, truth: Truth) -> None:
        nonlocal swapped
        if not swapped and conductor.plan is not None:
            assert steering is not None
            conductor.plan = dataclasses.replace(conductor.plan, steering=steering(conductor.plan))
            if conductor.memory is not None:
                steered = conductor.memory.steering._replace(memory=None)
                conductor.memory = conductor.memory._replace(steering=steered)
            swapped = True
        memory = conductor.memory
        if memory is not None and memory.path.follow_from is not None:
            track.append(sample(bridge.now, bridge, believed))

    fly_in_lockstep(conductor, bridge, watch, OVERHEAD + seconds)
    if not track:
        raise RuntimeError(f"{course.name} was not flown: {conductor.refusal or conductor.notes}")
    return track
