"""The report as the JSON document ``companion.check/1``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from companion.feasibility.limits import Limit
from companion.feasibility.report import REPORTED_ONLY, Report

SCHEMA = "companion.check/1"
PROFILE_SAMPLES = 200
"""rows of the speed profile in the JSON document."""
HUGE = 1e9
"""What stands for values without end, which JSON does not know."""


def as_document(report: Report, places: Sequence[str] = (), warnings: Sequence[str] = ()) -> dict[str, Any]:
    """``places``: where the path runs, ``warnings``: what is likely not meant there; sentences.

    ``limits`` holds those of the schema, and beside them any other that is broken, so that it always explains
    ``feasible``; ``further`` holds all others. ``fastest`` is the limit met at ``speed_scale_max``."""
    broken = [limit for limit in report.others if not limit.ok]
    speed = np.abs(report.at.alpha[0])
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "mission": report.mission.name,
        "vehicle": report.vehicle.name,
        "feasible": report.feasible,
        "limits": [_limit(limit) for limit in (*report.limits, *broken)],
        "length_m": report.length,
        "duration_s": _finite(report.duration),
        "speed_scale_max": report.speed_scale_max,
        "paper": {
            "max_vdot": _finite(report.max_vdot),
            "g": report.vehicle.gravity,
            "proposition_4_2": report.proposition_4_2,
        },
        "tightest": _limit(report.tightest),
        "fastest": _limit(report.at_most),
        "further": [_limit(limit) for limit in report.others],
        "closed": report.mission.closed,
        "height_m": {
            "min": report.ground - float(report.at.path[0, 2].max()),
            "max": report.ground - float(report.at.path[0, 2].min()),
        },
        "speed_mps": {"min": float(speed.min()), "max": float(speed.max())},
        "places": list(places),
        "warnings": list(warnings),
        "auto": None,
    }
    if report.auto:
        s = np.linspace(0.0, report.length, PROFILE_SAMPLES + 1).tolist()
        document["auto"] = {"table": [[x, report.mission.alpha(x)] for x in s]}
    return document


def _limit(limit: Limit) -> dict[str, Any]:
    return {
        "name": limit.name,
        "worst": _finite(limit.worst),
        "limit": limit.limit,
        "at_s": limit.at_s,
        "ok": limit.ok,
        "used": _finite(limit.used),
        "part": limit.part or None,
        "decides": limit.name not in REPORTED_ONLY,
    }


def _finite(value: float) -> float:
    return value if math.isfinite(value) else math.copysign(HUGE, value) if not math.isnan(value) else HUGE
