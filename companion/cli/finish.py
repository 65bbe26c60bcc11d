"""What every flight ends with: the summary, the flight folder, the report, the exit code."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from companion.cli.page import write_page
from companion.cli.terminal import tell, warn
from companion.daemon.conductor import Conductor
from companion.daemon.signals import INTERRUPTED
from companion.library.outcome import Ended, figures_of, is_completed, reason_of
from companion.record.folder import Recorder

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


def finish(conductor: Conductor, recorder: Recorder, ending: Ending, ended: Ended) -> int:
    """Close the record, print the summary; the exit code. Whatever the disk does, the outcome is told."""
    done = is_completed(conductor, ended)
    code = COMPLETED if done else FAILED if ended.failure is not None else INTERRUPTED if ended.stopped else FAILED
    if code == FAILED and not conductor.preparation.is_ours:
        code = NO_VEHICLE
    reason = None if done else reason_of(conductor, ended)
    recorder.flush(sync=True)
    if ended.failure is not None:
        recorder.keep_failure(ended.failure.trace)
        warn(ended.failure.sentence)
    if conductor.plan is None or conductor.memory is None:
        refuse(reason or "the flight did not begin", ending.json)
    else:
        figures = figures_of(conductor, recorder, ending.settle, reason)
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
        lines += _flight_lines(figures)
    lines += [f"  note: {note}" for note in figures["notes"]]
    if figures["record"]:
        lines += ["", f"  flight folder: {figures['record']}"]
    return "\n".join(lines)


def _flight_lines(figures: dict[str, Any]) -> list[str]:
    """How it was flown, in lines."""
    lines: list[str] = []
    where = _where(figures)
    flown = figures["follow"]
    lines.append(
        f"  {figures['mission']} on {figures['vehicle']} at {figures['output']}: followed for "
        f"{flown['duration_s']:.1f} s, {flown['distance_m']:.1f} m, {flown['laps']:z.2f} laps"
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
        f"; motors {100.0 * motor['min']:z.1f} to {100.0 * motor['max']:.1f} % of their range, "
        f"saturated {100.0 * saturated:.1f} % of the time"
    )
