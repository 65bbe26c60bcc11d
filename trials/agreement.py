"""Random missions, and what flying them asked for: for holding `check` to what happens."""

from __future__ import annotations

import dataclasses
import math
import random
from typing import NamedTuple

import numpy as np

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.feasibility.report import Report, check
from companion.frames import Vec3
from companion.law.gains import law_level
from companion.library.orders import Sortie
from companion.library.outcome import Ended, reason_of
from companion.library.simulation import SimulatedFlight, in_memory
from companion.mission import Mission
from companion.record.circumstances import SimulatedWorld
from companion.record.folder import Source
from companion.record.series import followed_series, true_series
from companion.vehicle import MotorInterface, OutputLevel, Vehicle
from companion.world import World

SETTLE = 12.0
"""s of following until the start is forgotten."""
LAP_MAX = 25.0
UNWRITTEN = Source("", "")
"""In the place of a file, where a mission and a vehicle are values."""


class Extremes(NamedTuple):
    """What was asked of a vehicle: thrust N, tilt rad, motors as shares of their range; the least and the most."""

    thrust_min: float
    thrust_max: float
    tilt_max: float
    motor_min: float
    motor_max: float


class Flown(NamedTuple):
    """A settled lap: the extremes of the true state, and the largest errors: m, share of alpha, rad. ``time``: s.
    ``rates``: the largest body rates, rad/s; ``speed``: the largest speed, m/s."""

    extremes: Extremes
    rates: Vec3
    speed: float
    path_error: float
    speed_error: float
    yaw_error: float
    time: float


def random_mission(seed: int) -> str:
    """A closed mission of any kind for an x500, its speed and yaw of any kind; ``SPEED`` stands for its factor."""
    rng = random.Random(seed)
    height = rng.uniform(12.0, 20.0)
    path = (_round, _lissajous, _through_points, _trefoil)[seed % 4](rng, height)
    length = _read(path, "1", "0").table.length
    k = rng.randint(1, 2)
    speed = rng.choice(
        [
            "SPEED",
            "-SPEED",
            f"SPEED*(1 + 0.2*sin({k}*2*pi*s/{length!r}))",
            f"-SPEED*(1 + 0.15*cos(2*pi*s/{length!r}))",
        ]
    )
    look_at = f"{{look_at: [{rng.uniform(-1, 1):.2f}, {rng.uniform(-1, 1):.2f}, 0]}}"
    far = f"{{look_at: [{rng.uniform(40, 60):.1f}, {rng.uniform(-60, -40):.1f}, 0]}}"
    near = look_at if seed % 4 != 1 else far  # a Lissajous curve leads through its middle
    yaw = rng.choice([f"{rng.uniform(-170, 170):.1f}", "tangent", near, far, f"40*sin(2*pi*s/{length!r})"])
    return _text(path, speed, yaw)


def _text(path: str, speed: str, yaw: str) -> str:
    return f"mission: random\nframe: enu\norigin: local\npath: {{{path}}}\nspeed: {speed}\nyaw: {yaw}\n"


def _read(path: str, speed: str, yaw: str) -> Mission:
    return mission_from(parse(_text(path, speed, yaw), "random.yaml"), None)


def _round(rng: random.Random, height: float) -> str:
    normal = f"normal: [{rng.uniform(-0.25, 0.25):.3f}, {rng.uniform(-0.25, 0.25):.3f}, 1]"
    if rng.random() < 0.5:
        return f"kind: circle, center: [0, 0, {height:.2f}], radius: {rng.uniform(4, 9):.2f}, {normal}"
    axes = f"axes: [{rng.uniform(5, 8):.2f}, {rng.uniform(8, 11):.2f}]"
    return f"kind: ellipse, center: [0, 0, {height:.2f}], {axes}, {normal}"


def _lissajous(rng: random.Random, height: float) -> str:
    amplitude = f"[{rng.uniform(6, 9):.2f}, {rng.uniform(3, 5):.2f}, {rng.uniform(0, 1.5):.2f}]"
    phase = f"phase_deg: [{rng.uniform(80, 100):.1f}, 0, {rng.uniform(0, 90):.1f}]"
    return f"kind: lissajous, center: [0, 0, {height:.2f}], amplitude: {amplitude}, frequency: [1, 2, 1], {phase}"


