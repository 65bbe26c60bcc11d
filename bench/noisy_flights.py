"""Paths under the noise of a real frame, wrong files and wind: ``python -m bench.noisy_flights [FIRST [COUNT]]``.

sih_noisy, a steady wind of 3 m/s, hover thrust told wrong by +-15 % and drag by +-50 %, 40 s of following, believed
figures from 10 s on; from 5 m/s on with a tilt of 60 deg in the vehicle file.
"""

from __future__ import annotations

import dataclasses
import math
import sys

from trials.measured import course, machine, measure_flight, world

CASES = (
    ("circle_r5", 3.0, 1.15, 0.5, 1), ("circle_r5", 3.0, 0.85, 1.5, 8), ("circle_r5", 5.0, 0.85, 1.5, 2),
    ("circle_r5", 5.0, 1.15, 0.5, 6), ("circle_r5", 7.0, 1.15, 1.5, 3), ("circle_r5", 7.0, 0.85, 0.5, 5),
    ("figure8", 3.0, 0.85, 0.5, 4), ("figure8", 3.0, 1.15, 1.5, 7),
)  # fmt: skip
"""Mission, m/s, hover thrust and drag told over the true ones, seed."""
WIND = 3.0
"""m/s."""


def main(first: int, count: int) -> None:
    """Print a line a flight."""
    for mission, speed, hover, drag, seed in CASES[first : first + count]:
        true = machine("sih")
        limits = true.limits
        assert limits is not None
        if speed >= 5.0:
            limits = dataclasses.replace(limits, tilt=math.radians(60.0))
        told = dataclasses.replace(true, drag=true.drag * drag, hover_thrust=0.4905 * hover, limits=limits)
        where = world("sih_noisy", wind_n=(WIND * math.cos(2.4 * seed), WIND * math.sin(2.4 * seed), 0.0))
        where = dataclasses.replace(where, truth=dataclasses.replace(where.truth, drag=true.drag))
        done = measure_flight(course(mission, speed), told, where, seed=seed, duration=40.0)
        head = f"{mission} {speed:g} m/s, hover {hover:g}, drag {drag:g}, seed {seed}"
        if done.reason is not None or done.believed is None:
            print(f"{head}: {done.reason}", flush=True)
            continue
        known = done.believed
        print(
            f"{head}: path {100.0 * known.path:.2f} cm (most {100.0 * known.path_max:.1f}),"
            f" speed {100.0 * known.speed / speed:.1f} %, heading {math.degrees(known.yaw):.1f} deg,"
            f" tilt to {math.degrees(done.tilt_max):.0f} deg",
            flush=True,
        )


if __name__ == "__main__":
    asked = [int(word) for word in sys.argv[1:3]]
    main(asked[0] if asked else 0, asked[1] if len(asked) > 1 else len(CASES))
