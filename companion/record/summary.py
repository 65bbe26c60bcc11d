"""The figures of a flight, from its table and, where it was simulated, from the plant's true state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.plan import HOVER_THRUST, Plan
from companion.record.events import flight_events
from companion.record.final_estimates import curve_sentences, estimate_sentences, final_estimates
from companion.record.series import FOLLOW, PHASES, followed_series, stretches, true_series
from companion.record.table import Table
from companion.vehicle import OutputLevel
from companion.version import __version__

Figures = dict[str, Any]
Array = NDArray[np.float64]
NEAR_GROUND = 0.1
"""m above the origin within which a speed downwards is one of touching the ground (engineering choice)."""


def summary(
    plan: Plan,
    table: Table,
    truth: Table | None,
    settle: float,
    outcome: str,
    reason: str | None,
    record: str | None,
    simulation: Figures | None = None,
) -> Figures:
    """The JSON of contract ``companion.flight/1``. ``simulation``: the world, as resolved.json tells it."""
    estimated = followed_series(table)
    result: Figures = {
        "schema": "companion.flight/1",
        "mission": plan.mission.name,
        "vehicle": plan.vehicle.name,
        "output": plan.level.value,
        "outcome": outcome,
        "reason": reason,
        "phases": _phases(table),
        "follow": _figures(estimated, plan),
        "settled": _settled(estimated, plan, settle),
    }
    if truth is not None:
        true = true_series(plan, estimated, truth)
        result["truth"] = {
            "follow": _figures(true, plan),
            "settled": _settled(true, plan, settle),
            "flight": _whole(truth),
        }
    result["loop"] = _loop(table)
    result["found"] = final_estimates(estimated)
    result["version"] = __version__
    result["simulation"] = simulation
    result["events"] = [each.document for each in flight_events(estimated, table, simulation)]
    hover = plan.tuning.hover_thrust or plan.vehicle.hover_thrust or HOVER_THRUST
    result["notes"] = [
        *_notes(estimated, plan),
        *estimate_sentences(result["found"], plan.vehicle),
        *curve_sentences(result["found"], plan.tuning.thrust_curve, hover),
    ]
    result["record"] = record
    return result


def _figures(flown: dict[str, Array], plan: Plan) -> Figures:
    t = flown["t"]
    if len(t) == 0:
        none = {"rms": None, "max": None}
        return {
            "duration_s": 0.0,
            "distance_m": 0.0,
            "laps": 0.0,
            "speed_mean_over_alpha": None,
            "path_error_m": none,
            "speed_error_mps": none,
            "yaw_error_deg": none,
        }
    distance = float(flown["travelled"][-1] - flown["travelled"][0])
    return {
        "duration_s": float(t[-1] - t[0]),
        "distance_m": distance,
        "laps": distance / plan.table.length,
        "speed_mean_over_alpha": float(np.mean(flown["speed"]) / np.mean(flown["alpha"])),
        "path_error_m": _size(flown["path_error"]),
        "speed_error_mps": _size(flown["speed_error"]),
        "yaw_error_deg": _size(np.degrees(flown["yaw_error"])),
    }


def _size(values: Array) -> dict[str, float]:
    return {"rms": float(np.sqrt(np.mean(values**2))), "max": float(np.max(np.abs(values)))}


def _settled(flown: dict[str, Array], plan: Plan, settle: float) -> Figures:
    """After ``settle`` s of each stretch; where a path has ends, without the stops there and the starts from them. The
    first start is what ``settle`` is for."""
    steady = flown["since"] >= settle
    if not plan.table.closed:
        at_speed = np.abs(flown["ramp"]) >= 0.999 * np.abs(flown["speed_scale"])
        steady &= at_speed | ~np.logical_or.accumulate(at_speed)
    late = {name: values[steady] for name, values in flown.items()}
    figures = _figures(late, plan)
    if len(late["t"]) == 0:
        return {
            **figures,
            "roll_max_deg": None,
            "pitch_max_deg": None,
            "tilt_max_deg": None,
            "thrust_n": {"min": None, "max": None},
            "motor": {"min": None, "max": None, "saturated_fraction": None},
        }
    return {
        **figures,
        "roll_max_deg": float(np.degrees(np.max(np.abs(late["roll"])))),
        "pitch_max_deg": float(np.degrees(np.max(np.abs(late["pitch"])))),
        "tilt_max_deg": float(np.degrees(np.max(late["tilt"]))),
        "thrust_n": {"min": float(np.min(late["thrust"])), "max": float(np.max(late["thrust"]))},
        "motor": _motor(late, plan),
    }


def _whole(truth: Table) -> Figures:
    """From the first step to the last, on the ground too. ``impact_mps``: the fastest it came down within NEAR_GROUND
    of its origin's height; 0 where it did not."""
    if len(truth) == 0:
        return dict.fromkeys(("height_min_m", "height_max_m", "speed_max_mps", "tilt_max_deg", "impact_mps"))
    height, down = -truth["p_n"][:, 2], truth["v_n"][:, 2]
    x, y = truth["q_nb"][:, 1], truth["q_nb"][:, 2]
    cosine = np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)
    return {
        "height_min_m": float(np.min(height)),
        "height_max_m": float(np.max(height)),
        "speed_max_mps": float(np.max(np.linalg.norm(truth["v_n"], axis=1))),
        "tilt_max_deg": float(np.degrees(np.arccos(np.min(cosine)))),
        "impact_mps": float(max(0.0, np.max(down[height < NEAR_GROUND], initial=0.0))),
    }


