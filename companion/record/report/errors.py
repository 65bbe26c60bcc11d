"""The paper's three goals: the errors of G1 (path), G2 (speed), G3 (yaw) over time and over the way along the path."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.record.report.curves import DASHED, DOTTED, draw_curve, label_time, points_to_draw
from companion.record.report.evidence import Array, Evidence, Series
from companion.record.report.marks import shade
from companion.record.report.palette import BLUE, FAINT, INK, TRUE
from companion.record.report.style import (
    decades,
    figure_legend,
    legend,
    name_x,
    name_y,
    ramp_of_colours,
    span_y,
    span_y_from_zero,
    stack_panels,
)  # fmt: skip
from companion.record.report.text import number_text

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
    figure, panels = stack_panels([1.0, 1.0, 1.0], 5.9)
    estimated, true, settled = evidence.estimated, evidence.true, evidence.settled_from
    shade(panels, evidence, 0.0, evidence.following_s)
    for panel, goal in zip(panels, GOALS, strict=True):
        error = goal.factor * estimated[goal.column]
        late = error if settled is None else error[estimated["since"] >= settled]
        rest = float(np.sqrt(np.mean(late**2)))
        logarithmic = bool(np.max(np.abs(error)) > DECADES_APART * max(rest, goal.floor))
        if true is not None:
            _draw_error(panel, true["t"], goal.factor * true[goal.column], logarithmic, TRUE, 3.4, "true")
        _draw_error(panel, estimated["t"], error, logarithmic, BLUE, 1.1, "as estimated" if true is not None else None)
        if logarithmic:
            decades(panel, max(goal.floor, 0.3 * rest), float(np.max(np.abs(error))))
        else:
            both = [error] if true is None else [error, goal.factor * true[goal.column]]
            _set_linear(panel, goal, np.concatenate(both))
        name_y(panel, f"{goal.name}, {goal.unit}")
        if settled is not None:
            panel.axvline(settled, color=FAINT, linewidth=0.8, linestyle=DOTTED)
            rms, top = (evidence.number("settled", goal.key, kind) for kind in ("rms", "max"))
            if rms is not None and top is not None:
                rms_text, top_text = (number_text(goal.key_factor * value) for value in (rms, top))
                text = f"settled: rms {rms_text}, largest {top_text}"
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
    label_time(panels[-1], 0.0, evidence.following_s)
    figure_legend(figure, panels[0])
    return figure


def speed_and_heading(evidence: Evidence) -> Figure:
    """Speed and heading themselves, beside what the mission asks for at the same place."""
    figure, (speed, yaw) = stack_panels([1.0, 1.0], 4.2)
    estimated, true = evidence.estimated, evidence.true
    shade([speed, yaw], evidence, 0.0, evidence.following_s)
    heading = np.degrees(np.unwrap(estimated["yaw"]))
    # what is asked for runs beside what is flown, not a turn away from it
    asked = heading - np.degrees(estimated["yaw_error"])
    speeds, headings = [estimated["speed"], estimated["alpha"]], [heading, asked]
    if true is not None:
        draw_curve(speed, true["t"], true["speed"], TRUE, "true", 3.4)
        flown = np.interp(true["t"], estimated["t"], asked) + np.degrees(true["yaw_error"])
        draw_curve(yaw, true["t"], flown, TRUE, None, 3.4)
        speeds.append(true["speed"])
        headings.append(flown)
    draw_curve(speed, estimated["t"], estimated["speed"], BLUE, "flown" if true is None else "as estimated", 1.1)
    draw_curve(speed, estimated["t"], estimated["alpha"], INK, "the mission asks for", 0.9, DASHED)
    draw_curve(yaw, estimated["t"], heading, BLUE, None, 1.1)
    draw_curve(yaw, estimated["t"], asked, INK, None, 0.9, DASHED)
    for panel, name, curves, least in (
        (speed, "Speed along the path, m/s", speeds, 0.1),
        (yaw, "Heading, deg clockwise from north", headings, 2.0),
    ):
        name_y(panel, name)
        span_y(panel, min(map(np.min, curves)), max(map(np.max, curves)), least)
    label_time(yaw, 0.0, evidence.following_s)
    figure_legend(figure, speed)
    return figure


def _set_linear(panel: Axes, goal: Goal, values: Array) -> None:
    if goal.column == "path_error":
        span_y_from_zero(panel, float(np.max(values)), goal.span)
    else:
        span_y(panel, float(np.min(values)), float(np.max(values)), goal.span)


def _draw_error(
    panel: Axes, t: Array, error: Array, logarithmic: bool, colour: str, width: float, label: str | None
) -> None:
    # a logarithmic axis has no zero: what is exactly zero lies below every frame
    draw_curve(panel, t, np.maximum(np.abs(error), 1e-12) if logarithmic else error, colour, label, width)


def over_path(evidence: Evidence) -> tuple[Figure, bool]:
    """Where along the path the errors are, lap over lap; and whether the approach leaves the frame."""
    figure, panels = stack_panels([1.0, 1.0, 1.0], 5.6)
    estimated, settled = evidence.estimated, evidence.settled_from
    laps = _laps(evidence, estimated)
    colours = ramp_of_colours("viridis", 0.0, 0.85)
    labelled = {laps[i][0] for i in np.unique(np.linspace(0, len(laps) - 1, min(5, len(laps))).astype(int))}
    most = max(lap for lap, _ in laps)
    leaves = False
    for panel, goal in zip(panels, GOALS, strict=True):
        error = goal.factor * estimated[goal.column]
        for lap, rows in laps:
            chosen = rows[points_to_draw(error[rows], points=1000)]
            share = (lap - 1) / max(1, most - 1)
            x, y = _broken(estimated["s"][chosen], error[chosen], evidence.plan.table.length)
            label = f"lap {lap}" if lap in labelled else None
            panel.plot(x, y, color=colours(share), linewidth=1.1, label=label)
        late = error if settled is None else error[estimated["since"] >= settled]
        _set_linear(panel, goal, late)
        bottom, top = panel.get_ylim()
        leaves = leaves or bool(np.max(error) > top or np.min(error) < bottom)
        name_y(panel, f"{goal.name}, {goal.unit}")
    legend(panels[0], columns=5)
    name_x(panels[-1], "displacement along the path s, m", 0.0, evidence.plan.table.length)
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
