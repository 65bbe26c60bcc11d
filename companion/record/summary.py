"""The figures of a flight, from its table and, where it was simulated, from the plant's true state."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.flight.phases import Phase
from companion.frames import Vec3, rotation_matrix, tilt, wrap
from companion.plan import Plan
from companion.record.circumstances import software_version
from companion.record.events import happenings
from companion.record.found import found, found_words
from companion.record.table import Table
from companion.vehicle import OutputLevel

Figures = dict[str, Any]
Array = NDArray[np.float64]

PHASES = list(Phase)
FOLLOW = PHASES.index(Phase.FOLLOW)
TRUTH_RATE = 100.0
"""Hz at which the true state is measured against the path."""


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
    told = _told(table)
    result: Figures = {
        "schema": "companion.flight/1",
        "mission": plan.mission.name,
        "vehicle": plan.vehicle.name,
        "output": plan.level.value,
        "outcome": outcome,
        "reason": reason,
        "phases": _phases(table),
        "follow": _figures(told, plan),
        "settled": _settled(told, plan, settle),
    }
    if truth is not None:
        true = _true(plan, told, truth)
        result["truth"] = {"follow": _figures(true, plan), "settled": _settled(true, plan, settle)}
    result["loop"] = _loop(table)
    result["found"] = found(told)
    result["version"] = software_version()
    result["simulation"] = simulation
    result["events"] = [each.document for each in happenings(told, table, simulation)]
    result["notes"] = _notes(told, plan) + found_words(result["found"], plan.vehicle)
    result["record"] = record
    return result


def _told(table: Table) -> dict[str, Array]:
    """The followed part of a flight, one entry a steered tick. ``stretch``: a pilot may take over and give back.
    ``t``: s of following; ``since``: s since following began, or began again. ``speed``: on the way back counted as on
    the way out."""
    steered = (table["phase"] == FOLLOW) & np.isfinite(table["alpha"])
    rows = table[steered]
    columns = {name: np.asarray(rows[name], dtype=float) for name in rows.dtype.names or ()}
    columns["stretch"] = _stretches(table)[steered]
    t_boot = columns["t_boot"]
    goes_on = np.diff(columns["stretch"]) == 0
    columns["t"] = np.cumsum(np.concatenate(([0.0], np.where(goes_on, np.diff(t_boot), 0.0))))[: len(rows)]
    begins = np.concatenate(([True], ~goes_on))[: len(rows)]
    columns["since"] = t_boot - t_boot[begins][np.cumsum(begins) - 1]
    columns["speed"] = columns["speed"] * np.where(columns["ramp"] < 0.0, -1.0, 1.0)
    columns["speed_error"] = columns["speed"] - columns["alpha"]
    columns["roll"] = np.arctan2(
        2.0 * (columns["q_w"] * columns["q_x"] + columns["q_y"] * columns["q_z"]),
        1.0 - 2.0 * (columns["q_x"] ** 2 + columns["q_y"] ** 2),
    )
    sine = 2.0 * (columns["q_w"] * columns["q_y"] - columns["q_z"] * columns["q_x"])
    columns["pitch"] = np.arcsin(np.clip(sine, -1.0, 1.0))
    return columns


def _stretches(table: Table) -> Array:
    """Which stretch of following each row is in, counted from 1; 0 where the path is not followed."""
    following = table["phase"] == FOLLOW
    begins = following & ~np.concatenate(([False], following[:-1]))
    return np.where(following, np.cumsum(begins), 0).astype(float)


def _true(plan: Plan, told: dict[str, Array], truth: Table) -> dict[str, Array]:
    """The same from the plant's true state, while the companion was following."""
    t_boot = told["t_boot"]
    if len(t_boot) == 0 or len(truth) == 0:
        return _nothing()
    rows = truth[(truth["t_boot"] >= t_boot[0]) & (truth["t_boot"] <= t_boot[-1])]
    rows = rows[np.interp(rows["t_boot"], t_boot, told["stretch"]) % 1.0 == 0.0]
    if len(rows) > 1:
        stride = max(1, round(1.0 / TRUTH_RATE / float(np.median(np.diff(rows["t_boot"])))))
        rows = rows[::stride]
    names = ("stretch", "t", "since", "ramp", "speed_scale")
    then = (np.interp(rows["t_boot"], t_boot, told[name]) for name in names)
    collected = []
    s: float | None = None
    travelled, flown = 0.0, 0.0
    for row, stretch, t, since, ramp, scale in zip(rows, *then, strict=True):
        way = -1.0 if ramp < 0.0 else 1.0
        p_n, v_n = _vec3(row["p_n"]), _vec3(row["v_n"])
        if s is None or stretch != flown:
            s, distance = plan.table.locate(p_n)
            flown = stretch
        else:
            before = s
            s, distance = plan.table.nearest(p_n, s, 1.0 + 0.2 * math.hypot(*v_n))
            travelled += way * plan.direction * plan.table.difference(s, before)
        _, mu, _ = plan.table.at(s)
        w, x, y, z = map(float, row["q_nb"])
        r_nb = rotation_matrix((w, x, y, z))
        speed = way * (mu[0] * v_n[0] + mu[1] * v_n[1] + mu[2] * v_n[2])
        alpha = plan.mission.alpha(s)
        yaw = plan.mission.heading.of(r_nb)
        collected.append(
            (
                float(t),
                float(since),
                distance,
                speed,
                alpha,
                speed - alpha,
                wrap(yaw - plan.mission.beta(s)),
                travelled,
                float(ramp),
                float(scale),
                math.atan2(r_nb[7], r_nb[8]),
                math.asin(max(-1.0, min(1.0, -r_nb[6]))),
                tilt(r_nb),
                float(sum(row["rotor_thrusts"])),
                *map(float, row["commands"]),
            )
        )
    values = np.array(collected).reshape(len(collected), len(_TRUE_COLUMNS))
    return {name: values[:, i] for i, name in enumerate(_TRUE_COLUMNS)}


_TRUE_COLUMNS = (
    "t", "since", "path_error", "speed", "alpha", "speed_error", "yaw_error", "travelled", "ramp", "speed_scale",
    "roll", "pitch", "tilt", "thrust", "sent_0", "sent_1", "sent_2", "sent_3",
)  # fmt: skip


def _vec3(values: Array) -> Vec3:
    x, y, z = map(float, values)
    return (x, y, z)


def _nothing() -> dict[str, Array]:
    return {name: np.zeros(0) for name in _TRUE_COLUMNS}


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
    gaps = np.diff(sent["now"])[np.diff(_stretches(table)[out]) == 0]
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


def _notes(told: dict[str, Array], plan: Plan) -> list[str]:
    """What a reader should be told in words."""
    notes = []
    if plan.level is OutputLevel.MOTORS and len(told["t"]):
        forces = np.stack([told[f"sent_{i}"] * rotor.thrust_max for i, rotor in enumerate(plan.vehicle.rotors)])
        if np.min(forces) < 0.0:
            motor, tick = np.unravel_index(int(np.argmin(forces)), forces.shape)
            share = float(np.mean(np.any(forces < 0.0, axis=0)))
            notes.append(
                f"the motors go negative: least {forces[motor, tick]:.1f} N on motor {motor + 1} at "
                f"{told['t'][tick]:.2f} s of following ({told['s'][tick]:.1f} m along the path), "
                f"some motor below zero {100.0 * share:.0f} % of the time; a real rotor only pushes"
            )
    return notes
