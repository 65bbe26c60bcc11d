"""Paths under the noise of a real frame: ``python -m bench.noisy_flights plain [LEVEL]``, or ``[FIRST [COUNT]]``.

sih_noisy, 40 s of following, believed figures from 10 s on. ``plain``: the right vehicle file and still air, the mean
of three seeds a line; LEVEL: rates, or motors or torques, which go over XRCE. Otherwise wrong files and wind, a flight
a line: a steady wind of 3 m/s, hover thrust told wrong by +-15 % and drag by +-50 %. The tilt of the vehicle file is 60
deg at 7 m/s, with wind from 5 m/s on.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from typing import NamedTuple

from companion.vehicle import OutputLevel
from trials.measured import Measured, course, machine, measure_flight, steady_wind, world


class Case(NamedTuple):
    """A flight. ``speed``: m/s. ``hover``, ``drag``: told over true. ``wind``: m/s."""

    mission: str
    speed: float
    seed: int
    hover: float = 1.0
    drag: float = 1.0
    wind: float = 0.0


PLAIN = (("circle_r5", 3.0), ("circle_r5", 5.0), ("circle_r5", 7.0), ("figure8", 3.0))
"""Mission, m/s."""
SEEDS = (1, 2, 3)
"""Of each."""
WIND = 3.0
"""m/s."""
WRONG = (
    Case("circle_r5", 3.0, 1, 1.15, 0.5, WIND), Case("circle_r5", 3.0, 8, 0.85, 1.5, WIND),
    Case("circle_r5", 5.0, 2, 0.85, 1.5, WIND), Case("circle_r5", 5.0, 6, 1.15, 0.5, WIND),
    Case("circle_r5", 7.0, 3, 1.15, 1.5, WIND), Case("circle_r5", 7.0, 5, 0.85, 0.5, WIND),
    Case("figure8", 3.0, 4, 0.85, 0.5, WIND), Case("figure8", 3.0, 7, 1.15, 1.5, WIND),
)  # fmt: skip


class Figures(NamedTuple):
    """Believed. ``path``, ``path_max``: cm. ``speed``: percent. ``yaw``, ``tilt``: deg."""

    path: float
    path_max: float
    speed: float
    yaw: float
    tilt: float

    def __str__(self) -> str:
        return (
            f"path {self.path:.2f} cm (most {self.path_max:.1f}), speed {self.speed:.1f} %,"
            f" heading {self.yaw:.1f} deg, tilt to {self.tilt:.0f} deg"
        )


def fly(case: Case, *, noisy: bool = True, level: OutputLevel = OutputLevel.RATES) -> Measured:
    """A flight of 40 s. ``noisy``: in sih_noisy, not in sih."""
    true = machine("sih")
    limits = true.limits
    assert limits is not None
    if case.speed >= (5.0 if case.wind else 7.0):
        limits = dataclasses.replace(limits, tilt=math.radians(60.0))
    told = dataclasses.replace(true, drag=true.drag * case.drag, hover_thrust=0.4905 * case.hover, limits=limits)
    where = world("sih_noisy" if noisy else "sih", wind_n=steady_wind(case.wind, case.seed))
    where = dataclasses.replace(where, truth=dataclasses.replace(where.truth, drag=true.drag))
    return measure_flight(
        course(case.mission, case.speed, level), told, where, level, seed=case.seed, duration=40.0,
        over_xrce=level.without_rate_loop,
    )  # fmt: skip


def figures(done: Measured, speed: float) -> Figures | None:
    """Of a flight at ``speed`` (m/s); None where it was not flown to its end."""
    known = done.believed
    if done.reason is not None or known is None:
        return None
    return Figures(
        100.0 * known.path, 100.0 * known.path_max, 100.0 * known.speed / speed, math.degrees(known.yaw),
        math.degrees(done.tilt_max),
    )  # fmt: skip


def main(first: int, count: int) -> None:
    """Print a line a flight."""
    for case in WRONG[first : first + count]:
        done = fly(case)
        head = f"{case.mission} {case.speed:g} m/s, hover {case.hover:g}, drag {case.drag:g}, seed {case.seed}"
        print(f"{head}: {figures(done, case.speed) or done.reason}", flush=True)


def plain(level: OutputLevel) -> None:
    """Print a line a mission and speed: the mean over the seeds, and what quiet air and sensors make of it."""
    for mission, speed in PLAIN:
        every = [figures(fly(Case(mission, speed, seed), level=level), speed) for seed in SEEDS]
        flown = [each for each in every if each is not None]
        lost = f", {len(every) - len(flown)} of {len(every)} not flown to the end" if len(flown) < len(every) else ""
        mean = Figures(*(sum(column) / len(flown) for column in zip(*flown, strict=True))) if flown else "none flown"
        quiet = figures(fly(Case(mission, speed, 1), noisy=False, level=level), speed)
        print(f"{mission} {speed:g} m/s: {mean}{lost} | sih: {quiet}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["plain"]:
        plain(OutputLevel(sys.argv[2] if len(sys.argv) > 2 else "rates"))
    else:
        asked = [int(word) for word in sys.argv[1:3]]
        main(asked[0] if asked else 0, asked[1] if len(asked) > 1 else len(WRONG))
