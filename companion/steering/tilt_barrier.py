"""Tilt barrier: no body rate is commanded that leans the vehicle into its failure detector.

A path is flown no steeper, on average, than STEADY_UNDER_DETECTOR under the failure detector. What noise and gusts ask
for on top of that is stopped short of it, by a control barrier function (Ames et al. 2019, "Control barrier functions:
theory and applications"):

    theta' <= k (theta_most - theta),    theta_most = detector - BARRIER_UNDER_DETECTOR

theta is the tilt at the horizon, where the rates are the commanded ones. What leans it further is taken out of them,
and nothing else: turns across the lean and about the thrust axis stay. The path is missed by a little more for as long.
"""

from __future__ import annotations

import math

from companion.frames import Matrix3
from companion.vehicle import Limits

STEADY_UNDER_DETECTOR = math.radians(8.0)
"""rad that the steady tilt of a path stays under the vehicle's failure detector: 4 to the barrier, 4 for errors, noise
and gusts. Flown in sih_noisy, circle r5 at 7 m/s: with 7.2 the path is worse by a tenth, with 8.8 the speed by a
quarter."""
STEADY_AT_MOTORS = math.radians(10.0)
"""rad, the same at motors and torques, where yaw is what a motor at its limit takes. Flown in sih_noisy, circle r5 at
7 m/s: with 8 half of the commands meet a limit, on PX4 57 %, and the heading is off by 8 to 10 deg instead of 6."""
BARRIER_UNDER_DETECTOR = math.radians(4.0)
"""rad under the failure detector at which the barrier stands, 2 under our own guard. Engineering choice."""
BARRIER_RATE = 8.0
"""1/s, k. Engineering choice: half of the rate of PX4's rate loops (1/60 ms), of which more would be beyond a model of
the horizon. Flown in sih_noisy, circle r5 at 7 m/s in 3 m/s of wind: 56.0 deg at most; the path is off by 8 cm at
most in four minutes, with 5 1/s by 10, without the barrier by 5, until the vehicle is handed back."""
LEVEL_MAX = 0.02
"""Number, the sine of the tilt under which a lean has no direction. Engineering choice."""


def within_barrier(p: float, q: float, r_nb: Matrix3, limits: Limits | None) -> tuple[float, float]:
    """rad/s, roll and pitch rate without what leans the vehicle beyond the barrier. ``r_nb``: the attitude in which
    they act."""
    leaning = math.hypot(r_nb[6], r_nb[7])
    if limits is None or leaning < LEVEL_MAX:
        return p, q
    steepest = limits.failure_detector - BARRIER_UNDER_DETECTOR
    # cos theta is r_nb[8], whose derivative is r_nb[6] q - r_nb[7] p
    x, y = r_nb[7] / leaning, -r_nb[6] / leaning
    excess = x * p + y * q - BARRIER_RATE * (steepest - math.atan2(leaning, r_nb[8]))
    return (p, q) if excess <= 0.0 else (p - excess * x, q - excess * y)
