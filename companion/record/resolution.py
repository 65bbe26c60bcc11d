"""``resolved.json``: what the files that were flown resolved to, and what a replay begins from."""

from __future__ import annotations

from typing import Any

from companion.flight.conduct import to_dict
from companion.flight.phases import Phase, Request
from companion.mavlink_common import MavResult
from companion.plan import Plan
from companion.record.tick_columns import COLUMNS
from companion.vehicle import Landed, Mode
from companion.version import __version__


def resolution(
    plan: Plan, mission: str, vehicle: str, now: float, epoch: float, simulation: dict[str, Any] | None
) -> dict[str, Any]:
    """Its content. ``mission``, ``vehicle``: the files' names as given;
    ``now``: s, when the pilot began; ``epoch``: s since 1970 when our clock read zero."""
    return {
        "schema": "companion.resolved/1",
        "version": __version__,
        "simulation": simulation,
        "mission": {"name": plan.mission.name, "file": mission},
        "vehicle": {"name": plan.vehicle.name, "file": vehicle},
        "output": plan.level.value,
        "motors": plan.vehicle.motors.value,
        "origin_n": list(plan.mission.placement.origin_n),
        "turn_rad": plan.mission.placement.turn,
        "home_told": list(plan.mission.given_home),
        "duration_s": plan.duration,
        "tuning": plan.tuning._asdict(),
        "conduct": to_dict(plan.conduct),
        "learned": None if plan.learned is None else plan.learned._asdict(),
        "settings": [],
        "begun_at": now,
        "epoch": epoch,
        "path_length_m": plan.table.length,
        "columns": {column.name: column.meaning for column in COLUMNS},
        "legend": {
            "phase": [phase.value for phase in Phase],
            "request": [request.value for request in Request],
            "answer": [reply.words for reply in MavResult],
            "mode": [mode.words for mode in Mode],
            "landed": [landed.name.lower() for landed in Landed],
        },
    }
