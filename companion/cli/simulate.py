"""``sim``: a mission against the plant, in lockstep or as two processes over UDP."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from companion.cli.around import begin_record, exit_code_of, listen_to
from companion.cli.finish import Ended, Ending, finish
from companion.cli.story import Story
from companion.cli.terminal import is_verbose, say, warn
from companion.daemon.address import UdpPort
from companion.daemon.conductor import Conductor
from companion.daemon.loop import clock, run
from companion.daemon.progress import Watch
from companion.daemon.signals import Signals, ending_signals
from companion.library import simulation as simulation_of
from companion.library.simulation import SimulatedFlight, at_home, orders_of, start_of
from companion.record.folder import Recorder
from companion.vehicle import OutputLevel

SIMULATED_PROGRESS, VERBOSE_PROGRESS = 5.0, 1.0
"""s of simulated time between two lines of progress."""
WAIT_FOR_PLANT = 10.0
"""s for the plant's process to be heard (engineering choice)."""
STORY_PERIOD = 0.1
"""s between two looks at a flight in real time for what there is to tell (engineering choice)."""


@dataclass(frozen=True)
class Simulation(SimulatedFlight):
    """One simulated flight as a command asks for it: where its record goes, and how it is told."""

    directory: Path
    ending: Ending


def in_lockstep(simulation: Simulation) -> int:
    """Fly in one process under a simulated clock; the exit code."""
    with ending_signals(say) as signals:
        recorder = begin_record(simulation.directory, simulation.sortie, 0.0, simulation.simulated)
        return exit_code_of(lambda: _in_lockstep(simulation, recorder, signals), recorder, simulation.ending)


def _in_lockstep(simulation: Simulation, recorder: Recorder, signals: Signals) -> int:
    journal = _Journal(recorder, _story(simulation))

    def begun(conductor: Conductor) -> Callable[[float], None]:
        listen_to(signals, conductor, recorder)
        return lambda now: journal.write(conductor, now)

    flown = simulation_of.in_lockstep(simulation, recorder, begun)
    ended = Ended(flown.now, bool(signals.came), flown.failure)
    return finish(flown.conductor, recorder, simulation.ending, ended)


class _Journal:
    """Says what is to be said of a lockstep flight, and keeps it."""

    def __init__(self, recorder: Recorder, story: Story) -> None:
        self._recorder = recorder
        self._story = story
        self._shown = Watch(VERBOSE_PROGRESS if is_verbose() else SIMULATED_PROGRESS)

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
        while self._recorder.words:
            warn(self._recorder.words.popleft())


def over_udp(simulation: Simulation) -> int:
    """Fly with the plant as a process of its own, over loopback in real time; the exit code."""
    with contextlib.ExitStack() as stack:
        ports = [stack.enter_context(contextlib.closing(UdpPort("127.0.0.1", 0, listen=True)))]
        if simulation.xrce:
            ports.append(stack.enter_context(contextlib.closing(UdpPort("127.0.0.1", 0, listen=True))))
        signals = stack.enter_context(ending_signals(say))
        recorder = begin_record(simulation.directory, simulation.sortie, time.time() - clock(), simulation.simulated)
        return exit_code_of(lambda: _over_udp(simulation, ports, recorder, signals), recorder, simulation.ending)


def _over_udp(simulation: Simulation, ports: list[UdpPort], recorder: Recorder, signals: Signals) -> int:
    """``ports``: of MAVLink and, where it is flown over that, of XRCE."""
    conductor = Conductor(orders_of(simulation), recorder, clock())
    # a session of its own: Ctrl-C must not take the vehicle away before it has been handed back
    plant = subprocess.Popen(_plant_command(simulation, recorder, ports), start_new_session=True)
    listen_to(signals, conductor, recorder)
    signals.at_once.insert(0, plant.kill)
    teller = _Teller(_story(simulation), conductor)
    teller.start()
    try:
        failure = run(conductor, ports[0], recorder, say, WAIT_FOR_PLANT, xrce=ports[-1] if simulation.xrce else None)
    finally:
        teller.finish()
        _end(plant)
    return finish(conductor, recorder, simulation.ending, Ended(clock(), bool(signals.came), failure))


def _plant_command(simulation: Simulation, recorder: Recorder, ports: list[UdpPort]) -> list[str]:
    """What starts the plant."""
    sortie = simulation.sortie
    copy = simulation.directory / "vehicle.yaml"
    vehicle_file = str(copy) if copy.is_file() else sortie.vehicle_source.name  # there was no room for a copy
    mission, world = at_home(sortie.mission, simulation.simulated.world)
    home = f"{world.home.latitude!r},{world.home.longitude!r},{world.home.altitude!r}"
    command = [
        *(sys.executable, "-m", "sim_bridge", "--vehicle", vehicle_file, "--world", simulation.simulated.file),
        *("--connect", f"udpout://127.0.0.1:{ports[0].local[1]}", "--ground-station", "none"),
        *("--home", home, "--seed", str(simulation.simulated.seed), "--truth", str(recorder.path("truth.npy"))),
    ]
    if simulation.xrce:
        command += ["--xrce-agent", f"127.0.0.1:{ports[1].local[1]}"]
    elif sortie.level is OutputLevel.MOTORS:
        command += ["--motors", "direct"]
    if not simulation.from_ground:
        start = start_of(mission)
        values = {
            "position_n": list(start.position_n),
            "velocity_n": list(start.velocity_n),
            "q_nb": list(start.q_nb),
            "rates_b": list(start.rates_b),
            "held": start.held,
        }
        command += ["--start", json.dumps(values)]
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
