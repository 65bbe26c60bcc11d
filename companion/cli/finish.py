"""What every flight ends with: the summary, the flight folder, the report, the exit code."""

from __future__ import annotations

import json
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from companion import pilot
from companion.cli.page import write_page
from companion.cli.terminal import tell, warn
from companion.daemon.conductor import Conductor
from companion.daemon.last_resort import LastResort, told
from companion.daemon.signals import INTERRUPTED
from companion.daemon.whereabouts import whereabouts
from companion.record.folder import Recorder
from companion.record.summary import summary
from companion.record.table import Table, read_table

COMPLETED, FAILED, BAD_INPUT, NO_VEHICLE = 0, 1, 2, 3
"""Exit codes."""
__all__ = [
    "BAD_INPUT",
    "COMPLETED",
    "FAILED",
    "INTERRUPTED",
    "NO_VEHICLE",
    "Ended",
    "Ending",
    "finish",
    "refuse",
]


@dataclass(frozen=True)
class Ending:
    """How a flight is told. ``json``: stdout is one JSON document. ``settle``: s after which a flight is settled.
    ``report``: write the page too."""

    json: bool
    settle: float
    report: bool = False


class Ended(NamedTuple):
    """How it came to its end, at ``now`` (s, as at the conductor's doors). ``stopped``: a signal asked for it.
    ``failure``: what ended it where the companion itself failed."""

    now: float
    stopped: bool
    failure: LastResort | None = None


def finish(conductor: Conductor, recorder: Recorder, ending: Ending, ended: Ended) -> int:
    """Close the record, print the summary; the exit code. Whatever the disk does, the outcome is told."""
    done = ended.failure is None and conductor.memory is not None and pilot.completed(conductor.memory)
    code = COMPLETED if done else FAILED if ended.failure is not None else INTERRUPTED if ended.stopped else FAILED
    reason = None if done else _reason(conductor, ended)
    recorder.flush(sync=True)
    if ended.failure is not None:
        recorder.keep_failure(ended.failure.trace)
        warn(ended.failure.sentence)
    if conductor.plan is None or conductor.memory is None:
        refuse(reason or "the flight did not begin", ending.json)
    else:
        figures = _figures(conductor, recorder, ending, "completed" if done else "aborted", reason)
        tell(json.dumps(figures, indent=2) if ending.json else _text(figures))
        if ending.report and recorder.answers:
            write_page(recorder.directory)
    if conductor.link.identity is None and ended.failure is None:
        recorder.discard()  # nobody was heard: there is nothing to keep
    else:
        recorder.close()
    while recorder.words:
        warn(recorder.words.popleft())
    return code


def _reason(conductor: Conductor, ended: Ended) -> str:
    """Why it was not completed: what happened, what was done, what to do next."""
    if ended.failure is not None:
        return ended.failure.sentence
    mode = conductor.telemetry.status.last.mode
    reason = None if conductor.memory is None else pilot.epilogue(conductor.memory, mode)
    reason = reason or conductor.refusal or "the flight ended before it was finished"
    where = whereabouts(conductor, ended.now) if ended.stopped else None
    return reason if where is None else f"{reason}: {where}"


def _figures(
    conductor: Conductor, recorder: Recorder, ending: Ending, outcome: str, reason: str | None
) -> dict[str, Any]:
    """The summary, written; what is left of it where its figures fail."""
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
            figures = summary(plan, table, truth, ending.settle, outcome, reason, str(directory), recorder.simulation)
    except Exception as error:  # the outcome is known without them
        recorder.keep_failure(traceback.format_exc())
        figures["notes"].append(f"the figures could not be computed ({told(error)}); send in the flight folder")
    figures["notes"] += recorder.losses + _of_the_link(conductor)
    recorder.keep("summary.json", json.dumps(figures, indent=2) + "\n")
    return figures


def _truth(file: Path) -> Table | None:
    try:
        return read_table(file).rows
    except (OSError, ValueError):
        return None


def _of_the_link(conductor: Conductor) -> list[str]:
    """What came in and was no use, in words."""
    counters, notes = conductor.decoder.counters, []
    if counters.garbage_bytes or counters.bad_crc:
        notes.append(
            f"the link brought {counters.garbage_bytes} bytes that were no message and {counters.bad_crc} damaged "
            f"messages, beside {counters.frames + counters.unknown} good ones; they were skipped"
        )
    notes += conductor.link.peers.words()
    refused = conductor.telemetry.refused.items()
    return notes + [f"{count} states of the vehicle were not used: {reason}" for reason, count in refused]


