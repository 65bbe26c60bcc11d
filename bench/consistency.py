"""How right the estimator is under real noise: ``python -m bench.consistency [SEEDS]``.

Circles and figure-eights at 3, 5 and 7 m/s in sih_noisy with a steady wind of 3 m/s, the vehicle file wrong by +-15 %
in hover thrust and +-50 % in drag: thrust scale, drag and disturbance as means over 5 s, and the share of the time in
which NEES lies inside its 95 % bounds.
"""

from __future__ import annotations

import dataclasses
import math
import sys

import numpy as np

from trials.consistency import trial
from trials.measured import world
from trials.prediction import nis_line, share_inside

COURSES = (("circle_r5", 3.0), ("circle_r5", 5.0), ("figure8", 3.0))
"""m/s. 7 m/s on the circle needs a tilt of 60 deg in the vehicle file."""
DURATION = 60.0
"""s of following."""


def main(seeds: int) -> None:
    """Print a line a flight, and the whole."""
    inside: list[float] = []
    nis: list[float] = []
    nis_second: list[float] = []
    for seed in range(seeds):
        mission, speed = COURSES[seed % len(COURSES)]
        hover, drag = (1.15, 0.85)[seed % 2], (0.5, 1.5)[seed // 2 % 2]
        wind = tuple(3.0 * f(2.4 * seed) for f in (math.cos, math.sin))
        where = dataclasses.replace(world("sih_noisy"), wind_n=(wind[0], wind[1], 0.0))
        done = trial(mission, speed, where, hover=hover, drag=drag, seed=seed, duration=DURATION)
        if not done.windows:
            print(f"seed {seed:2d} {mission} {speed:g} m/s: LOST, {done.flight.reason}", flush=True)
            inside.append(0.0)
            continue
        late = [window for window in done.windows if window.begin >= 20.0]
        believed = done.flight.believed
        inside += [window.inside for window in done.windows]
        nis += done.nis
        nis_second += done.nis_second
        path = math.nan if believed is None else 100.0 * believed.path
        print(
            f"seed {seed:2d} {mission} {speed:g} m/s, hover {hover:g}, drag {drag:g}: path {path:.1f} cm;"
            f" from 20 s: scale {100.0 * max(abs(w.scale) for w in late):.1f} %,"
            f" drag {100.0 * max(abs(w.drag) for w in late):.1f} % (end {100.0 * abs(late[-1].drag):.1f}),"
            f" disturbance {max(w.disturbance for w in late):.2f} m/s^2;"
            f" NEES inside {100.0 * np.mean([w.inside for w in done.windows]):.0f} %"
            f" (first 20 s {100.0 * np.mean([w.inside for w in done.windows if w.begin < 20.0]):.0f} %),"
            f" NIS a second ahead {100.0 * share_inside(done.nis_second):.0f} %",
            flush=True,
        )
    print(f"NEES inside its bounds {100.0 * np.mean(inside):.0f} % of the time")
    print(nis_line("a state", nis))
    print(nis_line("a second", nis_second))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
