"""Lockstep flights for the tests: the daemon's own conductor against the plant, with somebody in between."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.conductor import Conductor, Orders
from companion.feasibility.auto import flyable
from companion.flight.conduct import Conduct
from companion.law.gains import law_level
from companion.library.lockstep import fly
from companion.library.simulation import start_of
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Value, message
from companion.mission import Origin
from companion.profiles import ConstantSpeed
from companion.record.folder import Recorder, Source
from companion.vehicle import MotorInterface, OutputLevel, Setpoint
from companion.world import Start, World
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth
from sim_bridge.world_events import COMPANION, GROUND_STATION, XRCE


class Between:
    """Stands between companion and plant with the plant's own doors: every datagram passes through two filters, what is
    XRCE's apart. ``dead``: neither hears the other any more."""

    def __init__(self, bridge: Bridge) -> None:
        self.bridge = bridge
        self.down: Callable[[bytes, float], list[bytes]] = lambda data, now: [data]
        self.up: Callable[[bytes, float], list[bytes]] = lambda data, now: [data]
        self.dead = False
        self.sent: list[tuple[float, Frame]] = []
        self._decoder = Decoder()

    @property
    def now(self) -> float:
        return self.bridge.now

    @property
    def truth(self) -> Truth:
        return self.bridge.truth

    @property
    def ports_dialled(self) -> int:
        return self.bridge.ports_dialled

    def step(self) -> None:
        self.bridge.step()

    def datagrams(self) -> list[tuple[int, bytes]]:
        passed = []
        for endpoint, data in self.bridge.datagrams():
            if endpoint == XRCE and not self.dead:
                passed.append((endpoint, data))
            elif endpoint == COMPANION and not self.dead:
                passed += [(endpoint, kept) for kept in self.down(data, self.now)]
        return passed

    def receive(self, data: bytes, endpoint: int = COMPANION) -> None:
        if self.dead:
            return
        if endpoint == XRCE:
            self.bridge.receive(data, XRCE)
            return
        for kept in self.up(data, self.now):
            self.sent += [(self.now, frame) for frame in self._decoder.datagram(kept)]
            self.bridge.receive(kept, endpoint)


@dataclass
class Flown:
    """A flight that is over."""

    conductor: Conductor
    between: Between
    notes: list[str] = field(default_factory=list)
    setpoints: list[tuple[float, Setpoint]] = field(default_factory=list)
    path_errors: list[tuple[float, float]] = field(default_factory=list)

    @property
    def reason(self) -> str | None:
        assert self.conductor.memory is not None
        return self.conductor.memory.first_fault

    @property
    def last_note(self) -> str:
        return self.notes[-1]


def flight(
    mission: str = "circle_r5",
    vehicle: str = "x500",
    level: OutputLevel = OutputLevel.MOTORS,
    duration: float | None = 8.0,
    speed: float | None = None,
    world: World | None = None,
    from_ground: bool = False,
    seed: int = 0,
    record: Path | None = None,
    time_out: float = 120.0,
    conduct: Conduct | None = None,
    start: Start | None = None,
    origin: Origin = Origin.LOCAL,
    xrce: bool = False,
    prepare: Callable[[Flown], None] | None = None,
    meddle: Callable[[Flown, float], None] | None = None,
) -> Flown:
    """Fly in lockstep. ``prepare`` is called before the first step, ``meddle`` after every step with the time.
    ``speed``: m/s all along, in the place of the mission's. ``xrce``: the vehicle is a stock PX4 and has a client."""
    machine = load_vehicle(vehicle)
    if level is OutputLevel.MOTORS and not xrce:
        machine = dataclasses.replace(machine, motors=MotorInterface.DIRECT)
    read = load_mission(mission, law_level(level))
    if speed is not None:
        read = dataclasses.replace(read, speed=ConstantSpeed(speed))
    read = flyable(read, machine)
    bridge = Bridge(
        machine, world or World(), seed=seed, direct=level is OutputLevel.MOTORS and not xrce,
        start=None if from_ground else start or start_of(read), landed=from_ground, xrce=Release.MAIN if xrce else None,
    )  # fmt: skip
    between = Between(bridge)
    recorder = None
    if record is not None:
        shipped = Path(__file__).parents[2] / "configs"
        sources = [
            Source(name, (shipped / kind / f"{name}.yaml").read_text())
            for kind, name in (("missions", mission), ("vehicles", vehicle))
        ]
        recorder = Recorder(record, *sources, epoch=0.0)
    conduct = (conduct or Conduct())._replace(at_once=read.start is not None)
    orders = Orders(
        read, machine, level, duration, origin, set_parameters=True, conduct=conduct, has_xrce=xrce,
        over_xrce=xrce and level.without_rate_loop,
    )  # fmt: skip
    conductor = Conductor(orders, recorder, 0.0)
    flown = Flown(conductor, between)
    if prepare is not None:
        prepare(flown)

    def watch(conductor: Conductor, truth: Truth) -> None:
        flown.notes += conductor.notes
        conductor.notes.clear()
        if conductor.last is not None and conductor.last.now == between.now:
            if conductor.last.outcome.setpoint is not None:
                flown.setpoints.append((between.now, conductor.last.outcome.setpoint))
            if conductor.last.memory.path.progress is not None:
                flown.path_errors.append((between.now, conductor.last.memory.path.progress.path_error))
        if meddle is not None:
            meddle(flown, between.now)

    fly(conductor, between, watch, time_out)  # type: ignore[arg-type]
    flown.notes += conductor.notes
    if recorder is not None:
        recorder.close()
    return flown


class Operator:
    """A ground station on the plant's other endpoint."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._encoder = Encoder(255, 190)

    def says(self, name: str, **fields: Value) -> None:
        self._bridge.receive(self._encoder.message(message(name), **fields), GROUND_STATION)

    def commands(self, command: int, *parameters: float) -> None:
        padded = {f"param{i + 1}": value for i, value in enumerate(parameters)}
        self.says("COMMAND_LONG", command=command, target_system=1, target_component=1, **padded)


def once(at: float, action: Callable[[Flown], None]) -> Callable[[Flown, float], None]:
    """A meddling that happens once, at a time."""
    done: list[bool] = []

    def meddle(flown: Flown, now: float) -> None:
        if now >= at and not done:
            done.append(True)
            action(flown)

    return meddle


def name_of(data: bytes) -> str:
    """The message that a datagram of one frame is."""
    (frame,) = Decoder().datagram(data)
    return frame.format.name


def silent(*names: str, since: float) -> Callable[[Flown], None]:
    """These messages of the vehicle come no more."""

    def prepare(flown: Flown) -> None:
        flown.between.down = lambda data, now: [] if now >= since and name_of(data) in names else [data]

    return prepare
