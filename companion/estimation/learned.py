"""What one flight leaves for the next: the vehicle's figures, and how far they are to be believed after a while."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.clamps import DRAG_RANGE
from companion.estimation.estimator import DRAG_STD, THRUST_SCALE_STD, Prior

HOVER_RANGE = (0.1, 0.9)
"""Normalised hover thrusts that a vehicle can have. PX4 takes MPC_THR_HOVER from 0.1 to 0.8."""
LAG_RANGE = (0.01, 0.3)
"""s, of a rate loop that flies. Engineering choice."""
YAW_LAG_RANGE = (0.05, 1.5)
"""s, of a yaw rate loop. Engineering choice."""
FRESH_THRUST_SCALE_STD = 0.05
"""Ratio: standard deviation of the thrust scale just after a flight: another battery, load or propeller. Engineering
choice."""
FRESH_DRAG_STD = 0.15
"""1/s, the same of the drag. Engineering choice."""
AGEING = 30.0
"""days after which the standard deviation is that of a vehicle never flown. Engineering choice."""
FLIGHT_TIME_MIN = 15.0
"""s of flight that are worth remembering. Engineering choice."""


class Learned(NamedTuple):
    """What a flight found out, and how well it knew.

    ``hover_thrust``: normalised, as it truly was. ``drag``: 1/s. ``rate_lag``: s. ``age_days``: since that flight.
    ``hover_thrust_std``, ``drag_std``: standard deviations at its end, by the filter, and ``yaw_lag``: s; 0 where they
    were not kept.
    """

    hover_thrust: float
    drag: float
    rate_lag: float
    age_days: float = 0.0
    hover_thrust_std: float = 0.0
    drag_std: float = 0.0
    yaw_lag: float = 0.0


def sane(learned: Learned) -> bool:
    """Whether these can be a vehicle's figures at all."""
    hover, drag, lag, age, hover_std, drag_std, yaw_lag = learned
    return (
        all(map(math.isfinite, learned))
        and HOVER_RANGE[0] <= hover <= HOVER_RANGE[1]
        and DRAG_RANGE[0] <= drag <= DRAG_RANGE[1]
        and LAG_RANGE[0] <= lag <= LAG_RANGE[1]
        and age >= 0.0
        and (yaw_lag == 0.0 or YAW_LAG_RANGE[0] <= yaw_lag <= YAW_LAG_RANGE[1])
        and 0.0 <= hover_std <= hover
        and 0.0 <= drag_std <= DRAG_RANGE[1]
    )


def prior_of(learned: Learned | None, hover_thrust: float, drag: float) -> Prior:
    """What is believed before a flight. ``hover_thrust``, ``drag``: as told by the vehicle and its file; what was
    learned replaces them as far as it is fresh and was known.

    Just after a flight the deviation is the filter's own and FRESH_*_STD (another battery, load or propeller) in
    quadrature. No further from the file than the evidence says: with less of it than the file has (a deviation as
    large as that of a vehicle never flown) the value is half way, with none it is the file's.
    """
    if learned is None or not sane(learned):
        return Prior(drag=(drag, DRAG_STD))
    old = min(1.0, learned.age_days / AGEING)
    relative = learned.hover_thrust_std / learned.hover_thrust
    scale = _towards(1.0, hover_thrust / learned.hover_thrust, relative, THRUST_SCALE_STD)
    found = _towards(drag, learned.drag, learned.drag_std, DRAG_STD)
    scale_std = min(math.hypot(FRESH_THRUST_SCALE_STD, relative), THRUST_SCALE_STD)
    drag_std = min(math.hypot(FRESH_DRAG_STD, learned.drag_std), DRAG_STD)
    return Prior(
        thrust_scale=(scale, scale_std + (THRUST_SCALE_STD - scale_std) * old),
        drag=(found + (drag - found) * old, drag_std + (DRAG_STD - drag_std) * old),
    )


def _towards(stated: float, found: float, deviation: float, stated_deviation: float) -> float:
    """``found`` weighed against what is ``stated``, by their variances."""
    return stated + (found - stated) * stated_deviation**2 / (stated_deviation**2 + deviation**2)
