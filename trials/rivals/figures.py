"""From a flown track to the numbers of a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from companion.frames import Vec3, wrap
from trials.rivals.course import Course


class Sample(NamedTuple):
    """The true state at one time: s, m, m/s, rad of heading and of tilt."""

    t: float
    p_n: Vec3
    v_n: Vec3
    heading: float
    tilt: float


class Figures(NamedTuple):
    """Of a flight from some time on. Distances m, speeds m/s, angles deg. ``lost``: it left the path for good."""

    path_rms: float
    path_max: float
    speed_rms: float
    speed_max: float
    yaw_rms: float
    tilt_max: float
    lost: bool

    @property
    def cell(self) -> str:
        """Path RMS in cm, as a table shows it."""
        return "lost" if self.lost else f"{100.0 * self.path_rms:.1f}"


LOST = 3.0
"""m off the path at the end of a flight that is called lost."""


def figures(course: Course, track: Sequence[Sample], settle: float) -> Figures:
    """Of ``track`` from ``settle`` s after its beginning."""
    table = course.curve.table
    begin = track[0].t + settle
    s = table.locate(track[0].p_n)[0]
    errors, speed_errors, speeds, yaws, tilts = [], [], [], [], []
    for sample in track:
        reach = 1.0 + 0.2 * math.hypot(*sample.v_n)
        s, distance = table.nearest(sample.p_n, s, reach)
        if sample.t < begin:
            continue
        tangent = table.at(s)[1]
        along = sum(a * b for a, b in zip(tangent, sample.v_n, strict=True))
        errors.append(distance)
        speed_errors.append(along - course.speed)
        speeds.append(math.hypot(*sample.v_n))
        yaws.append(math.degrees(wrap(sample.heading)))
        tilts.append(math.degrees(sample.tilt))
    last = track[-1].p_n
    lost = not math.isfinite(sum(last)) or table.locate(last)[1] > LOST or max(errors) > 5.0 * LOST
    return Figures(_rms(errors), max(errors), _rms(speed_errors), max(speeds), _rms(yaws), max(tilts), lost)


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
