"""The path and the track from above."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from companion.record.report import places
from companion.record.report.colouring import colour_bar, runs
from companion.record.report.evidence import Array, Evidence
from companion.record.report.palette import FAINT, INK, ROAD, TRUE
from companion.record.report.style import WIDTH, plain, ramp_of_colours
from companion.record.report.thinning import along


def from_above(evidence: Evidence) -> Figure:
    """North up, east right, one metre as long in both; coloured by speed."""
    figure = Figure(figsize=(WIDTH, WIDTH * 1.04), layout="constrained")
    axes = figure.add_subplot()
    flown, before_and_after = places.tracks(evidence)
    road = places.road(evidence)
    axes.plot(road[:, 0], road[:, 1], color=ROAD, linewidth=6, zorder=1)
    if before_and_after is not None:
        axes.plot(before_and_after[:, 0], before_and_after[:, 1], color=FAINT, linewidth=0.8, zorder=2)
    true = places.true_track(evidence, flown)
    if true is not None:
        axes.plot(true[:, 0], true[:, 1], color=TRUE, linewidth=3, zorder=2)
    if flown is not None:
        axes.update_datalim(flown[:, :2])
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axes.margins(0.09)
    if flown is not None:
        told = evidence.told
        speed = np.sqrt(told["v_north"] ** 2 + told["v_east"] ** 2 + told["v_down"] ** 2)
        chosen = along(flown)
        norm = Normalize(0.0, max(float(np.max(speed)), 0.1))
        colours = ramp_of_colours("viridis", 0.0, 0.9)
        pieces, levels = runs(flown[chosen, :2], speed[chosen], norm)
        axes.add_collection(LineCollection(pieces, colors=colours(levels), linewidths=1.8, zorder=3), autolim=False)
        colour_bar(figure, norm, colours, "speed, m/s", beside=axes)
        marks = [(flown[0], "start", "o"), (flown[-1], "end", "s")]
        apart = float(np.linalg.norm((flown[-1] - flown[0])[:2]))
        drawn = np.concatenate([part for part in (road, flown[chosen], before_and_after) if part is not None])
        _marked(axes, drawn, marks if apart > 0.04 * float(np.max(np.ptp(road, axis=0))) else marks[:1])
    elif before_and_after is not None:
        _marked(axes, road, [(before_and_after[-1], "vehicle", "s")])
    _direction(axes, evidence)
    return figure


def _marked(axes: Axes, drawn: Array, marks: list[tuple[Array, str, str]]) -> None:
    """Mark places of the flight, each word where most room is left by the curves through ``drawn``."""
    drawn = drawn[np.isfinite(drawn[:, 0]), :2]
    reach = 0.06 * float(np.max(np.ptp(drawn, axis=0)))
    for point, word, shape in marks:
        axes.plot(point[0], point[1], shape, markersize=5.5, markerfacecolor="white", markeredgecolor=INK, zorder=6)
        x, y = max(_SIDES, key=lambda side: _room(drawn, point[:2], side, reach))
        axes.annotate(
            word,
            (float(point[0]), float(point[1])),
            xytext=(8.0 * x, 8.0 * y),
            textcoords="offset points",
            ha="center" if x == 0.0 else "left" if x > 0.0 else "right",
            va="center" if y == 0.0 else "bottom" if y > 0.0 else "top",
            zorder=6,
        )


_SIDES = ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.7, 0.7), (0.7, -0.7), (-0.7, -0.7), (-0.7, 0.7))


def _room(drawn: Array, point: Array, side: tuple[float, float], reach: float) -> float:
    """m from where the middle of a word would be to the nearest curve; words are wider than high."""
    middle = point + reach * np.array([1.6 * side[0], side[1]])
    return float(np.min(np.linalg.norm(drawn - middle, axis=1)))


def _direction(axes: Axes, evidence: Evidence) -> None:
    """Arrowheads along the path in the direction of flight."""
    table, direction = evidence.plan.table, evidence.plan.direction
    begin = float(evidence.told["s"][0]) if evidence.followed else 0.0
    for share in (0.3, 0.8):
        (north, east, _), (tn, te, _), _ = table.at(begin + direction * share * table.length)
        step = 1e-3 * table.length * direction
        axes.annotate(
            "",
            (east + te * step, north + tn * step),
            (east, north),
            arrowprops={"arrowstyle": "-|>,head_length=0.6,head_width=0.28", "color": INK, "shrinkA": 0, "shrinkB": 0},
            zorder=5,
        )
