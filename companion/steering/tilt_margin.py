"""How much steeper than it leans on average a vehicle has been; the speed governor leaves as much.

A path is flown no steeper, on average, than STEADY_UNDER_DETECTOR under the failure detector. Noise and
gusts tilt the vehicle further, and how far is not known before the flight: what comes near the detector's tilt widens
the margin, which narrows again.

    margin' = 2 excess / 1 s - margin / 20 s,    excess = max(0, tilt - (detector - 5 deg))

The second term only while the vehicle leans.
"""

from __future__ import annotations

import math

from companion.vehicle import Limits

STEADY_UNDER_DETECTOR = math.radians(8.0)
"""rad that the steady tilt of a path stays under the vehicle's failure detector: 2 to our own guard, 6 for errors,
noise and gusts. Flown in sih_noisy with 3 m/s of wind: to 3 deg over it; with 2 in all, 7 m/s was handed back."""
NEAR_DETECTOR = math.radians(5.0)
"""rad under the failure detector from which on a tilt is too near: 3 under our own guard. Engineering choice."""
GROWTH = 2.0
"""1/s, of the margin by what is too near. Simulated on sih_noisy in 3 m/s of wind, circle r5 at 7 m/s: without a margin
a flight in two was handed back within ten minutes."""
NARROWING_TIME = 20.0
"""s in which the margin narrows. Engineering choice: a few laps."""
LEANING = 0.5
"""Share of the failure detector's tilt from which on it narrows: a take-off tells nothing of how a vehicle leans.
Engineering choice."""
MARGIN_FIRST = math.radians(3.4)
"""rad, before it has leaned: the attitude that is told is worse after a take-off. Simulated on sih_noisy, circle r5 at
7 m/s: without it one flight of three was handed back where it had come to its speed, 57 deg told as 61."""
MARGIN_MAX = math.radians(6.0)
"""rad. Engineering choice: beyond it, it is not noise."""


def update_tilt_margin(margin: float, tilt: float, limits: Limits | None, dt: float) -> float:
    """The margin (rad) ``dt`` s later, after a ``tilt`` (rad)."""
    if limits is None:
        return 0.0
    excess = max(0.0, tilt - (limits.failure_detector - NEAR_DETECTOR))
    narrowing = margin / NARROWING_TIME if tilt > LEANING * limits.failure_detector else 0.0
    return min(margin + dt * (GROWTH * excess - narrowing), MARGIN_MAX)