def _through_points(rng: random.Random, height: float) -> str:
    points = []
    for i in range(6):
        r, turn = rng.uniform(6, 10), math.tau * (i + rng.uniform(-0.15, 0.15)) / 6
        points.append(f"[{r * math.cos(turn):.2f}, {r * math.sin(turn):.2f}, {height + rng.uniform(-1, 1):.2f}]")
    given = f"points: [{', '.join(points)}], closed: true"
    return f"kind: spline, {given}" if rng.random() < 0.6 else f"kind: polyline, {given}, corner_tolerance: 1.0"


def _trefoil(rng: random.Random, height: float) -> str:
    a, b = rng.uniform(5.0, 7.0), rng.uniform(0.6, 1.2)
    x = f"{a:.2f}*cos(u) + {b:.2f}*cos(2*u)"
    y = f"{a:.2f}*sin(u) - {b:.2f}*sin(2*u)"
    z = f"{height:.2f} + {rng.uniform(0, 1):.2f}*sin(3*u)"
    return f"kind: expression, x: {x}, y: {y}, z: {z}, u: [0, {math.tau!r}], closed: true"


def scaled(text: str, share: float, vehicle: Vehicle, level: OutputLevel) -> tuple[Mission, Report]:
    """The mission at ``share`` of the fastest speed that the vehicle can fly it at, and what is asked there."""

    def at(speed: float) -> Mission:
        return mission_from(parse(text.replace("SPEED", repr(speed)), "random.yaml"), law_level(level))

    fastest = check(at(1.0), vehicle).speed_scale_max
    mission = at(share * fastest)
    return mission, check(mission, vehicle)


def asked(report: Report) -> Extremes:
    """What ``check`` says a lap asks for."""
    a = report.asked
    return Extremes(
        float(a.thrust.min()),
        float(a.thrust.max()),
        float(a.tilt.max()),
        float(a.motors.min()),
        float(a.motors.max()),
    )


def flown(report: Report, level: OutputLevel, settle: float = SETTLE, laps: float = 1.0) -> Flown:
    """A lap on the ideal plant in lockstep, after ``settle`` s of following."""
    vehicle = report.vehicle
    if level is OutputLevel.MOTORS:
        vehicle = dataclasses.replace(vehicle, motors=MotorInterface.DIRECT)
    sortie = Sortie(dataclasses.replace(report.mission, laps=None), vehicle, level, UNWRITTEN, UNWRITTEN)
    duration = settle + laps * report.duration
    ideal = SimulatedWorld(World(), "ideal", "", 0)
    went, ticks, truth = in_memory(SimulatedFlight(sortie, ideal, False, duration, lean=True))
    assert went.failure is None, went.failure.trace
    plan = went.conductor.plan
    assert plan is not None, went.conductor.refusal
    told = followed_series(ticks.table)
    assert told["t"].max(initial=0.0) > settle, "it was not followed: " + reason_of(
        went.conductor, Ended(went.now, False)
    )
    true = true_series(plan, told, truth)
    late = {name: values[true["since"] >= settle] for name, values in true.items()}
    then = truth[(truth["t_boot"] >= told["t_boot"][0] + settle) & (truth["t_boot"] <= told["t_boot"][-1])]
    shares = then["rotor_thrusts"] / [rotor.thrust_max for rotor in vehicle.rotors]
    thrust, (_, x, y, _) = then["rotor_thrusts"].sum(axis=1), then["q_nb"].T
    p, q, r = (float(rate) for rate in np.abs(then["w_b"]).max(axis=0))
    return Flown(
        Extremes(
            float(thrust.min()), float(thrust.max()), float(np.arccos(1.0 - 2.0 * (x * x + y * y)).max()),
            float(shares.min()), float(shares.max()),
        ),
        (p, q, r),
        float(np.linalg.norm(then["v_n"], axis=1).max()),
        float(late["path_error"].max()),
        float(np.abs(late["speed_error"] / late["alpha"]).max()),
        float(np.abs(late["yaw_error"]).max()),
        float(then["t_boot"][-1] - then["t_boot"][0]),
    )  # fmt: skip
