"""The path and the track in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from companion.record.report import places
from companion.record.report.colouring import colour_bar, runs
from companion.record.report.evidence import Array, Evidence
from companion.record.report.palette import FAINT, INK, ROAD, RULE
from companion.record.report.style import WIDTH, plain, ramp_of_colours
from companion.record.report.thinning import along

LEAST_ERROR = 0.01
"""cm; the colours of the path error do not resolve less."""


def in_space(evidence: Evidence) -> Figure:
    """With its height; coloured by the distance to the path."""
    figure = Figure(figsize=(WIDTH, WIDTH * 1.04))
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection=Axes3D.name, computed_zorder=False)
    flown, before_and_after = places.tracks(evidence)
    road = places.road(evidence)
    everything = np.concatenate([part for part in (road, flown, before_and_after) if part is not None])
    everything = everything[np.isfinite(everything).all(axis=1)]
    low, high = _box(everything)
    floor = low[2]
    axes.plot(road[:, 0], road[:, 1], np.full(len(road), floor), color=RULE, linewidth=1.5, zorder=1)
    axes.plot(*road.T, color=ROAD, linewidth=5, zorder=2)
    if before_and_after is not None:
        axes.plot(*before_and_after.T, color=FAINT, linewidth=0.8, zorder=3)
    if flown is not None:
        error = 100.0 * evidence.told["path_error"]
        chosen = along(flown)
        norm, colours = _error_scale(error), ramp_of_colours("inferno_r", 0.22, 0.92)
        pieces, levels = runs(flown[chosen], error[chosen], norm)
        axes.add_collection3d(Line3DCollection(pieces, colors=colours(levels), linewidths=1.8, zorder=4))
        axes.scatter(*flown[0], s=28, facecolors="white", edgecolors=INK, linewidths=1.1, depthshade=False, zorder=9)
        colour_bar(figure, norm, colours, "path error, cm")
    _space(axes, low, high)
    _fill(axes, low, high)
    return figure


def _error_scale(error: Array) -> Normalize:
    """Logarithmic where the errors of the flight are decades apart."""
    top = max(float(np.max(error)), 10.0 * LEAST_ERROR)
    low = max(float(np.percentile(error, 10)), LEAST_ERROR)
    if top > 100.0 * low:
        return LogNorm(low, top, clip=True)
    return Normalize(0.0, top, clip=True)


def _box(points: Array) -> tuple[Array, Array]:
    """Corners of a box around ``points`` that is flat only if it must be: a level path still has a floor under it."""
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    widest = float(np.max(high - low)) or 1.0
    least = widest * np.array([0.5, 0.5, 0.4])
    middle, half = 0.5 * (low + high), 0.5 * np.maximum((high - low) * 1.08, least)
    return middle - half, middle + half


def _space(axes: Any, low: Array, high: Array) -> None:
    """True proportions, thin walls, few ticks."""
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    axes.set_box_aspect(high - low)
    # the flatter the flight, the more from above it is looked at
    flat = float(np.max((high - low)[:2]) / (high - low)[2])
    axes.view_init(elev=min(24.0 + 6.0 * flat, 42.0), azim=-62)
    axes.set_proj_type("persp", focal_length=0.9)
    for axis, name in ((axes.xaxis, "east, m"), (axes.yaxis, "north, m"), (axes.zaxis, "up, m")):
        axis.set_label_text(name)
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
        axis._axinfo["grid"].update(color=RULE, linewidth=0.6)
        axis.line.set_color(FAINT)
        axis.line.set_linewidth(0.6)
    axes.tick_params(pad=0)


def _fill(axes: Any, low: Array, high: Array) -> None:
    """Place the axes so that the box, as it is seen, fills the figure, with room for labels and colours."""
    left, right, bottom, top = 0.06, 0.87, 0.225, 0.985
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    x, y, _ = proj3d.proj_transform(*corners.T, axes.get_proj())
    seen = axes.figure.transFigure.inverted().transform(axes.transData.transform(np.stack([x, y], axis=1)))
    (x0, y0), (x1, y1) = np.min(seen, axis=0), np.max(seen, axis=0)
    size = min((right - left) / (x1 - x0), (top - bottom) / (y1 - y0))
    across, up = 0.5 * (left + right - size * (x0 + x1)), 0.5 * (bottom + top - size * (y0 + y1))
    axes.set_position((across, up, size, size))
