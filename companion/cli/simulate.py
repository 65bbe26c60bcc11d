"""``sim``: a mission against the plant, in lockstep or as two processes over UDP."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from companion.cli.finish import NO_VEHICLE, Ending, finish, say
from companion.cli.lockstep import fly
from companion.cli.orders import Sortie
from companion.cli.story import Story
from companion.daemon.address import UdpPort
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.loop import NoVehicleError, clock, run
from companion.daemon.progress import Watch
from companion.daemon.signals import ending_signals
from companion.flight.conduct import Conduct
from companion.frames import quaternion_from_euler
from companion.geodesy import LocalFrame
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.standing import Whereabouts, placed
from companion.record.circumstances import Simulated
from companion.record.folder import Recorder
from companion.vehicle import OutputLevel
from companion.world import Home, Start, World
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.truth_file import TruthFile

DEFAULT_DURATION = 60.0
"""s of following for a mission that says neither laps nor is told a duration."""
SIMULATED_PROGRESS = 5.0
OVERHEAD = 300.0
"""s of simulated time a flight may take beyond following."""
WAIT_FOR_PLANT = 10.0
STORY_PERIOD = 0.1
"""s between two looks at a flight in real time for what there is to tell (engineering choice)."""


@dataclass(frozen=True)
class Simulation:
    """One simulated flight in a world."""

    sortie: Sortie
    simulated: Simulated
    from_ground: bool
    duration: float | None
    directory: Path
    ending: Ending


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
        altitude = Home().altitude if origin.above_home else origin.altitude
        world = dataclasses.replace(world, home=Home(origin.latitude, origin.longitude, altitude))
    home = (world.home.latitude, world.home.longitude, world.home.altitude)
    where = Whereabouts((0.0, 0.0, 0.0), on_ground=True, frame=LocalFrame(*home), home=home)
    return placed(mission, Origin.LOCAL, where), world


def in_lockstep(simulation: Simulation) -> int:
    """Fly in one process under a simulated clock; the exit code."""
    sortie = simulation.sortie
    direct = sortie.level is OutputLevel.MOTORS
    mission, world = at_home(sortie.mission, simulation.simulated.world)
    bridge = Bridge(
        sortie.vehicle,
        world,
        seed=simulation.simulated.seed,
        direct=direct,
        start=None if simulation.from_ground else start_of(mission),
        landed=simulation.from_ground,
        endpoints=1,
    )
    recorder = _recorder(simulation, epoch=0.0)
    conductor = Conductor(_orders(simulation), recorder, bridge.now)
    shown, story = Watch(SIMULATED_PROGRESS), _story(simulation)
    with TruthFile(simulation.directory / "truth.npy") as truth_file:

        def watch(conductor: Conductor, truth: Truth) -> None:
            truth_file.append(truth, bridge.autopilot.commands)
            if conductor.notes:
                for note in conductor.notes:
                    say(f"{bridge.now:8.2f} s  {note}")
                conductor.notes.clear()
            for sentence in story.look(conductor):
                say(f"{bridge.now:8.2f} s{sentence}")
            line = shown.look(conductor, bridge.now)
            if line is not None:
                say(f"{bridge.now:8.2f} s  {line}")

        with ending_signals(conductor.stop) as stopped:
            fly(conductor, bridge, watch, OVERHEAD + (simulation.duration or 3600.0))
    return finish(conductor, recorder, simulation.ending, bool(stopped))


def over_udp(simulation: Simulation) -> int:
    """Fly with the plant as a process of its own, over loopback in real time; the exit code."""
    sortie = simulation.sortie
    port = UdpPort("127.0.0.1", 0, listen=True)
    recorder = _recorder(simulation, epoch=time.time() - clock())
    vehicle_file = simulation.directory / "vehicle.yaml"
    mission, world = at_home(sortie.mission, simulation.simulated.world)
    home = f"{world.home.latitude!r},{world.home.longitude!r},{world.home.altitude!r}"
    command = [
        *(sys.executable, "-m", "sim_bridge", "--vehicle", str(vehicle_file), "--world", simulation.simulated.file),
        *("--connect", f"udpout://127.0.0.1:{port.local[1]}", "--ground-station", "none"),
        *("--home", home, "--seed", str(simulation.simulated.seed), "--truth", str(simulation.directory / "truth.npy")),
    ]
    if sortie.level is OutputLevel.MOTORS:
        command += ["--motors", "direct"]
    if not simulation.from_ground:
        start = start_of(mission)
        told = {
            "position_n": list(start.position_n),
            "velocity_n": list(start.velocity_n),
            "q_nb": list(start.q_nb),
            "rates_b": list(start.rates_b),
            "held": start.held,
        }
        command += ["--start", json.dumps(told)]
    conductor = Conductor(_orders(simulation), recorder, clock())
    teller = _Teller(_story(simulation), conductor)
    # a session of its own: Ctrl-C must not take the vehicle away before it has been handed back
    plant = subprocess.Popen(command, start_new_session=True)
    teller.start()
    try:
        stopped = run(conductor, port, recorder, say, WAIT_FOR_PLANT)
    except NoVehicleError as error:
        recorder.discard()
        say(str(error))
        return NO_VEHICLE
    finally:
        teller.finish()
        plant.terminate()
        try:
            plant.wait(5.0)
        except subprocess.TimeoutExpired:
            plant.kill()
            plant.wait()
        port.close()
    return finish(conductor, recorder, simulation.ending, stopped)


class _Teller(threading.Thread):
    """Tells the story of a flight in real time, beside the control thread, which it only reads."""

    def __init__(self, story: Story, conductor: Conductor) -> None:
        super().__init__(name="teller", daemon=True)
        self._story, self._conductor = story, conductor
        self._finished = threading.Event()

    def run(self) -> None:
        while self._story.has_more and not self._finished.wait(STORY_PERIOD):
            for sentence in self._story.look(self._conductor):
                say(sentence)

    def finish(self) -> None:
        """The flight is over."""
        self._finished.set()
        self.join()


def _story(simulation: Simulation) -> Story:
    """The teller of the flight, the world already told."""
    simulated = simulation.simulated
    story = Story(simulated.world)
    say(story.opening(simulated.world.name, simulated.seed))
    return story


def _orders(simulation: Simulation) -> Orders:
    sortie = simulation.sortie
    duration = simulation.duration
    if duration is None and sortie.mission.laps is None and sortie.mission.closed:
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
        conduct=Conduct(at_once=sortie.mission.start is not None),
    )


def _recorder(simulation: Simulation, epoch: float) -> Recorder:
    sortie = simulation.sortie
    return Recorder(simulation.directory, sortie.mission_source, sortie.vehicle_source, epoch, simulation.simulated)
