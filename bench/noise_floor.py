"""How near path, speed and heading any controller could stay with what sih_noisy reports: ``python -m
bench.noise_floor``.

The world, axis by axis and linear, is ``bench.noise_world``; ours in it ``bench.noise_flown``. LQG: the gain of one
Riccati equation (e^2 + rho u^2), the filter of the other. Of all linear controllers with that much command this has the
least e; with rho towards zero the bound falls to that of a vehicle that may shake at will. rho is set so that both
command alike. Where the path bends the world is taken at places along it, and the mean of their variances is told.
docs/estimation.md has the tables.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

from bench.noise_flown import flown
from bench.noise_heading import heading_plant
from bench.noise_motors import flown_level, flown_vertical
from bench.noise_world import DRAG, Place, Plant, axis_at
from companion.law.gains import poles_of, with_path_poles
from companion.plan import gains_of, prepared
from companion.vehicle import OutputLevel, Tuning, Vehicle
from trials.measured import course, machine

CASES = (("circle_r5", 3.0, 1.0), ("circle_r5", 5.0, 1.0), ("circle_r5", 7.0, 0.969), ("figure8", 3.0, 1.0))
"""Mission, m/s, scale on the path poles: what steering.path_poles leaves of them in flight where the tilt is steep."""
PLACES = 12
"""Number of places along a path that bends."""
YAW_COMMANDS = (5.0, 10.0, 20.0)
"""deg/s of yaw rate commanded, of noise."""
MISTAKES = (
    ("all as told", 0.05, 0.05, 1.0),
    ("motors lag 15 ms, told 50", 0.015, 0.05, 1.0),
    ("motors lag 75 ms, told 50", 0.075, 0.05, 1.0),
    ("motors lag 60 ms, told 25", 0.06, 0.025, 1.0),
    ("thrust curve 0.3 at hover 0.5", 0.05, 0.05, 1.18),
    ("60 ms, told 25, and the curve", 0.06, 0.025, 1.18),
)
"""What; s of motor lag, true and told; thrust made over thrust asked for about the mean: of a curve m at a command u
(1 - m + 2 m u) / (1 - m + m u), the mean itself being found as the thrust scale."""


Group = tuple[complex, ...]
"""1/s."""


class Poles(NamedTuple):
    """Of the level distance, the vertical one and the speed."""

    level: Group
    vertical: Group
    speed: Group


SLOWER = Poles((-6.0,) * 3, (-6.0,) * 3, (-2.5,) * 2)
"""What was chosen for all before."""
SLOWER_AT_MOTORS = Poles((-6.0, -6.0, -6.0, -14.0), (-6.0, -6.0, -6.0, -14.0), (-3.0, -3.0, -14.0))
"""And at motors."""


def chosen(vehicle: Vehicle, scale: float = 1.0, output: OutputLevel = OutputLevel.RATES) -> Poles:
    """What gains: auto gives it. ``scale``: on the path poles."""
    gains = with_path_poles(gains_of(course("circle_r5"), vehicle, output, Tuning(), None), scale)
    level, vertical, speed = (tuple(poles_of(each)) for each in (gains.h1, gains.vertical or gains.h1, gains.h3))
    return Poles(level, vertical, speed)


def optimal(plant: Plant, rho: float) -> tuple[float, float]:
    """LQG for a cost of e^2 + rho u^2: deviations of e (m, m/s or rad) and of the command."""
    A, B, C = plant.A, plant.B, plant.C
    X = solve_discrete_are(A, B, np.outer(plant.e, plant.e) + 1e-12 * np.eye(len(A)), np.array([[rho]]))
    K = np.linalg.solve(B.T @ X @ B + rho, B.T @ X @ A)
    P = solve_discrete_are(A.T, C.T, plant.W + 1e-14 * np.eye(len(A)), plant.R)
    L = P @ C.T @ np.linalg.inv(C @ P @ C.T + plant.R)
    known = P - L @ C @ P  # of the estimate with the newest state
    # the estimate moves by what the filter learns at each step; e is the estimate and its error
    moved = solve_discrete_lyapunov(A - B @ K, L @ (C @ P @ C.T + plant.R) @ L.T)
    return math.sqrt(plant.e @ (moved + known) @ plant.e), math.sqrt((K @ moved @ K.T).item())


def bound(plant: Plant, command: float) -> float:
    """The least e for a command of at most this deviation."""
    low, high = -16.0, 2.0
    for _ in range(18):
        middle = 0.5 * (low + high)
        if optimal(plant, 10.0**middle)[1] > command:
            low = middle
        else:
            high = middle
    return optimal(plant, 10.0**high)[0]


def places(mission: str, speed: float, vehicle: Vehicle) -> list[Place]:
    """Of a path at a speed (m/s); one is enough for a circle."""
    table = prepared(course(mission, speed), vehicle, OutputLevel.RATES, (0.0, 0.0, 0.0)).table
    found, h = [], 0.05
    for k in range(1 if mission.startswith("circle") else PLACES):
        s = table.length * k / PLACES
        (ax, ay, _), (bx, by, _) = table.at(s - h)[1], table.at(s + h)[1]
        bend = math.remainder(math.atan2(by, bx) - math.atan2(ay, ax), math.tau) / (2.0 * h)
        # rounded: a straight line is straight, or Riccati's equation has a state that hardly counts
        found.append(Place(round(abs(speed * speed * bend), 6), DRAG * speed, round(speed * bend, 6)))
    return found


def mean(values: Sequence[float]) -> float:
    """Root of the mean square."""
    return math.sqrt(sum(value * value for value in values) / len(values))


class Least(NamedTuple):
    """Ours and the least, m or m/s. ``believed``: ours, as the filter has it."""

    ours: float
    least: float
    believed: float

    def per(self, unit: float) -> str:
        """Ours and the least in a unit."""
        return f"{self.ours / unit:5.2f} {self.least / unit:5.2f}"


def least(where: list[Place], vehicle: Vehicle, poles: Poles, *, vertical: bool = False, along: bool = False) -> Least:
    """Of the level distance, the vertical one, or the speed."""
    group = poles.speed if along else poles.vertical if vertical else poles.level
    rows = []
    for place in where:
        plant = axis_at(place, vehicle, vertical=vertical, along=along)
        loop = flown(plant, vehicle, group, vertical=vertical)
        assert loop is not None
        rows.append((loop.error, bound(plant, loop.command), loop.believed))
    return Least(*(mean(column) for column in zip(*rows, strict=True)))


def least_at_motors(
    where: list[Place], vehicle: Vehicle, poles: Poles, *, vertical: bool = False, along: bool = False
) -> Least:
    """As ``least``; the bound of the height is that of the same rate of the thrust."""
    rows = []
    for place in where:
        plant = bounded = axis_at(place, vehicle, vertical=vertical, along=along, at_motors=True)
        if vertical:
            loop, bounded = flown_vertical(plant, vehicle, poles.vertical), axis_at(place, vehicle, vertical=True)
        else:
            loop = flown_level(plant, vehicle, poles.speed if along else poles.level)
        assert loop is not None
        rows.append((loop.error, bound(bounded, loop.command), loop.believed))
    return Least(*(mean(column) for column in zip(*rows, strict=True)))


def floor_at_motors(vehicle: Vehicle, always: Poles | None) -> None:
    """Print a line a mission and speed, as ``floor`` does."""
    print("at motors: ours, least       | level cm    | vertical cm | together, ratio  | speed %, believed")
    for mission, speed, scale in CASES:
        poles = always or chosen(vehicle, scale, OutputLevel.MOTORS)
        where = places(mission, speed, vehicle)
        level = least_at_motors(where, vehicle, poles)
        vertical = least_at_motors(where, vehicle, poles, vertical=True)
        along = least_at_motors(where, vehicle, poles, along=True)
        both, limit = math.hypot(level.ours, vertical.ours), math.hypot(level.least, vertical.least)
        print(
            f"{mission:9} {speed:g} m/s {size(poles.level):5.1f} {size(poles.vertical):5.1f} |"
            f" {level.per(0.01)} | {vertical.per(0.01)} | {100 * both:5.2f} {100 * limit:5.2f} {both / limit:5.2f} |"
            f" {along.per(0.01 * speed)} {100 * along.believed / speed:5.2f}",
            flush=True,
        )


def size(group: Group) -> float:
    """1/s: of the slowest pole."""
    return -min(map(abs, group))


def floor(vehicle: Vehicle, always: Poles | None) -> None:
    """Print a line a mission and speed, with the poles that are chosen or ``always`` the same."""
    yaw_rates = ", ".join(f"{each:g}" for each in YAW_COMMANDS)
    print(
        "ours, least: poles           | level cm    | vertical cm | together, ratio  | speed %, believed |"
        f" heading deg, least, at {yaw_rates} deg/s"
    )
    for mission, speed, scale in CASES:
        poles = always or chosen(vehicle, scale)
        where = places(mission, speed, vehicle)
        level = least(where, vehicle, poles)
        vertical = least(where, vehicle, poles, vertical=True)
        along = least(where, vehicle, poles, along=True)
        both, limit = math.hypot(level.ours, vertical.ours), math.hypot(level.least, vertical.least)
        yaw = [
            mean([bound(heading_plant(place, vehicle, poles.level), math.radians(each)) for place in where])
            for each in YAW_COMMANDS
        ]
        print(
            f"{mission:9} {speed:g} m/s {poles.level[0].real:5.1f} {poles.vertical[0].real:5.1f} |"
            f" {level.per(0.01)} | {vertical.per(0.01)} |"
            f" {100 * both:5.2f} {100 * limit:5.2f} {both / limit:5.2f} |"
            f" {along.per(0.01 * speed)} {100 * along.believed / speed:5.2f} |"
            f" {' '.join(f'{math.degrees(each):.2f}' for each in yaw)}",
            flush=True,
        )


def mistakes(vehicle: Vehicle, poles: Poles) -> None:
    """Print what wrong files make of it at 3 m/s."""
    print("wrong files, circle 3 m/s | level cm, vertical cm, together")
    place = places("circle_r5", 3.0, vehicle)[0]
    for what, lag, told_lag, gain in MISTAKES:
        true, told = (dataclasses.replace(vehicle, motor_lag=each) for each in (lag, told_lag))
        off = []
        for vertical, group in ((False, poles.level), (True, poles.vertical)):
            loop = flown(axis_at(place, true, vertical=vertical, gain=gain), told, group, vertical=vertical)
            off.append(math.inf if loop is None else 100.0 * loop.error)
        print(f"{what:30} | {off[0]:5.2f} {off[1]:5.2f} {math.hypot(*off):5.2f}")


def main() -> None:
    """Print the tables."""
    vehicle = machine("sih")
    floor(vehicle, None)
    floor(vehicle, SLOWER)
    mistakes(vehicle, chosen(vehicle))
    floor_at_motors(vehicle, None)
    floor_at_motors(vehicle, SLOWER_AT_MOTORS)


if __name__ == "__main__":
    main()
