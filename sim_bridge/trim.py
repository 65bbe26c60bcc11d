"""The start of a flight in the air: what holds a vehicle against a steady wind."""

from __future__ import annotations

import math

from companion.frames import Vec3


def steady_disturbance(wind_n: Vec3, drag: float, gravity: float) -> Vec3:
    """The acceleration the position loop must add to hold against the wind's drag (m/s^2, NED).

    The loop turns it into a thrust whose level part grows with its vertical part; that is taken out here.
    """
    north, east, down = (-drag * wind for wind in wind_n)
    lift = 1.0 - down / gravity
    return (north / lift, east / lift, down) if math.isfinite(lift) and lift > 0.1 else (north, east, 0.0)
