"""The recorded inputs of a flight through the pilot again: the same setpoints, bit for bit."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from companion import pilot
from companion.config.mission.mission import mission_from
from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.vehicle import vehicle_from
from companion.estimation.learned import Learned
from companion.feasibility.auto import flyable
from companion.flight.conduct import from_dict
from companion.geodesy import GivenHome
from companion.plan import Plan, law_level, prepared
from companion.record import rows
from companion.record.table import Table, read_table
from companion.settings import with_settings
from companion.vehicle import MotorInterface, OutputLevel, Tuning


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
    """The flight in a folder. ConfigError: it is not one, or lacks a part."""
    if not directory.is_dir():
        raise ConfigError([Fault(str(directory), 0, "", "no such folder; expected a flight folder")])
    resolved_file = directory / "resolved.json"
    reading = resolved_file
    try:
        resolved = json.loads(resolved_file.read_text(encoding="utf-8"))
        level = OutputLevel(resolved["output"])
        x, y, z = resolved["origin_n"]
        turn = float(resolved["turn_rad"])
        given = GivenHome(*resolved.get("home_told", ()))
        begun_at = float(resolved["begun_at"])
        tuning = Tuning(**resolved["tuning"])
        conduct = from_dict(resolved["conduct"])
        settings = [(float(each["at"]), dict(each["set"])) for each in resolved.get("settings", ())]
        learned = None if resolved.get("learned") is None else Learned(**resolved["learned"])
        reading = directory / "mission.yaml"
        mission = _document(reading)
        reading = directory / "vehicle.yaml"
        vehicle = _document(reading)
        reading = directory / "flight.npy"
        table, cut = read_table(reading, rows.COLUMNS)
        truth, truth_cut = _truth(directory / "truth.npy")
    except FileNotFoundError as error:
        message = f"{Path(str(error.filename)).name} is missing; expected a flight folder"
        if error.filename == str(resolved_file) and (directory / "link.tlog").is_file():
            message = "the record ends before the flight began; link.tlog has what was heard until then"
        raise ConfigError([Fault(str(directory), 1, "", message)]) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        what = f"key {error} is missing" if isinstance(error, KeyError) else str(error)
        message = f"cannot be read: {what}; expected it as the flight wrote it"
        raise ConfigError([Fault(str(reading), 1, "", message)]) from None
    machine = replace(vehicle_from(vehicle), motors=MotorInterface(resolved["motors"]))
    read = mission_from(mission, law_level(level), directory, given, simulated=True)
    flown = flyable(read, machine).placed((x, y, z), turn)
    plan = prepared(flown, machine, level, (x, y, z), resolved["duration_s"], tuning, conduct, learned)
    cuts = tuple(words for words in (cut, truth_cut) if words is not None)
    plans = [(-math.inf, plan)]
    for at, changed in settings:
        plans.append((at, with_settings(plans[-1][1], changed)))
    return RecordedFlight(plans[-1][1], table, truth, begun_at, cuts, tuple(plans))


def replay(flight: RecordedFlight) -> ReplayResult:
    """Feed what the pilot saw through the pilot again and compare what it does.

    ConfigError: another version recorded the flight, and some of what this one sees is not in it.
    """
    missing = [column.name for column in rows.COLUMNS if column.name not in (flight.table.dtype.names or ())]
    if missing:
        message = (
            f"another version of companion recorded it: {len(missing)} columns that this one needs are not in it, "
            f"{missing[0]} among them; replay it with the version that flew it. The report can still be drawn"
        )
        raise ConfigError([Fault("flight.npy", 0, "", message)])
    memory = pilot.begin(flight.begun_at)
    setpoints = 0
    names = [column.name for column in rows.OUTCOME_COLUMNS]
    recorded = flight.table[names]
    for index, row in enumerate(flight.table):
        seen, now = rows.observation_of(row)
        memory, outcome = pilot.step(flight.plan_at(now), memory, seen, now)
        again = np.array([rows.outcome_row(memory, outcome)], dtype=rows.OUTCOME_DTYPE)
        setpoints += outcome.setpoint is not None
        if again[0].tobytes() != np.array([tuple(recorded[index])], dtype=rows.OUTCOME_DTYPE).tobytes():
            was, now_is = tuple(recorded[index].tolist()), tuple(again[0].tolist())
            changed = ", ".join(f"{n} {a} -> {b}" for n, a, b in zip(names, was, now_is, strict=True) if a != b)
            return ReplayResult(index + 1, setpoints, f"tick {index} at {now:.3f} s: {changed}")
    return ReplayResult(len(flight.table), setpoints, None)


def _truth(path: Path) -> tuple[Table | None, str | None]:
    """The plant's true state, and how it was cut; None where there is none."""
    if not path.is_file():
        return None, None
    try:
        return read_table(path)
    except ValueError:
        return None, f"{path.name} is cut within its header: no row of it is left"


def _document(path: Path) -> Document:
    return parse(path.read_text(encoding="utf-8"), str(path))
