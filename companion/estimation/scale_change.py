"""A change of the thrust scale all at once: a payload that falls off, a battery or motors that give less from now on.

The filter's thrust scale k hardly moves in a second. What does not fit it is taken for the errors of the vehicle's
estimate and for gusts, and stays there for as long as these last. So it is tested for a change: the score of k, which
is what the measurements of the last MEMORY pull at it, against its deviation,

    z = y / sqrt(V)       y: sum of slope times residual over variance, fading;  V: its variance

the slope by which an innovation goes with k being the filter's own. Both follow from what a step did to k, c and their
covariance T: the information it brought is T'^-1 - T^-1, the score T'^-1 (q' - q). Once |z| is above SIGMAS the filter
goes through the measurements of the last MEMORY again, with k (and the drag over mass with it) loose in them. Loose
from then on only it would be too late: what the others took by then, they keep for as long as they last.
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
LOOSE_Q = 0.1
"""1/s, process noise of the thrust scale in the measurements that are gone through again: 30 % in a second. The same
sweep: off by 4.4 % at most after 1 s, 3.5 % after 5 s; with 0.3 by 4.8 and 3.7 %."""


class ScaleChange(NamedTuple):
    """``score``: y; ``information``: what it goes by a change of k with; ``variance``: V."""

    score: float = 0.0
    information: float = 0.0
    variance: float = 0.0

    @property
    def found(self) -> bool:
        """Whether the scale has changed."""
        return self.score * self.score > SIGMAS * SIGMAS * self.variance


STEADY = ScaleChange()
"""No change that is known of."""


def loose_process_noise(drag: float) -> tuple[float, float]:
    """1/s, 1/s^3: of thrust scale and drag (1/s) where the scale may have changed. Where the mass does, the drag over
    mass changes in the same ratio."""
    return THRUST_SCALE_Q + LOOSE_Q, DRAG_Q + LOOSE_Q * drag * drag


def fade_scale_change(change: ScaleChange, dt: float) -> ScaleChange:
    """``change`` after a step of ``dt`` s that taught nothing. It is not begun anew: the score of the first few
    measurements, which are alike, is soon beyond SIGMAS."""
    keep = max(0.0, 1.0 - dt / MEMORY)
    return ScaleChange(keep * change.score, keep * change.information, keep * keep * change.variance)


def update_scale_change(
    change: ScaleChange, before: Belief, after: Belief, noise: tuple[float, float], dt: float
) -> ScaleChange:
    """``change`` after a step of ``dt`` s that learned. ``noise``: process noise of thrust scale and drag in it."""
    (score, information, variance), x, later = change, before.x, after.x
    (kk, kc, cc), (later_kk, later_kc, later_cc) = before.T, after.T
    kk, cc = kk + noise[0] * dt, cc + noise[1] * dt
    determinant = 1.0 / (later_kk * later_cc - later_kc * later_kc)
    gained = max(0.0, later_cc * determinant - cc / (kk * cc - kc * kc))
    moved, moved_drag = later[THRUST_SCALE] - x[THRUST_SCALE], later[DRAG] - x[DRAG]
    most = STEP_SIGMAS * math.sqrt(gained)
    pull = clamped((later_cc * moved - later_kc * moved_drag) * determinant, -most, most)
    keep = max(0.0, 1.0 - dt / MEMORY)
    information = keep * information + gained
    # what k has moved by, the measurements before no longer ask for
    score = keep * score + pull - information * moved
    variance = keep * keep * variance + gained
    return ScaleChange(score, information, variance)
