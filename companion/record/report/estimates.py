"""What steering found out about its vehicle: scale of the thrust, drag, disturbance, delays; and its pace."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.record.report.evidence import Array, Evidence, Series
from companion.record.report.palette import BLUE, FAINT, GREEN, VERMILION
from companion.record.report.style import along_x, legend, named, spanned, stacked
from companion.record.report.tracks import kept

FILE = (0, (2, 2))
"""The dots of what the vehicle file says, in line widths."""
HEIGHT = 3.6
"""inches."""
TIME = "time since following began, s"


def known(evidence: Evidence) -> bool:
    """Whether the level that was flown estimates anything, and the record holds it."""
    return "thrust_scale" in evidence.estimated and bool(np.isfinite(evidence.estimated["thrust_scale"]).any())


def machine(evidence: Evidence) -> Figure:
    """Of the vehicle itself, over the time of following; dotted what its file says."""
    figure, (scale, drag) = stacked([1.0, 1.0], HEIGHT)
    estimated, vehicle = evidence.estimated, evidence.plan.vehicle
    _one(scale, estimated, "thrust_scale", 1.0, "Thrust made over thrust asked for", 0.04)
    _one(drag, estimated, "drag", vehicle.drag, "Drag, 1/s", 0.05)
    along_x(drag, TIME, 0.0, _end(estimated))
    return figure


def surroundings(evidence: Evidence) -> Figure:
    """What else pushes it, and how late everything comes."""
    figure, (disturbance, delay) = stacked([1.0, 1.0], HEIGHT)
    estimated, lag = evidence.estimated, 1e3 * evidence.plan.vehicle.rate_loop_lag
    lines = []
    for name, colour in (("north", BLUE), ("east", VERMILION), ("down", GREEN)):
        lines.append(estimated[f"push_{name}"])
        _line(disturbance, estimated["t"], lines[-1], colour, name)
    named(disturbance, "Disturbance, m/s²")
    legend(disturbance)
    spanned(disturbance, *_ends(lines), 0.2)
    lines = [np.array([lag])]
    for column, name, colour in (("delay", "state to effect", BLUE), ("rate_lag", "rate loop", VERMILION)):
        lines.append(1e3 * estimated[column])
        _line(delay, estimated["t"], lines[-1], colour, name)
    delay.axhline(lag, color=FAINT, linewidth=0.8, linestyle=FILE)
    named(delay, "Delays, ms")
    legend(delay)
    spanned(delay, *_ends(lines), 10.0)
    along_x(delay, TIME, 0.0, _end(estimated))
    return figure


def _end(estimated: Series) -> float:
    return max(float(estimated["t"][-1]), 1e-3)


def _one(panel: Axes, estimated: Series, column: str, file: float, name: str, least: float) -> None:
    values = estimated[column]
    _line(panel, estimated["t"], values, BLUE, "estimated")
    panel.axhline(file, color=FAINT, linewidth=0.8, linestyle=FILE, label="vehicle file")
    named(panel, name)
    legend(panel)
    spanned(panel, *_ends([values, np.array([file])]), least)


def _line(panel: Axes, t: Array, y: Array, colour: str, label: str) -> None:
    chosen = kept(y)
    panel.plot(t[chosen], y[chosen], color=colour, linewidth=1.2, label=label)


def _ends(curves: list[Array]) -> tuple[float, float]:
    values = np.concatenate(curves)
    values = values[np.isfinite(values)]
    return (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 0.0)
