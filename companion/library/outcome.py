"""How a flight ended, and its summary: the same for every command and for ``simulate``."""

from __future__ import annotations

import json
import traceback
from pathlib import Path
from typing import Any, NamedTuple

from companion import pilot
from companion.daemon.conductor import Conductor
from companion.daemon.last_resort import LastResort, error_words
from companion.daemon.vehicle_words import describe_vehicle
from companion.record.folder import Recorder
from companion.record.summary import summary
from companion.record.table import Table, read_table
from companion.vehicle import CompanionError


class OwnFailureError(CompanionError):
    """The companion itself failed: no result of the vehicle, its mission or its world."""


class Ended(NamedTuple):
    """How it came to its end, at ``now`` (s, as at the conductor's doors). ``stopped``: a signal asked for it.
    ``failure``: what ended it where the companion itself failed."""

    now: float
    stopped: bool
    failure: LastResort | None = None


def is_completed(conductor: Conductor, ended: Ended) -> bool:
    """Whether the mission was flown as it was asked for."""
    return ended.failure is None and conductor.memory is not None and pilot.completed(conductor.memory)


def reason_of(conductor: Conductor, ended: Ended) -> str:
    """Why it was not completed: what happened, what was done, what to do next."""
    if ended.failure is not None:
        return ended.failure.sentence
    mode = conductor.telemetry.status.last.mode
    reason = None if conductor.memory is None else pilot.epilogue(conductor.memory, mode)
    reason = reason or conductor.refusal or "the flight ended before it was finished"
    where = describe_vehicle(conductor, ended.now) if ended.stopped else None
    return reason if where is None else f"{reason}: {where}"


def figures_of(conductor: Conductor, recorder: Recorder, settle: float, reason: str | None) -> dict[str, Any]:
    """The summary, written; what is left of it where its figures fail. ``reason``: why it was not completed."""
    outcome = "completed" if reason is None else "aborted"
    plan = conductor.plan
    assert plan is not None
    directory = recorder.directory
    figures: dict[str, Any] = {
        "schema": "companion.flight/1",
        "mission": plan.mission.name,
        "vehicle": plan.vehicle.name,
        "output": plan.level.value,
        "outcome": outcome,
        "reason": reason,
        "notes": [],
        "record": str(directory),
    }
    try:
        table = recorder.table
        if table is None:
            figures["notes"].append("there are no figures: the record cannot be read")
        else:
            truth = _truth(directory / "truth.npy")
            figures = summary(plan, table, truth, settle, outcome, reason, str(directory), recorder.simulation)
    except Exception as error:  # the outcome is known without them
        recorder.keep_failure(traceback.format_exc())
        figures["notes"].append(f"the figures could not be computed ({error_words(error)}); send in the flight folder")
    figures["notes"] += recorder.losses + notes_of_the_link(conductor)
    recorder.keep("summary.json", json.dumps(figures, indent=2) + "\n")
    return figures


def _truth(file: Path) -> Table | None:
    try:
        return read_table(file).rows
    except (OSError, ValueError):
        return None


def notes_of_the_link(conductor: Conductor) -> list[str]:
    """What came in and was no use, in words."""
    counters, notes = conductor.decoder.counters, []
    if counters.garbage_bytes or counters.bad_crc:
        notes.append(
            f"the link brought {counters.garbage_bytes} bytes that were no message and {counters.bad_crc} damaged "
            f"messages, beside {counters.frames + counters.unknown} good ones; they were skipped"
        )
    notes += conductor.link.peers.words()
    notes += [] if conductor.xrce is None else conductor.xrce.words()
    refused = conductor.telemetry.refused.items()
    return notes + [f"{count} states of the vehicle were not used: {reason}" for reason, count in refused]
