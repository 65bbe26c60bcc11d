"""The words of the page: what was flown, how it ended, its phases, and the table of the numbers that matter."""

from __future__ import annotations

import html
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from companion.record.events import OWN, in_words, length_in_words
from companion.record.report.evidence import SETTLE, Evidence
from companion.record.report.palette import PHASES
from companion.vehicle import OutputLevel

NBSP = "\N{NO-BREAK SPACE}"
NED = ("north", "east", "down")
HAPPENED_MAX = 8
"""Events that are told in sentences (engineering choice)."""
AT_FIRST = 0.1
"""s of following within which an error is what there was before (engineering choice)."""
LARGE = 0.02
"""m of path error whose cause is worth a sentence (engineering choice)."""
RECOVERY = 5.0
"""s after an event in which an error is taken for its, where the vehicle was not back before (engineering choice)."""
LEVELS = {
    OutputLevel.MOTORS: "motor commands",
    OutputLevel.TORQUES: "torques and thrust",
    OutputLevel.RATES: "body rates and thrust",
    OutputLevel.ATTITUDE: "attitude and thrust",
}


def facts(evidence: Evidence) -> list[str]:
    """Vehicle, output level, kind of flight, date."""
    return [
        str(evidence.figures["vehicle"]),
        LEVELS[evidence.plan.level],
        _kind(evidence),
        *_world(evidence),
        f"companion {evidence.resolved.get('version', 'of an unknown version')}",
        *([] if evidence.lockstep else [_date(evidence)]),
    ]


def _world(evidence: Evidence) -> list[str]:
    """The simulated world: its name, its air, the seed."""
    simulation = evidence.resolved.get("simulation")
    if not isinstance(simulation, dict):
        return []
    return [f"world {simulation.get('world')}", str(simulation.get("air")), f"seed {simulation.get('seed')}"]


def event_sentences(evidence: Evidence) -> list[str]:
    """What happened, a sentence each, and where the largest path error comes from."""
    done = [each for each in evidence.flight_events if each.kind not in OWN]
    lines = [f"At {in_words(each)}." for each in done[:HAPPENED_MAX]]
    if len(done) > HAPPENED_MAX:
        lines.append(f"{len(done) - HAPPENED_MAX} more events are in summary.json.")
    return [*lines, *_largest(evidence)]


def _largest(evidence: Evidence) -> list[str]:
    """Where the largest path error comes from, as far as the record knows."""
    if not evidence.has_following:
        return []
    estimated = evidence.estimated
    index = int(np.argmax(estimated["path_error"]))
    at, size = float(estimated["t"][index]), float(estimated["path_error"][index])
    if size < LARGE:
        return []
    during = [
        each for each in evidence.flight_events if each.begin <= at <= each.end + (each.back_after or RECOVERY) + 1e-9
    ]
    if during:
        cause = during[0].what
    elif estimated["since"][index] < AT_FIRST:
        cause = "the vehicle was that far from the path when following began"
    else:
        push = [estimated.get(f"push_{axis}", np.full(1, np.nan))[index % max(1, len(estimated["t"]))] for axis in NED]
        strength = float(np.linalg.norm(push))
        cause = (
            f"no event; steering then reckoned with a disturbance of {strength:.1f} m/s²"
            if np.isfinite(strength)
            else "no event of the record explains it"
        )
    return [f"The largest path error, {length_in_words(size)}, came at {at:.1f}{NBSP}s: {cause}."]


def _kind(evidence: Evidence) -> str:
    if evidence.lockstep:
        return "simulated, in lockstep"
    return "simulated, in real time" if evidence.simulated else "real-time flight"


def _date(evidence: Evidence) -> str:
    try:
        begun = datetime.fromtimestamp(evidence.resolved["epoch"] + evidence.resolved["begun_at"], UTC)
    except (KeyError, TypeError, ValueError, OverflowError, OSError):
        return "date not recorded"
    return f"{begun.day} {begun:%B %Y, %H:%M} UTC"


def outcome(evidence: Evidence) -> tuple[bool, str]:
    """Whether it was completed, and how it ended in one sentence."""
    duration, distance, laps = (evidence.number("follow", key) for key in ("duration_s", "distance_m", "laps"))
    flown = None
    if duration and distance is not None and laps is not None:
        seconds, metres, count = map(number_text, (duration, distance, laps))
        flown = f"the path for {seconds}{NBSP}s over {metres}{NBSP}m, {count} laps"
    if evidence.figures["outcome"] == "completed":
        return True, f"Completed: followed {flown}." if flown else "Completed, without following the path."
    when = f"after following {flown}" if flown else "before it came to follow the path"
    reason = evidence.figures.get("reason")
    return False, f"Aborted {when}: {reason}." if reason else f"Aborted {when}, for no reason on record."


def notes(evidence: Evidence) -> list[str]:
    """What must not be overlooked: the summary's own notes, and what the folder lacks."""
    said = evidence.figures.get("notes")
    found = [str(note) for note in said] if isinstance(said, list) else []
    found += evidence.cuts
    if evidence.remade:
        found.append(
            f"the folder holds no summary, so its figures were computed from the record, with {SETTLE:g} s to settle"
        )
    if evidence.has_following and evidence.settled_from is None:
        found.append("the flight ended before it counted as settled, so there are no settled figures")
    return [note[:1].upper() + note[1:] + ("" if note.endswith(".") else ".") for note in found]


