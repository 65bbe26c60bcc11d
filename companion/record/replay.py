"""The recorded inputs of a flight through the pilot again: the same setpoints, bit for bit."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from companion import pilot
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.vehicle import vehicle_from
from companion.estimation.learned import Learned
from companion.feasibility.auto import flyable
from companion.flight.conduct import from_dict
from companion.plan import Plan, prepared
from companion.record import rows
from companion.record.recorded import UNREADABLE, read_folder, unreadable
from companion.record.table import Table
from companion.record.tick_columns import COLUMNS, OUTCOME_COLUMNS, OUTCOME_DTYPE
from companion.settings import with_settings
from companion.vehicle import MotorInterface, Tuning


@dataclass(frozen=True, slots=True)
class RecordedFlight:
    """A flight folder, read again. ``plan``: as it was at the end; ``plans``: from which time (s) on which was flown.
    ``cuts``: in words, which of its files end before their flight did."""

    plan: Plan
    table: Table
    truth: Table | None
    begun_at: float
    cuts: tuple[str, ...] = ()
    plans: tuple[tuple[float, Plan], ...] = ()

    def plan_at(self, now: float) -> Plan:
        """The plan that a tick at ``now`` was flown with."""
        plan = self.plan
        for since, each in self.plans:
            if now < since:
                break
            plan = each
        return plan


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """``ticks`` fed, ``setpoints`` made, and the first tick whose outcome differs (None: all the same)."""

    ticks: int
    setpoints: int
    difference: str | None


def load_flight(directory: Path) -> RecordedFlight:
    """The flight in a folder, its plan made again. ConfigError: it is not one, or lacks a part."""
    folder = read_folder(directory)
    resolved = folder.resolved
    try:
        tuning = Tuning(**resolved["tuning"])
        conduct = from_dict(resolved["conduct"])
        settings = [(float(each["at"]), dict(each["set"])) for each in resolved.get("settings", ())]
        learned = None if resolved.get("learned") is None else Learned(**resolved["learned"])
        motors, duration = MotorInterface(resolved["motors"]), resolved["duration_s"]
    except UNREADABLE as error:
        raise unreadable(directory / "resolved.json", error) from None
    vehicle = replace(vehicle_from(folder.vehicle), motors=motors)
    mission = flyable(folder.mission, vehicle).placed(folder.origin_n, folder.turn)
    plan = prepared(mission, vehicle, folder.level, folder.origin_n, duration, tuning, conduct, learned)
    plans = [(-math.inf, plan)]
    for at, changed in settings:
        plans.append((at, with_settings(plans[-1][1], changed)))
    return RecordedFlight(plans[-1][1], folder.table, folder.truth, folder.begun_at, folder.cuts, tuple(plans))


def replay(flight: RecordedFlight) -> ReplayResult:
    """Feed what the pilot saw through the pilot again and compare what it does.

    ConfigError: another version recorded the flight, and some of what this one sees is not in it.
    """
    missing = [column.name for column in COLUMNS if column.name not in (flight.table.dtype.names or ())]
    if missing:
        message = (
            f"another version of companion recorded it: {len(missing)} columns that this one needs are not in it, "
            f"{missing[0]} among them; replay it with the version that flew it. The report can still be drawn"
        )
        raise ConfigError([Fault("flight.npy", 0, "", message)])
    memory = pilot.begin(flight.begun_at)
    setpoints = 0
    names = [column.name for column in OUTCOME_COLUMNS]
    recorded = flight.table[names]
    for index, row in enumerate(flight.table):
        seen, now = rows.observation_of(row)
        memory, outcome = pilot.step(flight.plan_at(now), memory, seen, now)
        again = np.array([rows.outcome_row(memory, outcome)], dtype=OUTCOME_DTYPE)
        setpoints += outcome.setpoint is not None
        if again[0].tobytes() != np.array([tuple(recorded[index])], dtype=OUTCOME_DTYPE).tobytes():
            was, now_is = tuple(recorded[index].tolist()), tuple(again[0].tolist())
            changed = ", ".join(f"{n} {a} -> {b}" for n, a, b in zip(names, was, now_is, strict=True) if a != b)
            return ReplayResult(index + 1, setpoints, f"tick {index} at {now:.3f} s: {changed}")
    return ReplayResult(len(flight.table), setpoints, None)
