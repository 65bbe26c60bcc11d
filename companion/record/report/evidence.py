"""Everything the page is made from, whatever is missing from the flight folder."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion import pilot
from companion.flight.phases import Phase
from companion.plan import Plan
from companion.record import rows
from companion.record.events import FlightEvent, flight_events
from companion.record.replay import RecordedFlight, load_flight
from companion.record.series import followed_series, true_series
from companion.record.summary import summary
from companion.record.table import Table
from companion.record.ulog.joined import VehicleLog, kept

Array = NDArray[np.float64]
Series = dict[str, Array]
Figures = dict[str, Any]

SETTLE = 10.0
"""s of following after which a flight counts as settled where its summary is missing."""
PARTS = ("mission", "vehicle", "output", "outcome", "phases", "follow", "settled", "loop")


@dataclass(frozen=True)
class Evidence:
    """A flight, read for its report.

    ``figures``: the summary. ``resolved``: resolved.json. ``remade``: the summary was missing and has been computed
    again. ``sources``: the text of mission.yaml and vehicle.yaml. ``cuts``: which files end before their flight did.
    """

    directory: Path
    plan: Plan
    table: Table
    truth: Table | None
    figures: Figures
    resolved: Figures
    remade: bool
    sources: dict[str, str]
    cuts: tuple[str, ...] = ()

    @cached_property
    def estimated(self) -> Series:
        """The followed part as the companion saw it; ``t`` is s of following."""
        return followed_series(self.table)

    @cached_property
    def true(self) -> Series | None:
        """The same from the plant's true state; None where there is none."""
        if self.truth is None or len(self.truth) == 0 or len(self.estimated["t"]) == 0:
            return None
        series = true_series(self.plan, self.estimated, self.truth)
        return series if len(series["t"]) else None

    @cached_property
    def vehicle_log(self) -> VehicleLog | None:
        """The vehicle's own log, where it was joined."""
        return kept(self.directory)

    @cached_property
    def flight_events(self) -> list[FlightEvent]:
        """What happened while following, in the order of time."""
        return flight_events(self.estimated, self.table, self.resolved.get("simulation"))

    @property
    def has_following(self) -> bool:
        """Whether there is a followed part worth a figure."""
        return len(self.estimated["t"]) > 1

    @property
    def following_s(self) -> float:
        """How long the path was followed, s."""
        return float(self.estimated["t"][-1])

    @cached_property
    def settled_from(self) -> float | None:
        """s of following after which the flight counts as settled; None if it ended before."""
        # the summary does not say which --settle it was made with, but what it left out does
        whole, rest = self.number("follow", "duration_s"), self.number("settled", "duration_s")
        if whole is None or rest is None or rest <= 0.0:
            return None
        return round(whole - rest, 1)

    @property
    def simulated(self) -> bool:
        """Whether a plant flew it, not a vehicle: only plants know the truth."""
        return self.truth is not None or self.lockstep

    @property
    def lockstep(self) -> bool:
        """Whether its clock was simulated too."""
        return not self.resolved.get("epoch")

    def number(self, *keys: str) -> float | None:
        """A figure of the summary; None where it is missing or not a number."""
        value: Any = self.figures
        for key in keys:
            value = value.get(key) if isinstance(value, dict) else None
        return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def read_evidence(directory: Path) -> Evidence:
    """The evidence in a flight folder. ConfigError: it is not one."""
    flight = load_flight(directory)
    figures = _summary(directory)
    resolved = json.loads((directory / "resolved.json").read_text(encoding="utf-8"))
    remade = figures is None
    if figures is None:
        outcome, reason = _ending(flight)
        figures = summary(
            flight.plan, flight.table, flight.truth, SETTLE, outcome, reason, str(directory), resolved.get("simulation")
        )
    return Evidence(
        directory=directory,
        plan=flight.plan,
        table=flight.table,
        truth=flight.truth,
        figures=figures,
        resolved=resolved,
        remade=remade,
        sources={
            name: (directory / name).read_text(encoding="utf-8")
            for name in ("mission.yaml", "vehicle.yaml", "world.yaml")
            if (directory / name).is_file()
        },
        cuts=flight.cuts,
    )


def _summary(directory: Path) -> Figures | None:
    """summary.json, or None where it is missing or cut short: a daemon that was killed writes none."""
    try:
        figures = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return figures if isinstance(figures, dict) and all(part in figures for part in PARTS) else None


def _ending(flight: RecordedFlight) -> tuple[str, str | None]:
    """(outcome, reason) of a flight whose summary is missing, from its record."""
    if len(flight.table) == 0:
        return "aborted", "the record ends before the first tick"
    last = flight.table[-1]
    phase = list(Phase)[last["phase"]]
    if phase is not Phase.DONE:
        at = float(last["now"] - flight.table["now"][0])
        return "aborted", f"the record ends in the middle of the flight, {at:.1f} s after it began ({phase.value})"
    # the end itself was recorded: the pilot, fed the same again, knows what it thought of it
    memory = pilot.begin(flight.begun_at)
    for row in flight.table:
        observation, now = rows.observation_of(row)
        memory, _ = pilot.step(flight.plan_at(now), memory, observation, now)
    if pilot.completed(memory):
        return "completed", None
    return "aborted", memory.first_fault or "the flight ended before it was finished"
