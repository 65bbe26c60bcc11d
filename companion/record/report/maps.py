"""The path and the track, from above and in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from companion.record.report import curves
from companion.record.report.curves import colour_bar, coloured_runs, points_along
from companion.record.report.evidence import Array, Evidence
from companion.record.report.marks import Place, places, timetable
from companion.record.report.palette import FAINT, INK, ROAD, RULE, VERMILION
from companion.record.report.style import WIDTH, legend, plain, ramp_of_colours

PATH_DASHES = (0, (5, 3))
"""on and off, in line widths."""


def from_above(evidence: Evidence) -> Figure:
    """North up, east right, one metre as long in both; the track coloured by speed, the path dashed over it."""
    figure = Figure(figsize=(WIDTH, WIDTH * 1.1), layout="constrained")
    axes = figure.add_subplot()
    flown, before_and_after = curves.estimated_track(evidence)
    path = curves.path(evidence)
    axes.plot(path[:, 0], path[:, 1], color=ROAD, linewidth=7, zorder=1)
    axes.plot(path[:, 0], path[:, 1], color=INK, linewidth=0.9, linestyle=PATH_DASHES, zorder=4, label="path")
    if before_and_after is not None:
        axes.plot(*before_and_after[:, :2].T, color=FAINT, linewidth=0.8, zorder=2, label="before and after")
    true = curves.true_track(evidence, flown)
    if true is not None:
        axes.plot(true[:, 0], true[:, 1], color=VERMILION, linewidth=1.0, zorder=3.5, label="track, true")
    if flown is not None:
        axes.update_datalim(flown[:, :2])
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axes.margins(0.12)
    if flown is not None:
        _draw_track(figure, axes, evidence, flown, np.concatenate([path, flown]))
    elif before_and_after is not None:
        _mark(axes, path, [Place(before_and_after[-1], "vehicle", "s", INK)])
    _direction(axes, evidence)
    legend(axes, columns=2)
    return figure


def _draw_track(figure: Figure, axes: Axes, evidence: Evidence, flown: Array, drawn: Array) -> None:
    """The track coloured by speed, with where it began, what happened on it and where it ended."""
    estimated = evidence.estimated
    speed = np.sqrt(estimated["v_north"] ** 2 + estimated["v_east"] ** 2 + estimated["v_down"] ** 2)
    chosen = points_along(flown)
    norm = Normalize(0.0, max(float(np.max(speed)), 0.1))
    colours = ramp_of_colours("viridis", 0.0, 0.9)
    pieces, levels = coloured_runs(flown[chosen, :2], speed[chosen], norm)
    believed = "track" if evidence.true is None else "track, as estimated"
    axes.add_collection(LineCollection(pieces, colors=colours(levels), linewidths=2.6, zorder=3), autolim=False)
    axes.plot([], [], color=colours(0.75), linewidth=2.6, label=believed)
    colour_bar(figure, norm, colours, "speed, m/s", beside=axes)
    begun = next((each for each in evidence.flight_events if each.kind == "start"), None)
    word = "start" if begun is None else f"start, {begun.error_max:.1f} m off"
    marks = [Place(flown[0], word, "o", INK), *places(evidence, flown)]
    if float(np.linalg.norm((flown[-1] - flown[0])[:2])) > 0.04 * float(np.max(np.ptp(drawn, axis=0))):
        marks.append(Place(flown[-1], "end", "s", INK))
    ghost = timetable(evidence)
    if ghost is not None:
        way, place = ghost
        axes.plot(way[:, 0], way[:, 1], color=VERMILION, linewidth=1.6, linestyle=(0, (1, 1.4)), zorder=5)
        marks.append(place)
    _mark(axes, drawn, marks)


def _mark(axes: Axes, drawn: Array, marks: list[Place]) -> None:
    """Mark places of the flight, each word where most room is left by the curves through ``drawn``."""
    drawn = drawn[np.isfinite(drawn[:, 0]), :2][:: max(1, len(drawn) // 2000)]
    reach = 0.06 * float(np.max(np.ptp(drawn, axis=0)))
    for point, word, shape, colour in marks:
        axes.plot(point[0], point[1], shape, markersize=5.5, markerfacecolor="white", markeredgecolor=colour, zorder=6)
        wide = max(1.6, 0.3 * len(word))
        x, y = max(_SIDES, key=lambda side: _room(drawn, point[:2], side, reach, wide))
        axes.annotate(
            word,
            (float(point[0]), float(point[1])),
            xytext=(8.0 * x, 8.0 * y),
            textcoords="offset points",
            ha="center" if x == 0.0 else "left" if x > 0.0 else "right",
            va="center" if y == 0.0 else "bottom" if y > 0.0 else "top",
            color=colour,
            zorder=6,
        )


_SIDES = ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.7, 0.7), (0.7, -0.7), (-0.7, -0.7), (-0.7, 0.7))


def _room(drawn: Array, point: Array, side: tuple[float, float], reach: float, wide: float) -> float:
    """m from a word beside a point to the nearest curve; words are ``wide`` reaches from their middle to an end."""
    near = point + reach * np.array([0.8 * side[0], side[1]])
    run = np.linspace(0.0, 2.0 * wide, 7) if side[0] > 0.0 else np.linspace(0.0, -2.0 * wide, 7)
    along_word = run if side[0] != 0.0 else np.linspace(-wide, wide, 7)
    letters = near + reach * 0.5 * np.stack([along_word, np.zeros(7)], axis=1)
    clearance = float(np.min(np.linalg.norm(drawn[:, None, :] - letters[None, :, :], axis=2)))
    outside = np.any((letters < np.min(drawn, axis=0) - reach) | (letters > np.max(drawn, axis=0) + reach))
    return clearance - (reach if outside else 0.0)


def _direction(axes: Axes, evidence: Evidence) -> None:
    """Arrowheads along the path in the direction of flight."""
    table, direction = evidence.plan.table, evidence.plan.direction
    begin = float(evidence.estimated["s"][0]) if evidence.has_following else 0.0
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


LEAST_ERROR = 0.01
"""cm; the colours of the path error do not resolve less."""


def in_space(evidence: Evidence) -> Figure:
    """With its height; coloured by the distance to the path."""
    figure = Figure(figsize=(WIDTH, WIDTH * 1.04))
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection=Axes3D.name, computed_zorder=False)
    flown, before_and_after = curves.estimated_track(evidence)
    path = curves.path(evidence)
    everything = np.concatenate([part for part in (path, flown, before_and_after) if part is not None])
    everything = everything[np.isfinite(everything).all(axis=1)]
    low, high = _box(everything)
    floor = low[2]
    axes.plot(path[:, 0], path[:, 1], np.full(len(path), floor), color=RULE, linewidth=1.5, zorder=1)
    axes.plot(*path.T, color=ROAD, linewidth=5, zorder=2)
    axes.plot(*path.T, color=INK, linewidth=0.8, linestyle=PATH_DASHES, zorder=5)
    if before_and_after is not None:
        axes.plot(*before_and_after.T, color=FAINT, linewidth=0.8, zorder=3)
    if flown is not None:
        error = 100.0 * evidence.estimated["path_error"]
        chosen = points_along(flown)
        norm, colours = _error_scale(error), ramp_of_colours("inferno_r", 0.22, 0.92)
        pieces, levels = coloured_runs(flown[chosen], error[chosen], norm)
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
