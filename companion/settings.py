"""Gains and limits that a ground station may set between flights on the path (PF_*), bounded; and a plan with them."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

from companion.law.gains import Gains, from_poles
from companion.plan import Plan, gains_of, prepared

POLE_RANGES = {"path": (2.0, 8.0), "speed": (1.0, 5.0), "yaw": (1.0, 2.8)}
"""1/s. Path and speed: flown on PX4's simulated quadrotor at 3 to 10 and 1.5 to 4 (law/gains.py), with room below; yaw:
slower than PX4's own loop, MC_YAW_P 2.8."""
TUBE_RANGE = (0.5, 50.0)
"""m; below, the noise of a GPS hands the vehicle back (engineering choice)."""
NO_CEILING = 1000.0
"""m: as good as none."""
OVER_THE_PATH = 0.5
"""m that floor and ceiling keep from the path at least, so that it can be flown."""
SAMPLES = 200
"""points of the path among which the lowest and the highest are looked for."""
DIGITS = 6
"""Significant digits of a value: what a 32 bit float of MAVLink holds."""


class Setting(NamedTuple):
    """``value`` and the range it may be set to."""

    value: float
    low: float
    high: float


def settings_of(plan: Plan) -> dict[str, Setting]:
    """Name -> setting, as the plan has them. ``PF_POLE_..``: 1/s, how fast an error goes away (several poles: their
    geometric mean); ``PF_TUBE``: m; ``PF_FLOOR`` (0: none) and ``PF_CEILING``: m above the ground."""
    gains, limits = gains_of(plan.mission, plan.vehicle, plan.level, plan.tuning, plan.learned), plan.conduct.limits
    groups = {"path": gains.h1, "speed": gains.h3, "yaw": gains.h4}
    found: dict[str, Setting] = {}
    for name, k in groups.items():
        pole = abs(k[0]) ** (1.0 / len(k))
        found[f"PF_POLE_{name.upper()}"] = Setting(pole, *_around(POLE_RANGES[name], pole))
    if limits.tube is not None:
        found["PF_TUBE"] = Setting(limits.tube, *_around(TUBE_RANGE, limits.tube))
    if limits.ground is not None:
        heights = [limits.ground - float(point[2]) for point in plan.table.samples(SAMPLES)[1]]
        lowest, highest = max(0.0, min(heights) - OVER_THE_PATH), max(heights) + OVER_THE_PATH
        found["PF_FLOOR"] = Setting(limits.floor or 0.0, *_around((0.0, lowest), limits.floor or 0.0))
        ceiling = NO_CEILING if limits.ceiling is None else limits.ceiling
        found["PF_CEILING"] = Setting(ceiling, *_around((min(highest, NO_CEILING), NO_CEILING), ceiling))
    return {name: Setting(*(float(f"{value:.{DIGITS}g}") for value in each)) for name, each in found.items()}


def with_settings(plan: Plan, changed: dict[str, float]) -> Plan:
    """The plan with some settings at other values, within their ranges. Takes as long as ``prepared``."""
    gains, limits = gains_of(plan.mission, plan.vehicle, plan.level, plan.tuning, plan.learned), plan.conduct.limits
    path, speed, yaw = (changed.get(f"PF_POLE_{name}") for name in ("PATH", "SPEED", "YAW"))
    floor, ceiling = changed.get("PF_FLOOR"), changed.get("PF_CEILING")
    limits = limits._replace(
        tube=changed.get("PF_TUBE", limits.tube),
        floor=limits.floor if floor is None else floor or None,
        ceiling=limits.ceiling if ceiling is None else ceiling if ceiling < NO_CEILING else None,
    )
    mission = plan.mission
    if path or speed or yaw:
        tuned = Gains(_poles(path, gains.h1), _poles(path, gains.h2), _poles(speed, gains.h3), _poles(yaw, gains.h4))
        mission = dataclasses.replace(mission, gains=tuned)
    return prepared(
        mission, plan.vehicle, plan.level, mission.placement.origin_n, plan.duration, plan.tuning,
        plan.conduct._replace(limits=limits), plan.learned,
    )  # fmt: skip


def _poles(wanted: float | None, gains: tuple[float, ...]) -> tuple[float, ...]:
    return gains if wanted is None else from_poles((-wanted,) * len(gains))


def _around(bounds: tuple[float, float], value: float) -> tuple[float, float]:
    """What a file says is within the range, whatever the range is."""
    return min(bounds[0], value), max(bounds[1], value)
