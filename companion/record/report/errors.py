"""The paper's three goals: the errors of G1 (path), G2 (speed), G3 (yaw) over time and over the way along the path."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.record.report.evidence import Array, Evidence, Series
from companion.record.report.marks import shade
from companion.record.report.palette import BLUE, FAINT, INK, TRUE
from companion.record.report.style import (
    along_x,
    decades,
    figure_legend,
    from_zero,
    legend,
    named,
    ramp_of_colours,
    spanned,
    stacked,
)  # fmt: skip
from companion.record.report.text import worded
from companion.record.report.tracks import kept

TIME = "time since following began, s"
DASHES = (0, (3, 1.5))
"""on and off, in line widths."""
DECADES_APART = 100.0
"""From this ratio of the largest error to the settled one a logarithmic axis reads best."""


class Goal(NamedTuple):
    """An error: the table's column and the factor to its unit, the summary's key and the same, the least worth showing
    on a logarithmic axis, and the least span of a linear one."""

    name: str
    unit: str
    column: str
    factor: float
    key: str
    key_factor: float
    floor: float
    span: float


GOALS = (
    Goal("G1  path error", "cm", "path_error", 100.0, "path_error_m", 100.0, 1e-4, 0.1),
    Goal("G2  speed error", "m/s", "speed_error", 1.0, "speed_error_mps", 1.0, 1e-5, 0.02),
    Goal("G3  yaw error", "deg", "yaw_error", math.degrees(1.0), "yaw_error_deg", 1.0, 1e-4, 0.1),
)


def over_time(evidence: Evidence) -> Figure:
    """How fast the errors go away, and what stays."""
    figure, panels = stacked([1.0, 1.0, 1.0], 5.9)
    estimated, true, settled = evidence.estimated, evidence.true, evidence.settled_from
    shade(panels, evidence, 0.0, float(estimated["t"][-1]))
    for panel, goal in zip(panels, GOALS, strict=True):
        seen = goal.factor * estimated[goal.column]
        late = seen if settled is None else seen[estimated["since"] >= settled]
        rest = float(np.sqrt(np.mean(late**2)))
        logarithmic = bool(np.max(np.abs(seen)) > DECADES_APART * max(rest, goal.floor))
        if true is not None:
            _line(panel, true["t"], goal.factor * true[goal.column], logarithmic, TRUE, 3.4, "true")
        _line(panel, estimated["t"], seen, logarithmic, BLUE, 1.1, "as estimated" if true is not None else None)
        if logarithmic:
            decades(panel, max(goal.floor, 0.3 * rest), float(np.max(np.abs(seen))))
        else:
            _linear(panel, goal, seen if true is None else np.concatenate([seen, goal.factor * true[goal.column]]))
        named(panel, f"{goal.name}, {goal.unit}")
        if settled is not None:
            panel.axvline(settled, color=FAINT, linewidth=0.8, linestyle=(0, (2, 2)))
            rms, top = (evidence.number("settled", goal.key, kind) for kind in ("rms", "max"))
            if rms is not None and top is not None:
                text = f"settled: rms {worded(goal.key_factor * rms)}, largest {worded(goal.key_factor * top)}"
                panel.set_title(text, loc="right", pad=4, fontsize=8, color=FAINT)
    if settled is not None:
        panels[0].annotate(
            f"settled from {settled:g} s",
            (settled, 1.0),
            xytext=(4, -14),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            va="top",
            fontsize=8,
            color=FAINT,
        )
    along_x(panels[-1], TIME, 0.0, max(float(estimated["t"][-1]), 1e-3))
    figure_legend(figure, panels[0])
    return figure


def themselves(evidence: Evidence) -> Figure:
    """Speed and heading themselves, beside what the mission asks for at the same place."""
    figure, (speed, yaw) = stacked([1.0, 1.0], 4.2)
    estimated, true = evidence.estimated, evidence.true
    shade([speed, yaw], evidence, 0.0, float(estimated["t"][-1]))
    heading = np.degrees(np.unwrap(estimated["yaw"]))
    # what is asked for runs beside what is flown, not a turn away from it
    asked = heading - np.degrees(estimated["yaw_error"])
    speeds, headings = [estimated["speed"], estimated["alpha"]], [heading, asked]
    if true is not None:
        _line(speed, true["t"], true["speed"], False, TRUE, 3.4, "true")
        flown = np.interp(true["t"], estimated["t"], asked) + np.degrees(true["yaw_error"])
        _line(yaw, true["t"], flown, False, TRUE, 3.4, None)
        speeds.append(true["speed"])
        headings.append(flown)
    _line(speed, estimated["t"], estimated["speed"], False, BLUE, 1.1, "flown" if true is None else "as estimated")
    _line(speed, estimated["t"], estimated["alpha"], False, INK, 0.9, "the mission asks for", DASHES)
    _line(yaw, estimated["t"], heading, False, BLUE, 1.1, None)
    _line(yaw, estimated["t"], asked, False, INK, 0.9, None, DASHES)
    for panel, name, curves, least in (
        (speed, "Speed along the path, m/s", speeds, 0.1),
        (yaw, "Heading, deg clockwise from north", headings, 2.0),
    ):
        named(panel, name)
        spanned(panel, min(map(np.min, curves)), max(map(np.max, curves)), least)
    along_x(yaw, TIME, 0.0, max(float(estimated["t"][-1]), 1e-3))
    figure_legend(figure, speed)
    return figure


def _linear(panel: Axes, goal: Goal, values: Array) -> None:
    if goal.column == "path_error":
        from_zero(panel, float(np.max(values)), goal.span)
    else:
        spanned(panel, float(np.min(values)), float(np.max(values)), goal.span)


def _line(
    panel: Axes, x: Array, y: Array, logarithmic: bool, colour: str, width: float, label: str | None,
    style: str | tuple[int, tuple[float, float]] = "-",
) -> None:  # fmt: skip
    # a logarithmic axis has no zero: what is exactly zero lies below every frame
    y = np.maximum(np.abs(y), 1e-12) if logarithmic else y
    chosen = kept(np.log(y) if logarithmic else y)
    panel.plot(x[chosen], y[chosen], color=colour, linewidth=width, label=label, linestyle=style)


def over_path(evidence: Evidence) -> tuple[Figure, bool]:
    """Where along the path the errors are, lap over lap; and whether the approach leaves the frame."""
    figure, panels = stacked([1.0, 1.0, 1.0], 5.6)
    estimated, settled = evidence.estimated, evidence.settled_from
    laps = _laps(evidence, estimated)
    colours = ramp_of_colours("viridis", 0.0, 0.85)
    labelled = {laps[i][0] for i in np.unique(np.linspace(0, len(laps) - 1, min(5, len(laps))).astype(int))}
    most = max(lap for lap, _ in laps)
    leaves = False
    for panel, goal in zip(panels, GOALS, strict=True):
        error = goal.factor * estimated[goal.column]
        for lap, rows in laps:
            chosen = rows[kept(error[rows], points=1000)]
            share = (lap - 1) / max(1, most - 1)
            x, y = _broken(estimated["s"][chosen], error[chosen], evidence.plan.table.length)
            label = f"lap {lap}" if lap in labelled else None
            panel.plot(x, y, color=colours(share), linewidth=1.1, label=label)
        late = error if settled is None else error[estimated["since"] >= settled]
        _linear(panel, goal, late)
        bottom, top = panel.get_ylim()
        leaves = leaves or bool(np.max(error) > top or np.min(error) < bottom)
        named(panel, f"{goal.name}, {goal.unit}")
    legend(panels[0], columns=5)
    along_x(panels[-1], "displacement along the path s, m", 0.0, evidence.plan.table.length)
    return figure, leaves


def _laps(evidence: Evidence, estimated: Series) -> list[tuple[int, np.ndarray]]:
    """(number of the lap, its rows)."""
    lap = np.floor(
        np.maximum(estimated["travelled"] - estimated["travelled"][0], 0.0) / evidence.plan.table.length
    ).astype(int)
    return [(int(number) + 1, np.flatnonzero(lap == number)) for number in np.unique(lap)]


def _broken(s: Array, error: Array, length: float) -> tuple[Array, Array]:
    """A curve over s that does not run back across the page where s begins again."""
    jumps = np.flatnonzero(np.abs(np.diff(s)) > 0.5 * length) + 1
    return np.insert(s, jumps, np.nan), np.insert(error, jumps, np.nan)
