"""Gusts: Dryden's turbulence, frozen in the air that the mean wind carries along and the vehicle flies through.

    along the mean wind      H(s) = sigma sqrt(2 T) / (1 + T s)
    across it and down       H(s) = sigma sqrt(T) (1 + sqrt(3) T s) / (1 + T s)^2        T = length / airspeed

for white noise of unit density, MIL-F-8785C. The filters' states have unit variance, so that strength and length may
change while the vehicle climbs.
"""

from __future__ import annotations

import math

from companion.frames import Vec3
from companion.world.air import DrydenGusts, Gusts
from sim_bridge.noise import Draw, FirstOrder, SecondOrder

AIRSPEED_MIN = 0.5
"""m/s. A vehicle that drifts with the air still feels the gusts pass, for they do not last for ever."""
SET_EVERY = 0.02
"""s between two looks at height and airspeed."""
ROOT_3 = math.sqrt(3.0)
"""Of Dryden's transverse spectrum."""
ROOT_HALF = math.sqrt(0.5)
"""Of Dryden's transverse spectrum."""


class GustyAir:
    """The gusts of one flight. ``step`` s; ``wind_n``: the mean wind (m/s), whose direction gives theirs."""

    def __init__(self, gusts: Gusts | DrydenGusts, wind_n: Vec3, step: float, draw: Draw) -> None:
        self._gusts = gusts
        self._step = step
        speed = math.hypot(wind_n[0], wind_n[1])
        self._along = (1.0, 0.0) if speed == 0.0 else (wind_n[0] / speed, wind_n[1] / speed)
        self._every = max(1, round(SET_EVERY / step))
        self._until_set = 0
        self._u = FirstOrder(draw, step, 1.0)
        self._v = SecondOrder(draw, step, 1.0)
        self._w = SecondOrder(draw, step, 1.0)
        self._sigma: Vec3 = (0.0, 0.0, 0.0)

    def update(self, height: float, u_n: Vec3) -> Vec3:
        """What the gusts add to the wind (m/s, NED) a step later, at a height (m) and a velocity in the mean wind
        (m/s, NED)."""
        if self._until_set == 0:
            self._until_set = self._every
            now = self._gusts.at(height)
            self._sigma = now.sigma
            north, east, down = u_n
            passed = self._step * max(AIRSPEED_MIN, math.sqrt(north**2 + east**2 + down**2))
            length, width, depth = now.length
            self._u.set_step(passed / length)
            self._v.set_step(passed / width)
            self._w.set_step(passed / depth)
        self._until_set -= 1
        along, across, down = self._sigma
        self._v.update()
        self._w.update()
        u = along * self._u.update()
        v = across * ROOT_HALF * (ROOT_3 * self._v.x + (1.0 - ROOT_3) * self._v.y)
        w = down * ROOT_HALF * (ROOT_3 * self._w.x + (1.0 - ROOT_3) * self._w.y)
        north, east = self._along
        return (north * u - east * v, east * u + north * v, w)
