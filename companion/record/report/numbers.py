"""A number as a reader wants it, and the table of the figures that matter."""

from __future__ import annotations

import html
from typing import NamedTuple

from companion.record.report.evidence import Evidence

LEAST = 1e-4
"""What is smaller than this in the unit shown is said to be so."""
NOTHING = "–"
_DIGITS = ((0.1, 4), (1.0, 3), (100.0, 2), (1000.0, 1))


def escaped(text: object) -> str:
    """Text from a file, harmless in HTML."""
    return html.escape(str(text), quote=True)


def worded(value: float) -> str:
    """Three or four figures, no exponent: 0.0242, 3.00, 66.44, 1234."""
    size = abs(value)
    if size == 0.0:
        return "0"
    if size < LEAST:
        return f"< {LEAST:.4f}" if value > 0.0 else f"> −{LEAST:.4f}"
    digits = next((digits for below, digits in _DIGITS if size < below), 0)
    text = f"{value:.{digits}f}"
    return text.replace("-", "−")


def shown(value: float | None, factor: float = 1.0) -> str:
    """A figure of the summary in a page: words for people, the summary's own number for programs."""
    if value is None:
        return NOTHING
    return f'<data value="{value!r}">{escaped(worded(factor * value))}</data>'


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
        return shown(evidence.number(*keys), line.factor)
    low, high = (evidence.number(*keys, end) for end in line.between)
    if low is None and high is None:
        return NOTHING
    return f"{shown(low, line.factor)} to {shown(high, line.factor)}"
