"""The loop: how steadily setpoints went out, and how long each took to make."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from companion.record.report.evidence import Array, Evidence
from companion.record.report.palette import BLUE, FAINT, VERMILION
from companion.record.report.style import WIDTH, named, plain
from companion.record.series import FOLLOW

STEADY = 1e-6
"""s; gaps that differ by less are all the same."""


def gaps(evidence: Evidence) -> Array:
    """s between one setpoint and the next while following."""
    table = evidence.table
    sent = table[(table["phase"] == FOLLOW) & (table["setpoint"] > 0)]
    between: Array = np.diff(np.asarray(sent["now"], dtype=float))
    return between


def latencies(evidence: Evidence) -> Array:
    """s from the arrival of a state to the return of its setpoint's send, while following."""
    table = evidence.table
    values = np.asarray(table[(table["phase"] == FOLLOW) & (table["setpoint"] > 0)]["latency"], dtype=float)
    known: Array = values[np.isfinite(values)]
    return known


def histogram(values: Array, name: str, unit: str) -> Figure:
    """How often each value came, the counts on a logarithmic axis so that the rare late one is seen."""
    figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
    panel = figure.add_subplot()
    top = float(np.max(values)) * 1.03
    bins = np.linspace(0.0, top, 81)
    counts, _ = np.histogram(values, bins)
    panel.bar(bins[:-1], counts, width=np.diff(bins), align="edge", color=BLUE, linewidth=0)
    panel.set_yscale("log")
    panel.set_ylim(0.7, float(np.max(counts)) * 4.0)
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    panel.yaxis.minorticks_off()
    panel.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    panel.grid(axis="x", visible=False)
    panel.set_xlim(0.0, top)
    panel.set_xlabel(f"{name}, {unit}")
    named(panel, "Setpoints")
    half, most = float(np.percentile(values, 50)), float(np.percentile(values, 99))
    _quantile(panel, half, "half", FAINT, left=half > 0.1 * top)
    _quantile(panel, most, "99 %", VERMILION, left=most > 0.9 * top and most - half > 0.2 * top)
    return figure


def _quantile(panel: Axes, value: float, word: str, colour: str, left: bool) -> None:
    panel.axvline(value, color=colour, linewidth=0.9, linestyle=(0, (2, 2)))
    panel.annotate(
        word,
        (value, 1.0),
        xytext=(-3 if left else 3, -2),
        ha="right" if left else "left",
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        va="top",
        fontsize=8,
        color=colour,
    )
