"""A mission against the plant in one process under a simulated clock, for ``companion sim`` and ``simulate``."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from companion.daemon.asked_of_vehicle import WANTED
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.last_resort import LastResort
from companion.flight.conduct import Conduct
from companion.frames import quaternion_from_euler
from companion.geodesy import LocalFrame
from companion.library.lockstep import fly
from companion.library.orders import Sortie
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.origins import VehicleLocation, placed
from companion.record.circumstances import SimulatedWorld
from companion.record.folder import Recorder
from companion.record.table import Table
from companion.record.ticks import Ticks
from companion.vehicle import OutputLevel
from companion.world import Home, Start, World
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.truth_file import TruthFile, TruthRows

DEFAULT_DURATION = 60.0
"""s of following for a mission that has no end of its own (round, or back and forth, without laps) and is told none."""
SIMULATED_FLUSH = 1.0
"""s of simulated time between two writes of the record: a kill costs no more of it, and memory stays as it is."""
OVERHEAD = 300.0
"""s of simulated time a flight may take beyond following."""
LONGEST = 3600.0
"""s of following that a flight without a duration may take."""


@dataclass(frozen=True)
class SimulatedFlight:
    """One flight in a world. ``from_ground``: it begins on the ground, disarmed. ``duration``: s of following.
    ``xrce``: the vehicle is a stock PX4 with an XRCE client, and motors and torques go there. ``lean``: it streams only
    what a companion looks at, a third of what PX4 streams."""

    sortie: Sortie
    simulated: SimulatedWorld
    from_ground: bool
    duration: float | None
    xrce: bool = field(default=False, kw_only=True)
    lean: bool = field(default=False, kw_only=True)


class Flown(NamedTuple):
    """``now``: s of simulated time at the end. ``failure``: what ended it where the companion itself failed."""

    conductor: Conductor
    now: float
    failure: LastResort | None


def in_lockstep(
    flight: SimulatedFlight, recorder: Recorder, begun: Callable[[Conductor], Callable[[float], None]]
) -> Flown:
    """Fly. ``begun`` is told the conductor before the first step; what it returns is called after every step with the
    simulated time, s, and once more at the end. The record is written as the flight goes on."""
    bridge = _bridge_of(flight)
    conductor = Conductor(orders_of(flight), recorder, bridge.now)
    look = begun(conductor)
    write_at = SIMULATED_FLUSH
    with contextlib.ExitStack() as stack:
        truth_file = None
        with contextlib.suppress(OSError):  # no room for it: the record has said so
            truth_file = stack.enter_context(TruthFile(recorder.path("truth.npy")))

        def watch(conductor: Conductor, truth: Truth) -> None:
            nonlocal write_at
            if truth_file is not None:
                truth_file.append(truth, bridge.autopilot.commands)
            look(bridge.now)
            if bridge.now >= write_at:
                write_at = bridge.now + SIMULATED_FLUSH
                recorder.flush()

        failure = fly(conductor, bridge, watch, _longest(flight), survive=True)
        look(bridge.now)
    return Flown(conductor, bridge.now, failure)


def in_memory(flight: SimulatedFlight) -> tuple[Flown, Ticks, Table]:
    """Fly, and leave nothing behind: how it went, its ticks, and the plant's true states."""
    bridge = _bridge_of(flight)
    ticks, truths = Ticks(), TruthRows()
    conductor = Conductor(orders_of(flight), ticks, bridge.now)

    def watch(conductor: Conductor, truth: Truth) -> None:
        truths.append(truth, bridge.autopilot.commands)

    failure = fly(conductor, bridge, watch, _longest(flight), survive=True)
    return Flown(conductor, bridge.now, failure), ticks, truths.table


def _longest(flight: SimulatedFlight) -> float:
    return OVERHEAD + (flight.duration or LONGEST)


def _bridge_of(flight: SimulatedFlight) -> Bridge:
    """The vehicle in its world."""
    sortie = flight.sortie
    mission, world = at_home(sortie.mission, flight.simulated.world)
    return Bridge(
        sortie.vehicle,
        world,
        seed=flight.simulated.seed,
        direct=sortie.level is OutputLevel.MOTORS and not flight.xrce,
        start=None if flight.from_ground else start_of(mission),
        landed=flight.from_ground,
        endpoints=1,
        xrce=Release.MAIN if flight.xrce else None,
        only=WANTED if flight.lean else None,
    )


def start_of(mission: Mission, held: bool = True) -> Start:
    """Where the vehicle is when the flight begins: the mission's own start, or a hover on the path."""
    if mission.start is not None:
        given = mission.start
        x, y, z = mission.placement.to_local(given.position)
        u, v, w = mission.placement.turned(given.velocity)
        attitude = quaternion_from_euler(given.heading, given.pitch, given.roll)
        return Start((x, y, z), (u, v, w), attitude, given.rates_b, held=held)
    return Start.hover(mission.table.at(0.0)[0], mission.beta(0.0))


def at_home(mission: Mission, world: World) -> tuple[Mission, World]:
    """The mission in the world's local frame. A world that has no place of its own is where the mission is."""
    origin = mission.origin
    if isinstance(origin, GlobalOrigin) and world.home == Home():
        known = None if mission.home is None else mission.home.altitude
        altitude = known if known is not None else Home().altitude if origin.above_home else origin.altitude
        world = dataclasses.replace(world, home=Home(origin.latitude, origin.longitude, altitude))
    home = (world.home.latitude, world.home.longitude, world.home.altitude)
    where = VehicleLocation((0.0, 0.0, 0.0), on_ground=True, frame=LocalFrame(*home), home=home)
    return placed(mission, Origin.LOCAL, where), world


def orders_of(flight: SimulatedFlight) -> Orders:
    """What the daemon is told."""
    sortie, duration = flight.sortie, flight.duration
    mission = sortie.mission
    if duration is None and mission.laps is None and (mission.closed or mission.repeat is not None):
        duration = DEFAULT_DURATION
    # the plant is ours: what rates need may be set there
    return Orders(
        sortie.mission,
        sortie.vehicle,
        sortie.level,
        duration,
        Origin.LOCAL,
        auto=sortie.auto,
        set_parameters=True,
        over_xrce=flight.xrce and sortie.level.without_rate_loop,
        has_xrce=flight.xrce,
        conduct=Conduct(at_once=sortie.mission.start is not None),
    )
