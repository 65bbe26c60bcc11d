"""One flight of the stand-in in lockstep, measured against its path: true and as the vehicle believes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import NamedTuple

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.daemon.asked_of_vehicle import WANTED
from companion.daemon.conductor import Conductor, Orders
from companion.flight.phases import Phase
from companion.frames import Vec3, rotation_matrix, tilt, wrap
from companion.law.gains import law_level
from companion.library.lockstep import fly
from companion.library.simulation import start_of
from companion.mission import Mission, Origin
from companion.profiles import ConstantSpeed
from companion.steering.steering import Estimates
from companion.vehicle import MotorInterface, OutputLevel, Vehicle
from companion.world import Start, World
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Truth

TRUTH_EVERY = 3
"""steps of the plant between two measurements of the truth"""


def steady_wind(speed: float, seed: int) -> Vec3:
    """m/s: a level wind of ``speed``, from another side for every seed."""
    return (speed * math.cos(2.4 * seed), speed * math.sin(2.4 * seed), 0.0)


class Errors(NamedTuple):
    """Root mean squares and largest of the settled part: path error m, speed error m/s, yaw error rad. ``late``: the
    root mean square of the path error of the second half."""

    path: float
    path_max: float
    speed: float
    yaw: float
    late: float


class Measured(NamedTuple):
    """A flight. ``reason``: why it was not completed, or None. ``true`` and ``believed`` from ``settle`` s of following
    on; None if it never came to that. ``tilt_max`` rad and ``speed_max`` m/s of all of following, true."""

    reason: str | None
    true: Errors | None
    believed: Errors | None
    tilt_max: float
    speed_max: float
    estimates: Estimates | None
    conductor: Conductor


def machine(name: str, **changes: object) -> Vehicle:
    """A vehicle of ``configs/``, changed."""
    return dataclasses.replace(load_vehicle(name), **changes)  # type: ignore[arg-type]


def world(name: str, **changes: object) -> World:
    """A world of ``configs/``, changed."""
    return dataclasses.replace(load_world(name), **changes)  # type: ignore[arg-type]


def course(name: str, speed: float | None = None, level: OutputLevel = OutputLevel.RATES) -> Mission:
    """A mission of ``configs/``, at another speed, without an end."""
    read = load_mission(name, law_level(level))
    if speed is not None:
        read = dataclasses.replace(read, speed=ConstantSpeed(speed))
    return dataclasses.replace(read, laps=None)


def measure_flight(
    mission: Mission,
    vehicle: Vehicle,
    where: World,
    level: OutputLevel = OutputLevel.RATES,
    *,
    seed: int = 0,
    duration: float = 25.0,
    settle: float = 10.0,
    over_xrce: bool = False,
    start: Start | None = None,
    prepare: Callable[[Conductor, Bridge], None] | None = None,
    watch: Callable[[Conductor, Truth, float], None] | None = None,
) -> Measured:
    """Fly ``duration`` s of following from a hover on the path (or ``start``). ``over_xrce``: setpoints go to the client
    of a stock PX4, which is there at 125 Hz. ``watch``: called at every step."""
    direct = level is OutputLevel.MOTORS and not over_xrce
    if direct:
        vehicle = dataclasses.replace(vehicle, motors=MotorInterface.DIRECT)
    # what nobody reads of the vehicle's messages is not written
    bridge = Bridge(
        vehicle, where, seed=seed, direct=direct, start=start or start_of(mission), endpoints=1,
        only=None if over_xrce else WANTED, xrce=Release.MAIN if over_xrce else None,
    )  # fmt: skip
    if over_xrce:
        bridge.autopilot.parameters["UXRCE_DDS_SYNCT"] = 0  # or the client is ready 6 s later
    orders = Orders(
        mission, vehicle, level, duration, Origin.LOCAL, set_parameters=True, has_xrce=over_xrce, over_xrce=over_xrce
    )
    conductor = Conductor(orders, None, bridge.now)
    if prepare is not None:
        prepare(conductor, bridge)
    true: list[tuple[float, float, float]] = []
    believed: list[tuple[float, float, float]] = []
    most = [0.0, 0.0]
    near: list[float] = []
    found: list[Estimates | None] = [None]
    count = 0

    def look(conductor: Conductor, truth: Truth) -> None:
        nonlocal count
        if watch is not None:
            watch(conductor, truth, bridge.now)
        memory, plan = conductor.memory, conductor.plan
        if memory is None or plan is None or memory.phase is not Phase.FOLLOW or memory.path.follow_from is None:
            return
        count += 1
        if count % TRUTH_EVERY:
            return
        most[0] = max(most[0], tilt(rotation_matrix(truth.q_nb)))
        most[1] = max(most[1], math.hypot(*truth.v_n))
        since = truth.t_boot - memory.path.follow_from
        if since < settle:
            return
        if not near:
            near.append(memory.path.progress.s if memory.path.progress is not None else 0.0)
        near[0], distance = plan.table.nearest(truth.p_n, near[0], 3.0)
        tangent = plan.table.at(near[0])[1]
        speed = sum(t * v for t, v in zip(tangent, truth.v_n, strict=True))
        yaw = plan.mission.heading.of(rotation_matrix(truth.q_nb))
        true.append((distance, speed - plan.mission.alpha(near[0]), wrap(yaw - plan.mission.beta(near[0]))))
        steered = conductor.last.outcome.steered if conductor.last is not None else None
        if steered is not None and memory.path.progress is not None:
            found[0] = steered.estimates
            command = steered.command
            believed.append(
                (memory.path.progress.path_error, command.speed - command.alpha, wrap(command.yaw - command.beta))
            )

    fly(conductor, bridge, look, duration + 30.0)
    fault = conductor.refusal or (conductor.memory.first_fault if conductor.memory is not None else "no plan")
    reason = fault if fault is not None or conductor.done else "not over in time"
    return Measured(reason, _errors(true), _errors(believed), most[0], most[1], found[0], conductor)


def _errors(rows: list[tuple[float, float, float]]) -> Errors | None:
    if not rows:
        return None
    path, speed, yaw = (math.sqrt(sum(row[i] ** 2 for row in rows) / len(rows)) for i in range(3))
    late = rows[len(rows) // 2 :]
    return Errors(
        path, max(row[0] for row in rows), speed, yaw, math.sqrt(sum(row[0] ** 2 for row in late) / len(late))
    )
