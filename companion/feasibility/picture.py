"""The report as a picture: the path coloured by the tightest limit, and what is asked along it. Needs matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from companion.feasibility.limits import Quantity, quantities
from companion.feasibility.report import Report
from companion.feasibility.words import LABELS, against, headline

Array = NDArray[np.float64]

INK, FAINT, RULE, BAD = "#1c2733", "#5d6b78", "#dde3e8", "#b3001b"
FULL = 1.25
"""The share of a limit at which the colours end; they turn red at 1."""
COLOURS = LinearSegmentedColormap.from_list(
    "used", [(0.0, "#4f9bd9"), (0.48, "#2e9e6b"), (0.72, "#f0b429"), (0.79, "#e8622c"), (0.8, BAD), (1.0, "#5c0010")]
)
LINES = {
    "thrust_n": "#0072b2",
    "tilt_deg": "#d55e00",
    "motor": "#b0578d",
    "body_rate_dps": "#009e73",
    "yaw_rate_dps": "#e69f00",
    "speed_mps": INK,
}


def picture(report: Report) -> Figure:
    """From above, height and speed and the share of every limit over the distance along the path."""
    figure = Figure(figsize=(12.0, 7.2), dpi=130, layout="constrained")
    figure.suptitle(_folded(headline(report), 100), x=0.012, ha="left", fontsize=12, color=INK)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1.0), height_ratios=(1.0, 1.0, 1.7))
    above = figure.add_subplot(grid[:, 0])
    height, speed, used = (figure.add_subplot(grid[i, 1]) for i in range(3))
    found = quantities(report.asked, report.vehicle)
    tightest = np.max([q.used for q in found], axis=0)
    colours = _above(report, above, np.clip(tightest, 0.0, FULL))
    bar = figure.colorbar(colours, ax=above, location="bottom", shrink=0.7, aspect=40, pad=0.02)
    bar.set_label("share of the tightest limit that is used", color=FAINT, fontsize=9)
    bar.ax.xaxis.set_major_formatter(lambda share, _: f"{100.0 * share:.0f} %")
    s = report.at.s
    height.plot(s, report.ground - report.at.path[0, 2], color=INK, linewidth=1.4)
    height.set_ylabel("height, m")
    low, high = height.get_ylim()
    if high - low < 2.0:
        height.set_ylim(0.5 * (low + high) - 1.0, 0.5 * (low + high) + 1.0)
    speed.plot(s, np.abs(report.at.alpha[0]), color=INK, linewidth=1.4)
    speed.set_ylabel("speed, m/s")
    speed.set_ylim(0.0, 1.15 * float(np.max(np.abs(report.at.alpha[0]))))
    _shares(report, used, found)
    for axes in (height, speed, used):
        axes.set_xlim(0.0, report.length)
        axes.grid(True, color=RULE, linewidth=0.8)
        axes.axvline(report.tightest.at_s, color=FAINT, linewidth=0.9, linestyle=":")
    for axes in (above, height, speed, used):
        axes.tick_params(labelsize=8, colors=FAINT)
        axes.xaxis.label.set(color=FAINT, fontsize=9)
        axes.yaxis.label.set(color=FAINT, fontsize=9)
        for spine in axes.spines.values():
            spine.set_color(RULE)
    for axes in (height, speed):
        axes.tick_params(labelbottom=False)
    used.set_xlabel("distance along the path, m")
    return figure


def _above(report: Report, axes: Any, tightest: Array) -> LineCollection:
    """The path seen from above, north up."""
    north, east, _ = report.at.path[0]
    points = np.stack([east, north], axis=1)
    segments = np.stack([points[:-1], points[1:]], axis=1)
    lines = LineCollection(list(segments), cmap=COLOURS, norm=Normalize(0.0, FULL), linewidth=3.6, capstyle="round")
    lines.set_array(np.maximum(tightest[:-1], tightest[1:]))
    axes.add_collection(lines)
    axes.autoscale_view()
    size = max(float(np.ptp(east)), float(np.ptp(north)), 1.0)
    direction = 1.0 if report.at.alpha[0, 0] > 0.0 else -1.0
    for share in (0.03, 0.36, 0.69):
        i = int(share * (len(north) - 1))
        ahead = direction * report.at.path[1, :2, i]
        length = float(np.hypot(*ahead))
        if length < 0.1:  # it climbs or sinks
            continue
        step = 0.02 * size * ahead / length
        axes.annotate(
            "",
            xy=(east[i] + step[1], north[i] + step[0]),
            xytext=(east[i] - step[1], north[i] - step[0]),
            arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.6, "mutation_scale": 17},
        )
    begin = 0 if direction > 0.0 else -1
    axes.plot(east[begin], north[begin], "o", color="white", markeredgecolor=INK, markersize=8, zorder=5)
    words: dict[str, Any] = {"textcoords": "offset points", "color": INK, "fontsize": 9}
    axes.annotate("start", (east[begin], north[begin]), xytext=(9, 9), **words)
    tight = report.tightest
    x, y, _ = report.mission.table.at(tight.at_s)[0]
    axes.plot(y, x, "x", color=INK, markersize=10, markeredgewidth=2.2, zorder=6)
    inward = -1.0 if y > float(np.mean(east)) else 1.0
    label = axes.annotate(
        against(tight), (y, x), xytext=(14.0 * inward, -16.0), **words, zorder=7,
        ha="left" if inward > 0.0 else "right", bbox={"boxstyle": "round,pad=0.25", "fc": "white", "ec": RULE},
    )  # fmt: skip
    label.set_in_layout(False)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.grid(True, color=RULE, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    return lines


def _shares(report: Report, axes: Any, found: list[Quantity]) -> None:
    """How much of each limit is used along the path; of several motors or axes the one that uses most."""
    most: dict[str, Array] = {}
    for q in found:
        if q.name in LINES and np.isfinite([q.low, q.high]).any():
            shares = np.clip(q.used, 0.0, 9.99)
            most[q.name] = np.maximum(most[q.name], shares) if q.name in most else shares
    for name, shares in most.items():
        if float(shares.max()) > 0.02:
            axes.plot(report.at.s, 100.0 * shares, color=LINES[name], linewidth=1.4, label=LABELS[name][0])
    top = max((float(shares.max()) for shares in most.values()), default=0.0)
    axes.axhline(100.0, color=BAD, linewidth=1.3)
    axes.set_ylim(0.0, min(100.0 * max(1.15, 1.1 * top), 400.0))
    axes.set_ylabel("% of the limit")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=6, fontsize=8, frameon=False, columnspacing=1.2)


def _folded(text: str, width: int) -> str:
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + len(word) >= width:
            lines.append(line)
            line = ""
        line = f"{line} {word}".strip()
    return "\n".join([*lines, line])