LEAST = 1e-4
"""What is smaller than this in the unit shown is said to be so."""
NOTHING = "–"
_DIGITS = ((0.1, 4), (1.0, 3), (100.0, 2), (1000.0, 1))
"""Decimals below a value."""


def escaped(text: object) -> str:
    """Text from a file, harmless in HTML."""
    return html.escape(str(text), quote=True)


def number_text(value: float) -> str:
    """Three or four figures, no exponent: 0.0242, 3.00, 66.44, 1234."""
    size = abs(value)
    if size == 0.0:
        return "0"
    if size < LEAST:
        return f"< {LEAST:.4f}" if value > 0.0 else f"> −{LEAST:.4f}"
    digits = next((digits for below, digits in _DIGITS if size < below), 0)
    text = f"{value:.{digits}f}"
    return text.replace("-", "−")


def data_element(value: float | None, factor: float = 1.0) -> str:
    """A figure of the summary in a page: words for people, the summary's own number for programs."""
    if value is None:
        return NOTHING
    return f'<data value="{value!r}">{escaped(number_text(factor * value))}</data>'


class Line(NamedTuple):
    """A line of the table: its name, its unit, the summary's keys, the factor to the unit, whether it is a range."""

    name: str
    unit: str
    keys: tuple[str, ...]
    factor: float = 1.0
    between: tuple[str, str] | None = None


LINES = (
    Line("Duration", "s", ("duration_s",)),
    Line("Distance along the path", "m", ("distance_m",)),
    Line("Laps", "", ("laps",)),
    Line("Mean speed over the mission’s", "%", ("speed_mean_over_alpha",), 100.0),
    Line("Path error (G1), rms", "cm", ("path_error_m", "rms"), 100.0),
    Line("Path error (G1), largest", "cm", ("path_error_m", "max"), 100.0),
    Line("Speed error (G2), rms", "m/s", ("speed_error_mps", "rms")),
    Line("Speed error (G2), largest", "m/s", ("speed_error_mps", "max")),
    Line("Yaw error (G3), rms", "deg", ("yaw_error_deg", "rms")),
    Line("Yaw error (G3), largest", "deg", ("yaw_error_deg", "max")),
    Line("Roll, largest", "deg", ("roll_max_deg",)),
    Line("Pitch, largest", "deg", ("pitch_max_deg",)),
    Line("Tilt, largest", "deg", ("tilt_max_deg",)),
    Line("Thrust", "N", ("thrust_n",), between=("min", "max")),
    Line("Motor commands, of their range", "%", ("motor",), 100.0, between=("min", "max")),
    Line("Time at a limit", "%", ("motor", "saturated_fraction"), 100.0),
)


def table(evidence: Evidence) -> str:
    """The figures of the summary: while following, settled, and settled by the plant's true state."""
    columns: list[tuple[str, tuple[str, ...]]] = [("Following", ("follow",)), ("Settled", ("settled",))]
    if "truth" in evidence.figures:
        columns.append(("Settled, true", ("truth", "settled")))
    head = "".join(f'<th scope="col">{name}</th>' for name, _ in columns)
    body = []
    for line in LINES:
        cells = [_cell(evidence, (*keys, *line.keys), line) for _, keys in columns]
        if all(cell == NOTHING for cell in cells):
            continue
        body.append(
            f'<tr><th scope="row">{line.name}</th><td class="unit">{line.unit}</td>'
            + "".join(f"<td>{cell}</td>" for cell in cells)
            + "</tr>"
        )
    return (
        f'<table><thead><tr><th scope="col">Figure</th><th scope="col" class="unit">Unit</th>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table>"
    )


def _cell(evidence: Evidence, keys: tuple[str, ...], line: Line) -> str:
    if line.between is None:
        return data_element(evidence.number(*keys), line.factor)
    low, high = (evidence.number(*keys, end) for end in line.between)
    if low is None and high is None:
        return NOTHING
    return f"{data_element(low, line.factor)} to {data_element(high, line.factor)}"


UNKNOWN = "#aab6c1"


def timeline(evidence: Evidence) -> str:
    """The strip, a scale under it, and the phases by name; a sentence where there were none."""
    spans = list(_spans(evidence.figures.get("phases")))
    if not spans:
        return "<p>The record holds no tick, so there are no phases to show.</p>"
    total = spans[-1][2]
    # in per mille of the flight: growths that sum to less than 1 would leave the strip unfilled
    bars = "".join(
        f'<span style="flex-grow:{1e3 * (end - begin) / total:.1f};background:{PHASES.get(name, UNKNOWN)}"></span>'
        for name, begin, end in spans
        if end > begin and total > 0.0
    )
    items = "".join(
        f'<li><i style="background:{PHASES.get(name, UNKNOWN)}"></i>{escaped(name)} '
        f"<span>{_when(begin, end)}</span></li>"
        for name, begin, end in spans
    )
    return (
        f'<div class="strip" role="img" aria-label="phases of the flight over time">{bars}</div>'
        f'<div class="scale"><span>0 s</span><span>{number_text(total)} s</span></div><ol class="phases">{items}</ol>'
    )


def _when(begin: float, end: float) -> str:
    return f"{number_text(end - begin)} s" if end > begin else f"at {number_text(begin)} s"


def _spans(phases: Any) -> list[tuple[str, float, float]]:
    spans = []
    for phase in phases if isinstance(phases, list) else []:
        try:
            spans.append((str(phase["phase"]), float(phase["from_s"]), float(phase["to_s"])))
        except (KeyError, TypeError, ValueError):
            continue
    return spans
