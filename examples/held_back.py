"""Held for three seconds and let go, beside a controller that follows a timetable with the same estimator and limits.

The path follower goes on from the near point of the path; the tracker chases a point that ran away. The tracker is the
one of docs/rivals.md (trials/rivals), so this example is run in a checkout of the project.
"""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import companion
from trials.rivals.course import circle
from trials.rivals.figures import Sample
from trials.rivals.plant_place import fly
from trials.rivals.tracker import tracking

HELD_FOR = 3.0
"""s"""


def main(folder: Path = Path("."), seconds: float = 22.0, held_at: float = 10.0) -> dict[str, list[Sample]]:
    """Fly both for ``seconds``, held at ``held_at``; the tracks by who flew."""
    hold = {"kind": "hold", "from_s": held_at, "to_s": held_at + HELD_FOR, "after": "offboard"}
    world = companion.new_world("held", events=[hold])
    vehicle, course = companion.load_vehicle("x500"), circle(3.0)
    fly_circle = partial(fly, course, vehicle.value, world.value, seconds)
    tracks = {"path following": fly_circle(), "time tracking": fly_circle(steering=partial(tracking, course=course))}
    figure, (error, speed) = plt.subplots(2, 1, sharex=True, layout="constrained")
    for who, track in tracks.items():
        t = np.array([sample.t for sample in track]) - track[0].t
        off = [100.0 * abs(math.hypot(sample.p_n[0], sample.p_n[1]) - 5.0) for sample in track]
        print(f"{who}: at most {max(off):.0f} cm off the circle, {max(map(speed_of, track)):.1f} m/s")
        error.plot(t, off, label=who)
        speed.plot(t, list(map(speed_of, track)), label=who)
    error.set(ylabel="off the circle, cm")
    speed.set(xlabel="t, s", ylabel="speed, m/s")
    error.legend()
    figure.savefig(folder / "held_back.svg")
    plt.close(figure)
    return tracks


def speed_of(sample: Sample) -> float:
    """m/s"""
    return math.hypot(*sample.v_n)


if __name__ == "__main__":
    main()
