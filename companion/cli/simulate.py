"""``sim``: a mission against the plant, in lockstep or as two processes over UDP."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from companion.cli.around import begin_record, failed, listen_to, no_vehicle
from companion.cli.finish import INTERRUPTED, Ended, Ending, finish
from companion.cli.lockstep import fly
from companion.cli.orders import Sortie
from companion.cli.story import Story
from companion.cli.terminal import is_verbose, say, warn
from companion.daemon.address import UdpPort
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.loop import NoVehicleError, clock, run
from companion.daemon.progress import Watch
from companion.daemon.signals import Signals, ending_signals
from companion.flight.conduct import Conduct
from companion.frames import quaternion_from_euler
from companion.geodesy import LocalFrame
from companion.mission import GlobalOrigin, Mission, Origin
from companion.places.origins import VehicleLocation, placed
from companion.record.circumstances import Simulated
from companion.record.folder import Recorder
from companion.vehicle import CompanionError, OutputLevel
from companion.world import Home, Start, World
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.truth_file import TruthFile

DEFAULT_DURATION = 60.0
"""s of following for a mission that says neither laps nor is told a duration."""
SIMULATED_PROGRESS, VERBOSE_PROGRESS = 5.0, 1.0
"""s of simulated time between two lines of progress."""
SIMULATED_FLUSH = 1.0
"""s of simulated time between two writes of the record: a kill costs no more of it, and memory stays as it is."""
OVERHEAD = 300.0
"""s of simulated time a flight may take beyond following."""
WAIT_FOR_PLANT = 10.0
"""s for the plant's process to be heard (engineering choice)."""
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
        known = None if mission.home is None else mission.home.altitude
        altitude = known if known is not None else Home().altitude if origin.above_home else origin.altitude
        world = dataclasses.replace(world, home=Home(origin.latitude, origin.longitude, altitude))
    home = (world.home.latitude, world.home.longitude, world.home.altitude)
    where = VehicleLocation((0.0, 0.0, 0.0), on_ground=True, frame=LocalFrame(*home), home=home)
    return placed(mission, Origin.LOCAL, where), world


def in_lockstep(simulation: Simulation) -> int:
    """Fly in one process under a simulated clock; the exit code."""
    with ending_signals(say) as signals:
        recorder = begin_record(simulation.directory, simulation.sortie, 0.0, simulation.simulated)
        try:
            return _in_lockstep(simulation, recorder, signals)
        except KeyboardInterrupt:  # before anything flew
            recorder.discard()
            return INTERRUPTED
        except CompanionError:
            recorder.discard()
            raise
        except Exception as error:
            return failed(error, recorder, simulation.ending)


def _in_lockstep(simulation: Simulation, recorder: Recorder, signals: Signals) -> int:
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
    conductor = Conductor(_orders(simulation), recorder, bridge.now)
    listen_to(signals, conductor, recorder)
    with contextlib.ExitStack() as stack:
        truth_file = None
        with contextlib.suppress(OSError):  # no room for it: the record has said so
            truth_file = stack.enter_context(TruthFile(recorder.path("truth.npy")))
        journal = _Journal(recorder, _story(simulation))

        def watch(conductor: Conductor, truth: Truth) -> None:
            if truth_file is not None:
                truth_file.append(truth, bridge.autopilot.commands)
            journal.write(conductor, bridge.now)

        time_out = OVERHEAD + (simulation.duration or 3600.0)
        failure = fly(conductor, bridge, watch, time_out, survive=True)
        journal.write(conductor, bridge.now)
    return finish(conductor, recorder, simulation.ending, Ended(bridge.now, bool(signals.came), failure))


class _Journal:
    """Has the record of a lockstep flight written as it goes on, and says what is to be said."""

    def __init__(self, recorder: Recorder, story: Story) -> None:
        self._recorder = recorder
        self._story = story
        self._shown = Watch(VERBOSE_PROGRESS if is_verbose() else SIMULATED_PROGRESS)
        self._flushed_at = 0.0

    def write(self, conductor: Conductor, now: float) -> None:
        """``now``: s of simulated time."""
        for note in conductor.notes:
            self._recorder.note(now, note)
            say(f"{now:8.2f} s  {note}")
        conductor.notes.clear()
        for sentence in self._story.look(conductor):
            say(f"{now:8.2f} s{sentence}")
        line = self._shown.look(conductor, now)
        if line is not None:
            say(f"{now:8.2f} s  {line}")
        if now - self._flushed_at >= SIMULATED_FLUSH:
            self._flushed_at = now
            self._recorder.flush()
            while self._recorder.words:
                warn(self._recorder.words.popleft())


def over_udp(simulation: Simulation) -> int:
    """Fly with the plant as a process of its own, over loopback in real time; the exit code."""
    port = UdpPort("127.0.0.1", 0, listen=True)
    with contextlib.closing(port), ending_signals(say) as signals:
        recorder = begin_record(simulation.directory, simulation.sortie, time.time() - clock(), simulation.simulated)
        try:
            conductor = Conductor(_orders(simulation), recorder, clock())
            # a session of its own: Ctrl-C must not take the vehicle away before it has been handed back
            plant = subprocess.Popen(_plant_command(simulation, recorder, port), start_new_session=True)
            listen_to(signals, conductor, recorder)
            signals.at_once.insert(0, plant.kill)
            teller = _Teller(_story(simulation), conductor)
            teller.start()
            try:
                failure = run(conductor, port, recorder, say, WAIT_FOR_PLANT)
            finally:
                teller.finish()
                _end(plant)
            return finish(conductor, recorder, simulation.ending, Ended(clock(), bool(signals.came), failure))
        except NoVehicleError as error:
            recorder.discard()
            return no_vehicle(str(error), simulation.ending)
        except KeyboardInterrupt:  # before anything flew
            recorder.discard()
            return INTERRUPTED
        except CompanionError:
            recorder.discard()
            raise
        except Exception as error:
            return failed(error, recorder, simulation.ending)


def _plant_command(simulation: Simulation, recorder: Recorder, port: UdpPort) -> list[str]:
    """What starts the plant."""
    sortie = simulation.sortie
    copy = simulation.directory / "vehicle.yaml"
    vehicle_file = str(copy) if copy.is_file() else sortie.vehicle_source.name  # there was no room for a copy
    mission, world = at_home(sortie.mission, simulation.simulated.world)
    home = f"{world.home.latitude!r},{world.home.longitude!r},{world.home.altitude!r}"
    command = [
        *(sys.executable, "-m", "sim_bridge", "--vehicle", vehicle_file, "--world", simulation.simulated.file),
        *("--connect", f"udpout://127.0.0.1:{port.local[1]}", "--ground-station", "none"),
        *("--home", home, "--seed", str(simulation.simulated.seed), "--truth", str(recorder.path("truth.npy"))),
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
    return command


def _end(plant: subprocess.Popen[bytes]) -> None:
    """End the plant's process."""
    plant.terminate()
    try:
        plant.wait(5.0)
    except subprocess.TimeoutExpired:
        plant.kill()
        plant.wait()


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