def _motor(flown: dict[str, Array], plan: Plan) -> Figures:
    """The commands as fractions of each rotor's range."""
    if "saturated" in flown and plan.level is not OutputLevel.MOTORS:
        return {"min": None, "max": None, "saturated_fraction": float(np.mean(flown["saturated"]))}
    fractions = np.stack(
        [
            (flown[f"sent_{i}"] - rotor.command[0]) / (rotor.command[1] - rotor.command[0])
            for i, rotor in enumerate(plan.vehicle.rotors)
        ]
    )
    at_limit = np.any((fractions <= 1e-6) | (fractions >= 1.0 - 1e-6), axis=0)
    return {
        "min": float(np.min(fractions)),
        "max": float(np.max(fractions)),
        "saturated_fraction": float(np.mean(at_limit)),
    }


def _phases(table: Table) -> list[Figures]:
    if len(table) == 0:
        return []
    begun = float(table["now"][0])
    changes = [0, *(np.flatnonzero(np.diff(table["phase"])) + 1)]
    ends = [*changes[1:], len(table) - 1]
    return [
        {
            "phase": PHASES[table["phase"][begin]].value,
            "from_s": float(table["now"][begin]) - begun,
            "to_s": float(table["now"][end]) - begun,
        }
        for begin, end in zip(changes, ends, strict=True)
    ]


def _loop(table: Table) -> Figures:
    """How steadily setpoints went out while following."""
    out = (table["phase"] == FOLLOW) & (table["setpoint"] > 0)
    sent = table[out]
    gaps = np.diff(sent["now"])[np.diff(stretches(table)[out]) == 0]
    latency = np.asarray(sent["latency"], dtype=float)
    latency = latency[np.isfinite(latency)] * 1e6
    spent = float(np.sum(gaps))
    return {
        "ticks": len(sent),
        "rate_hz": len(gaps) / spent if spent > 0.0 else None,
        "gap_max_ms": float(np.max(gaps) * 1e3) if len(gaps) else None,
        "latency_us": (
            {
                "p50": float(np.percentile(latency, 50)),
                "p99": float(np.percentile(latency, 99)),
                "max": float(np.max(latency)),
            }
            if len(latency)
            else None
        ),
    }


def _notes(estimated: dict[str, Array], plan: Plan) -> list[str]:
    """What a reader should be told in words."""
    notes = []
    if plan.level is OutputLevel.MOTORS and len(estimated["t"]):
        forces = np.stack([estimated[f"sent_{i}"] * rotor.thrust_max for i, rotor in enumerate(plan.vehicle.rotors)])
        if np.min(forces) < 0.0:
            motor, tick = np.unravel_index(int(np.argmin(forces)), forces.shape)
            share = float(np.mean(np.any(forces < 0.0, axis=0)))
            notes.append(
                f"the motors go negative: least {forces[motor, tick]:.1f} N on motor {motor + 1} at "
                f"{estimated['t'][tick]:.2f} s of following ({estimated['s'][tick]:.1f} m along the path), "
                f"some motor below zero {100.0 * share:.0f} % of the time; a real rotor only pushes"
            )
    return notes