def refuse(reason: str, as_json: bool, what: str = "not flown") -> int:
    """Say why nothing was flown; the exit code."""
    if as_json:
        tell(json.dumps({"schema": "companion.flight/1", "outcome": "aborted", "reason": reason}, indent=2))
    else:
        tell(f"{what}: {reason}")
    return FAILED


def _text(figures: dict[str, Any]) -> str:
    """The summary for a person."""
    reason = f": {figures['reason']}" if figures["reason"] else ""
    lines = [f"{figures['outcome']}{reason}", ""]
    if "follow" in figures:
        lines += _flown(figures)
    lines += [f"  note: {note}" for note in figures["notes"]]
    if figures["record"]:
        lines += ["", f"  flight folder: {figures['record']}"]
    return "\n".join(lines)


def _flown(figures: dict[str, Any]) -> list[str]:
    """How it was flown, in lines."""
    lines: list[str] = []
    where = _where(figures)
    flown = figures["follow"]
    lines.append(
        f"  {figures['mission']} on {figures['vehicle']} at {figures['output']}: followed for "
        f"{flown['duration_s']:.1f} s, {flown['distance_m']:.1f} m, {flown['laps']:.2f} laps"
    )
    lines.append(f"  {where}")
    columns = [("follow", figures["follow"]), ("settled", figures["settled"])]
    if "truth" in figures:
        columns.append(("settled, true", figures["truth"]["settled"]))
    lines += ["", f"  {'':24}" + "".join(f"{name:>22}" for name, _ in columns)]
    lines.append(f"  {'':24}" + f"{'rms      max':>22}" * len(columns))
    for key, name, factor, digits in (
        ("path_error_m", "path error, cm", 100.0, 2),
        ("speed_error_mps", "speed error, m/s", 1.0, 3),
        ("yaw_error_deg", "yaw error, deg", 1.0, 2),
    ):
        cells = "".join(_cell(column[key], factor, digits) for _, column in columns)
        lines.append(f"  {name:24}{cells}")
    settled = figures["settled"]
    if settled["tilt_max_deg"] is not None:
        lines.append("")
        lines.append(
            f"  settled: roll to {settled['roll_max_deg']:.2f}, pitch to {settled['pitch_max_deg']:.2f}, tilt to "
            f"{settled['tilt_max_deg']:.2f} deg; thrust {settled['thrust_n']['min']:.2f} to "
            f"{settled['thrust_n']['max']:.2f} N" + _motors(settled["motor"])
        )
    loop = figures["loop"]
    if loop["rate_hz"] is not None:
        latency = loop["latency_us"]
        lines.append(
            f"  loop: {loop['ticks']} setpoints at {loop['rate_hz']:.0f} Hz, longest gap {loop['gap_max_ms']:.1f} ms"
            + (f", state to setpoint {latency['p50']:.0f} us (p99 {latency['p99']:.0f})" if latency else "")
        )
    happened = [event["words"] for event in figures["events"]]
    return lines + (["", *(f"  {words}" for words in happened)] if happened else [])


def _where(figures: dict[str, Any]) -> str:
    """World, air, seed and version."""
    simulation, version = figures["simulation"], f"companion {figures['version']}"
    if simulation is None:
        return version
    return f"world {simulation['world']}: {simulation['air']}; seed {simulation['seed']}; {version}"


def _cell(size: dict[str, float | None], factor: float, digits: int) -> str:
    if size["rms"] is None or size["max"] is None:
        return f"{'-':>22}"
    return f"{size['rms'] * factor:>13.{digits}f}{size['max'] * factor:>9.{digits}f}"


def _motors(motor: dict[str, float | None]) -> str:
    if motor["min"] is None or motor["max"] is None:
        return ""
    saturated = motor["saturated_fraction"] or 0.0
    return (
        f"; motors {100.0 * motor['min']:.1f} to {100.0 * motor['max']:.1f} % of their range, "
        f"saturated {100.0 * saturated:.1f} % of the time"
    )
