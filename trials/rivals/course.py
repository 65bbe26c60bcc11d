"""What is flown: a mission, and the same path as a function of time for those who track one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from companion.config.mission.mission import mission_from
from companion.config.syntax.document import parse
from companion.frames import Vec3
from companion.law.gains import Level
from companion.mission import Mission
from companion.paths.curve import Curve
from companion.pilot.targets import smooth_start
from companion.profiles.ends import start_time

SAMPLES = 2000


class Moment(NamedTuple):
    """A timetable at one time: position m, velocity, acceleration, jerk, in the local frame."""

    p_n: Vec3
    v_n: Vec3
    a_n: Vec3
    j_n: Vec3


@dataclass(frozen=True)
class Course:
    """A closed curve at a constant speed (m/s), the nose north."""

    name: str
    path: str
    speed: float

    def mission(self, level: Level = Level.RATES) -> Mission:
        """What the law is given."""
        text = f"mission: {self.name}\nframe: ned\npath: {self.path}\nspeed: {self.speed}\nyaw: 0.0\n"
        return mission_from(parse(text, f"{self.name}.yaml"), level)

    @cached_property
    def curve(self) -> Curve:
        """Where."""
        path = self.mission().path
        assert isinstance(path, Curve)
        return path

    @cached_property
    def _over_arc(self) -> CubicSpline:
        """gamma and its first three derivatives over arc length, finely."""
        length = self.curve.table.length
        s = np.linspace(0.0, length, SAMPLES + 1)
        values = self.curve.over_arc(s)[:4].reshape(12, -1)
        values[:, -1] = values[:, 0]
        return CubicSpline(s, values, axis=1, bc_type="periodic")

    def at(self, t: float) -> Moment:
        """The timetable at time ``t`` (s): from rest at s = 0 up to the speed, then at the speed."""
        v = self.speed
        rise = start_time(v)
        x = min(max(t / rise, 0.0), 1.0)
        moved = v * (rise * (2.5 * x**4 - 3.0 * x**5 + x**6) + max(t - rise, 0.0))
        s1, s2, s3 = (v * part for part in smooth_start(max(t, 0.0), rise))
        p, g1, g2, g3 = self._over_arc(moved % self.curve.table.length).reshape(4, 3)
        return Moment(
            _vec(p), _vec(g1 * s1), _vec(g2 * s1**2 + g1 * s2), _vec(g3 * s1**3 + 3.0 * g2 * s1 * s2 + g1 * s3)
        )


def _vec(x: NDArray[np.float64]) -> Vec3:
    return (float(x[0]), float(x[1]), float(x[2]))


def circle(speed: float, radius: float = 5.0, height: float = 10.0) -> Course:
    """A level circle."""
    return Course(
        f"circle r{radius:g} at {speed:g}", f"{{kind: circle, center: [0, 0, {-height}], radius: {radius}}}", speed
    )


def figure_eight(speed: float, height: float = 12.0) -> Course:
    """x = 6 cos u, y = 3 sin 2u, z = 1.5 sin u about a height."""
    path = (
        f"{{kind: lissajous, center: [0, 0, {-height}], amplitude: [6, 3, 1.5], frequency: [1, 2, 1], "
        "phase_deg: [90, 0, 0]}"
    )
    return Course(f"figure-eight at {speed:g}", path, speed)


def tilt_of(moment: Moment, gravity: float) -> float:
    """rad, the tilt the timetable asks for in still air."""
    ax, ay, az = moment.a_n
    return math.atan2(math.hypot(ax, ay), gravity - az)
