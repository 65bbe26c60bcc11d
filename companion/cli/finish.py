"""What every flight ends with: the summary, the flight folder, the report, the exit code."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from typing import Any

from companion import pilot
from companion.daemon.conductor import Conductor
from companion.plain_text import printable_lines
from companion.record.folder import Recorder, write_json
from companion.record.summary import summary
from companion.record.table import load_table

COMPLETED, FAILED, BAD_INPUT, NO_VEHICLE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""


@dataclass(frozen=True)
class Ending:
    """How a flight is told. ``json``: stdout is one JSON document. ``settle``: s after which a flight is settled.
    ``report``: write the page too."""

    json: bool
    settle: float
    report: bool = False


def say(text: str) -> None:
    """A line for a person: always on stderr, so that stdout is the result's."""
    print(printable_lines(text), file=sys.stderr, flush=True)


def finish(conductor: Conductor, recorder: Recorder, ending: Ending, stopped: bool) -> int:
    """Close the record, print the summary; the exit code."""
    recorder.close()
    plan, memory = conductor.plan, conductor.memory
    if plan is None or memory is None:
        code = refuse(conductor.refusal or "the flight did not begin", ending.json)
        return INTERRUPTED if stopped else code
    done = pilot.completed(memory)
    reason = pilot.epilogue(memory, conductor.telemetry.status.mode) or (
        None if done else conductor.refusal or "the flight ended before it was finished"
    )
    directory = recorder.directory
    table = load_table(directory / "flight.npy")
    truth = load_table(directory / "truth.npy") if (directory / "truth.npy").is_file() else None
    outcome = "completed" if done else "aborted"
    figures = summary(plan, table, truth, ending.settle, outcome, reason, str(directory), recorder.simulation)
    figures["notes"] += _of_the_link(conductor)
    write_json(directory / "summary.json", figures)
    if ending.report:
        from companion.record.report import write_report

        say(f"report: {write_report(directory)}")
    if ending.json:
        print(json.dumps(figures, indent=2))
    else:
        print(printable_lines(_text(figures)))
    return COMPLETED if done else INTERRUPTED if stopped else FAILED


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


def refuse(reason: str, as_json: bool) -> int:
    """Say why nothing was flown; the exit code."""
    if as_json:
        print(json.dumps({"schema": "companion.flight/1", "outcome": "aborted", "reason": reason}, indent=2))
    else:
        print(printable_lines(f"not flown: {reason}"))
    return FAILED


def _text(figures: dict[str, Any]) -> str:
    """The summary for a person."""
    reason = f": {figures['reason']}" if figures["reason"] else ""
    lines = [f"{figures['outcome']}{reason}", ""]
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
    lines += ["", *(f"  {words}" for words in happened)] if happened else []
    lines += [f"  note: {note}" for note in figures["notes"]]
    if figures["record"]:
        lines += ["", f"  flight folder: {figures['record']}"]
    return "\n".join(lines)


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
