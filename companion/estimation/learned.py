"""What one flight leaves for the next: the vehicle's figures, and how far they are to be believed after a while."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.estimator import DRAG_STD, THRUST_SCALE_STD, Prior

HOVER_RANGE = (0.1, 0.9)
"""Normalised hover thrusts that a vehicle can have. PX4 takes MPC_THR_HOVER from 0.1 to 0.8."""
DRAG_RANGE = (0.0, 2.5)
"""1/s, as the estimator's."""
LAG_RANGE = (0.01, 0.3)
"""s, of a rate loop that flies. Engineering choice."""
FRESH_THRUST_SCALE_STD = 0.05
"""Standard deviation of the thrust scale just after a flight: another battery, load or propeller."""
FRESH_DRAG_STD = 0.15
"""1/s, the same of the drag."""
AGEING = 30.0
"""days after which the standard deviation is that of a vehicle never flown. Engineering choice."""
FLIGHT_TIME_MIN = 15.0
"""s of flight that are worth remembering. Engineering choice."""


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
        return Prior(drag=(drag, DRAG_STD))
    old = min(1.0, learned.age_days / AGEING)
    thrust_scale = hover_thrust / learned.hover_thrust
    return Prior(
        thrust_scale=(thrust_scale, FRESH_THRUST_SCALE_STD + (THRUST_SCALE_STD - FRESH_THRUST_SCALE_STD) * old),
        drag=(learned.drag + (drag - learned.drag) * old, FRESH_DRAG_STD + (DRAG_STD - FRESH_DRAG_STD) * old),
    )
