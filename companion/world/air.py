"""Gusts on top of the mean wind: Dryden turbulence (MIL-F-8785C), frozen in the air and flown through.

Along the mean wind, across it and vertically; how quickly a gust passes is its length over the airspeed.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.frames import Vec3

FOOT = 0.3048
"""m: MIL-F-8785C is written in feet."""
LOWEST_FT, HIGHEST_FT = 10.0, 1000.0
"""The heights between which MIL-F-8785C states its low-altitude model, ft."""


@dataclass(frozen=True, slots=True)
class Gusts:
    """Gusts of a given strength and size. ``sigma``: standard deviation, m/s; ``length``: m (along, across, down)."""

    sigma: Vec3
    length: Vec3

    def at(self, height: float) -> Gusts:
        """The gusts at a height over the ground: everywhere the same."""
        return self


@dataclass(frozen=True, slots=True)
class DrydenGusts:
    """The low-altitude model of MIL-F-8785C: it knows the wind at 6 m (20 ft), m/s, and the height. 7.7 is light
    turbulence, 15 moderate, 23 severe."""

    wind_at_6m: float

    def at(self, height: float) -> Gusts:
        """The gusts at a height over the ground, m."""
        feet = max(LOWEST_FT, min(HIGHEST_FT, height / FOOT))
        shape = 0.177 + 0.000823 * feet
        down = 0.1 * self.wind_at_6m
        level = down / shape**0.4
        length = feet / shape**1.2 * FOOT
        return Gusts((level, level, down), (length, length, feet * FOOT))
