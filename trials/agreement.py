"""Random missions, and what flying them asked for: for holding `check` to what happens. By the Python API alone."""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

import numpy as np
import yaml

import companion
from companion.frames import Vec3
from companion.library.calls import Check
from companion.library.files import MissionFile
from companion.library.flights import Flight

SETTLE = 12.0
"""s of following until the start is forgotten."""
LAP_MAX = 25.0


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


class RandomMission(NamedTuple):
    """A closed mission but for its speed, in whose formula ``SPEED`` stands for a factor."""

    path: dict[str, Any]
    speed: str
    yaw: Any

    def at(self, speed: float) -> MissionFile:
        """The mission with that factor, m/s."""
        along = self.speed.replace("SPEED", repr(speed))
        return companion.new_mission("random", self.path, along, self.yaw, frame="enu", origin="local")


def random_mission(seed: int) -> RandomMission:
    """A closed mission of any kind for an x500, its speed and yaw of any kind."""
    rng = random.Random(seed)
    height = rng.uniform(12.0, 20.0)
    path = _mapping((_round, _lissajous, _through_points, _trefoil)[seed % 4](rng, height))
    length = companion.new_mission("random", path, 1, frame="enu").length
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
    return RandomMission(path, speed, yaml.safe_load(yaw))


def _mapping(path: str) -> dict[str, Any]:
    read: dict[str, Any] = yaml.safe_load(f"{{{path}}}")
    return read


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


def scaled(mission: RandomMission, share: float, vehicle: str, output: str) -> tuple[MissionFile, Check]:
    """The mission at ``share`` of the fastest speed that the vehicle can fly it at, and what is asked there."""
    fastest = companion.check(mission.at(1.0), vehicle, output=output).speed_scale_max
    file = mission.at(share * fastest)
    return file, companion.check(file, vehicle, output=output)


def asked(check: Check) -> Extremes:
    """What ``check`` says a lap asks for."""
    a = check.report.asked
    return Extremes(
        float(a.thrust.min()),
        float(a.thrust.max()),
        float(a.tilt.max()),
        float(a.motors.min()),
        float(a.motors.max()),
    )


def flown(mission: MissionFile, vehicle: str, output: str, lap: float, settle: float = SETTLE) -> Flown:
    """``lap`` s on the ideal plant, after ``settle`` s of following."""
    endless = mission.changed({"laps": None})
    flight = companion.simulate(endless, vehicle, output=output, duration=settle + lap, settle=settle)
    assert flight.completed, flight.summary["reason"]
    return _settled(flight, [rotor.thrust_max for rotor in companion.load_vehicle(vehicle).value.rotors], settle)


def _settled(flight: Flight, thrust_max: list[float], settle: float) -> Flown:
    truth, true = flight.truth, flight.followed_truth
    assert truth is not None
    assert true is not None
    late = {name: values[true["since"] >= settle] for name, values in true.items()}
    t_boot = flight.followed["t_boot"]
    then = truth[(truth["t_boot"] >= t_boot[0] + settle) & (truth["t_boot"] <= t_boot[-1])]
    shares = then["rotor_thrusts"] / thrust_max
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
