"""One hand for every figure: small type, thin lines, no boxes, a unit on every axis."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from companion.record.report.palette import FAINT, INK, RULE

WIDTH = 5.2
"""inches: half a page on a desk and a whole one on a phone, readable in both."""
STEPS = 24
"""of a ramp of colours: enough for the eye, and few enough for lines of one colour to stay whole."""

_RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    # the font whose widths the layout is made with; the page sets the same words in its own, which is no wider
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.5,
    "legend.fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.size": 2.5,
    "ytick.major.size": 0,
    "xtick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "svg.fonttype": "none",
    "svg.hashsalt": "companion",
    "path.simplify": True,
}


@contextmanager
def drawing() -> Iterator[None]:
    """What is drawn inside is drawn in this style, whatever the user's own matplotlibrc says."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_RC)
        yield


def stack_panels(heights: list[float], height: float) -> tuple[Figure, list[Axes]]:
    """A figure of panels over one another with a common x axis."""
    layout = ConstrainedLayoutEngine(h_pad=0.03, w_pad=0.03, hspace=0.02)
    figure = Figure(figsize=(WIDTH, height), layout=layout)
    grid = figure.subplots(len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights})
    panels = list(grid[:, 0])
    for panel in panels[:-1]:
        panel.tick_params(axis="x", length=0)
    return figure, panels


def name_x(panel: Axes, name: str, begin: float, end: float) -> None:
    """The x axis: its name with its unit, and where it runs."""
    panel.set_xlabel(name)
    # a hair more, so that a flight of 59.996 s shows the tick at 60
    panel.set_xlim(begin, end + 1e-3 * (end - begin))
    panel.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))


def name_y(panel: Axes, name: str) -> None:
    """Name the y axis, with its unit, above it: read without turning one's head."""
    panel.set_title(name, loc="left", pad=4, fontweight="bold")


def legend(panel: Axes, columns: int = 4) -> None:
    """What the lines are, on the line of the name: never over the data."""
    handles, labels = panel.get_legend_handles_labels()
    if labels:
        panel.legend(
            handles,
            labels,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=columns,
            borderpad=0.0,
            borderaxespad=0.4,
            handlelength=1.4,
            handletextpad=0.4,
            columnspacing=1.1,
        )


def figure_legend(figure: Figure, panel: Axes) -> None:
    """What the lines of every panel are, in a row over the figure, where a panel's own line is taken by its figures."""
    handles, labels = panel.get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper right", ncols=4, handlelength=1.4, handletextpad=0.4)


def plain(value: float) -> str:
    """A tick's number without exponent."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text.replace("-", "−")


def ticks(panel: Axes, count: int = 4) -> None:
    """At most ``count`` intervals on a linear y axis."""
    panel.yaxis.set_major_locator(MaxNLocator(count, steps=[1, 2, 2.5, 5, 10]))
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))


def decades(panel: Axes, low: float, high: float) -> None:
    """A logarithmic y axis over whole decades from about ``low`` to ``high``, at most five of them labelled."""
    first, last = int(np.floor(np.log10(low) + 1e-9)), int(np.ceil(np.log10(high) - 1e-9))
    last = max(last, first + 1)
    panel.set_yscale("log")
    panel.set_ylim(10.0**first, 10.0**last)
    step = -(-(last - first) // 5)
    panel.yaxis.set_major_locator(FixedLocator([10.0**k for k in range(last, first - 1, -step)]))
    panel.yaxis.set_minor_locator(NullLocator())
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))


def span_y(panel: Axes, low: float, high: float, least: float) -> None:
    """A linear y axis that shows ``low`` to ``high`` with room to spare, and never less than ``least``: noise that does
    not matter must not fill the page."""
    middle, half = 0.5 * (low + high), 0.5 * max(high - low, least) * 1.08
    panel.set_ylim(middle - half, middle + half)
    ticks(panel)


def span_y_from_zero(panel: Axes, high: float, least: float) -> None:
    """The same for what is never negative."""
    top = 1.04 * max(high, least)
    panel.set_ylim(-0.02 * top, top)
    ticks(panel)


def ramp_of_colours(name: str, begin: float, end: float) -> Colormap:
    """A part of one of matplotlib's even colour ramps, without the ends that vanish on white."""
    return ListedColormap(matplotlib.colormaps[name](np.linspace(begin, end, STEPS)))
