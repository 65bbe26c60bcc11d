"""What one flight leaves for the next: the vehicle's figures, and how far they are to be believed after a while."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.observer import DRAG_DOUBT, KAPPA_DOUBT, Prior

HOVER_RANGE, DRAG_RANGE, LAG_RANGE = (0.1, 0.9), (0.0, 2.5), (0.01, 0.3)
FRESH_KAPPA, FRESH_DRAG = 0.05, 0.15
"""Doubt about the thrust scale and the drag (1/s) just after a flight: another battery, load or propeller."""
AGEING = 30.0
"""days after which the doubt is that of a vehicle never flown."""
FLOWN_MIN = 15.0
"""s of flight that are worth remembering."""


class Learned(NamedTuple):
    """``hover_thrust``: normalised, as it truly was. ``drag`` 1/s. ``rate_lag`` s. ``age_days``: since that flight."""

    hover_thrust: float
    drag: float
    rate_lag: float
    age_days: float = 0.0


def sane(learned: Learned) -> bool:
    """Whether these can be a vehicle's figures at all."""
    hover, drag, lag, age = learned
    return (
        all(map(math.isfinite, learned))
        and HOVER_RANGE[0] <= hover <= HOVER_RANGE[1]
        and DRAG_RANGE[0] <= drag <= DRAG_RANGE[1]
        and LAG_RANGE[0] <= lag <= LAG_RANGE[1]
        and age >= 0.0
    )


def prior_of(learned: Learned | None, hover_thrust: float, drag: float) -> Prior:
    """What is believed before a flight. ``hover_thrust``, ``drag``: as told by the vehicle and its file; what was
    learned replaces them as far as it is fresh."""
    if learned is None or not sane(learned):
        return Prior(drag=(drag, DRAG_DOUBT))
    old = min(1.0, learned.age_days / AGEING)
    kappa = hover_thrust / learned.hover_thrust
    return Prior(
        kappa=(kappa, FRESH_KAPPA + (KAPPA_DOUBT - FRESH_KAPPA) * old),
        drag=(learned.drag + (drag - learned.drag) * old, FRESH_DRAG + (DRAG_DOUBT - FRESH_DRAG) * old),
    )
