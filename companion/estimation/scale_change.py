"""A change of the thrust scale all at once: a payload that falls off, a battery or motors that give less from now on.

The filter's thrust scale k hardly moves in a second. What does not fit it is taken for the errors of the vehicle's
estimate and for gusts, and stays there for as long as these last. So it is tested for a change: the score of k, which
is what the measurements of the last MEMORY pull at it, against its deviation,

    z = y / sqrt(V)       y: sum of slope times residual over variance, fading;  V: its variance

the slope by which an innovation goes with k being the filter's own. Both follow from what a step did to k, c and their
covariance T: the information it brought is T'^-1 - T^-1, the score T'^-1 (q' - q). Once |z| is above SIGMAS, k (and
the drag over mass with it) is loose for LOOSE_TIME, in which the other states give back what they took.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.kalman import Belief
from companion.estimation.kalman_step import DRAG, DRAG_Q, THRUST_SCALE, THRUST_SCALE_Q
from companion.frames import clamped

MEMORY = 1.0
"""s, time constant of the score. Sweep over recorded flights in sih_noisy: in steps of the scale by +25 and -20 % it
comes to 5 to 9 deviations with 0.8 to 1.2 s, without one to 3 (once 4). With 0.2 s to 4.6 to 9, and to 4.5 (once
5.9)."""
SIGMAS = 4.5
"""Number of standard deviations of the score from which on the scale has changed. The same sweep; on real PX4 (twelve
flights) it comes to 2.5 to 3.6 without a change, once to 4.1."""
STEP_SIGMAS = 3.0
"""Number of standard deviations that one step counts for at most: a glitch is no change. Engineering choice."""
LOOSE_TIME = 4.0
"""s for which the scale is loose: about VELOCITY_ERROR_TIME, the longest that what was taken for something else stays
there. The same sweep: 2 s leave 5.6 % after 5 s, 4 s 3.3 %."""
LOOSE_Q = 0.05
"""1/s, process noise of the thrust scale at the beginning of that time: 22 % in a second; it goes down with the square
of what is left. The same sweep: the deviation at its end, not the way there, is what is left after 5 s."""


class ScaleChange(NamedTuple):
    """``score``: y; ``information``: what it goes by a change of k with; ``variance``: V. ``loose``: s for which the
    scale is loose still."""

    score: float = 0.0
    information: float = 0.0
    variance: float = 0.0
    loose: float = 0.0


STEADY = ScaleChange()
"""No change that is known of."""


def process_noise(change: ScaleChange, drag: float) -> tuple[float, float]:
    """1/s, 1/s^3: of thrust scale and drag (1/s). Where the mass changes, the drag over mass does in the same ratio."""
    if change.loose == 0.0:
        return THRUST_SCALE_Q, DRAG_Q
    left = change.loose / LOOSE_TIME
    q = LOOSE_Q * left * left
    return THRUST_SCALE_Q + q, DRAG_Q + q * drag * drag


def fade_scale_change(change: ScaleChange, dt: float) -> ScaleChange:
    """``change`` after a step of ``dt`` s that taught nothing. It is not begun anew: the score of the first few
    measurements, which are alike, is soon beyond SIGMAS."""
    if change.loose > 0.0:
        return ScaleChange(loose=max(0.0, change.loose - dt))
    keep = max(0.0, 1.0 - dt / MEMORY)
    return ScaleChange(keep * change.score, keep * change.information, keep * keep * change.variance)


def update_scale_change(
    change: ScaleChange, before: Belief, after: Belief, noise: tuple[float, float], dt: float
) -> ScaleChange:
    """``change`` after a step of ``dt`` s that learned. ``noise``: process noise of thrust scale and drag in it."""
    if change.loose > 0.0:
        return ScaleChange(loose=max(0.0, change.loose - dt))
    (kk, kc, cc), (later_kk, later_kc, later_cc) = before.T, after.T
    kk, cc = kk + noise[0] * dt, cc + noise[1] * dt
    determinant = 1.0 / (later_kk * later_cc - later_kc * later_kc)
    gained = max(0.0, later_cc * determinant - cc / (kk * cc - kc * kc))
    moved, moved_drag = after.x[THRUST_SCALE] - before.x[THRUST_SCALE], after.x[DRAG] - before.x[DRAG]
    most = STEP_SIGMAS * math.sqrt(gained)
    pull = clamped((later_cc * moved - later_kc * moved_drag) * determinant, -most, most)
    keep = max(0.0, 1.0 - dt / MEMORY)
    information = keep * change.information + gained
    # what k has moved by, the measurements before no longer ask for
    score = keep * change.score + pull - information * moved
    variance = keep * keep * change.variance + gained
    changed = score * score > SIGMAS * SIGMAS * variance
    return ScaleChange(score, information, variance, LOOSE_TIME if changed else 0.0)
