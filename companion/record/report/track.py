"""Where it flew: the path and the track from above, and in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from companion.record.report.evidence import Array, Evidence
from companion.record.report.palette import FAINT, INK, ROAD, RULE, TRUE
from companion.record.report.style import WIDTH, plain, ramp_of_colours
from companion.record.report.thinning import along

SEEN_APART = 0.003
"""Share of the picture by which the true track must differ from the seen one to be drawn beside it."""
LEAST_ERROR = 0.01
"""cm; the colours of the path error do not resolve less."""


def from_above(evidence: Evidence) -> Figure:
    """North up, east right, one metre as long in both; coloured by speed."""
    figure = Figure(figsize=(WIDTH, WIDTH * 1.04), layout="constrained")
    axes = figure.add_subplot()
    flown, before_and_after = _tracks(evidence)
    road = _road(evidence)
    axes.plot(road[:, 0], road[:, 1], color=ROAD, linewidth=6, zorder=1)
    if before_and_after is not None:
        axes.plot(before_and_after[:, 0], before_and_after[:, 1], color=FAINT, linewidth=0.8, zorder=2)
    true = _true_track(evidence, flown)
    if true is not None:
        axes.plot(true[:, 0], true[:, 1], color=TRUE, linewidth=3, zorder=2)
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
        pieces, levels = _runs(flown[chosen, :2], speed[chosen], norm)
        axes.add_collection(LineCollection(pieces, colors=colours(levels), linewidths=1.8, zorder=3), autolim=False)
        _bar(figure, axes, norm, colours, "speed, m/s")
        _ends(axes, flown)
    _direction(axes, evidence)
    return figure


def in_space(evidence: Evidence) -> Figure:
    """The same with its height; coloured by the distance to the path."""
    figure = Figure(figsize=(WIDTH, WIDTH * 1.04))
    axes: Any = figure.add_axes((-0.03, 0.13, 1.03, 0.9), projection=Axes3D.name)
    flown, before_and_after = _tracks(evidence)
    road = _road(evidence)
    everything = np.concatenate([part for part in (road, flown, before_and_after) if part is not None])
    everything = everything[np.isfinite(everything).all(axis=1)]
    low, high = _box(everything)
    floor = low[2]
    axes.plot(road[:, 0], road[:, 1], np.full(len(road), floor), color=RULE, linewidth=1.5)
    axes.plot(*road.T, color=ROAD, linewidth=5)
    if before_and_after is not None:
        axes.plot(*before_and_after.T, color=FAINT, linewidth=0.8)
    if flown is not None:
        error = 100.0 * evidence.told["path_error"]
        chosen = along(flown)
        norm, colours = _error_scale(error), ramp_of_colours("inferno_r", 0.22, 0.92)
        pieces, levels = _runs(flown[chosen], error[chosen], norm)
        axes.add_collection3d(Line3DCollection(pieces, colors=colours(levels), linewidths=1.8))
        axes.scatter(*flown[0], s=26, facecolors="white", edgecolors=INK, linewidths=1.1, depthshade=False, zorder=9)
        place = figure.add_axes((0.27, 0.075, 0.46, 0.018))
        _bar(figure, place, norm, colours, "path error, cm", inside=True)
    _space(axes, low, high)
    return figure


def _road(evidence: Evidence) -> Array:
    """The path as rows of east, north, up."""
    return _enu(evidence.plan.table.samples(361)[1])


def _tracks(evidence: Evidence) -> tuple[Array | None, Array | None]:
    """East, north, up: of every followed tick, and of the rest of the flight (thinned; NaN where it was following)."""
    told = evidence.told
    flown = np.stack([told["east"], told["north"], -told["down"]], axis=1) if evidence.followed else None
    table = evidence.table
    seen = table[table["fresh"] == 1]
    points = np.stack([seen["east"], seen["north"], -seen["down"]], axis=1)
    if flown is None:
        return None, points[along(points)] if len(points) else None
    following = (
        np.isfinite(seen["alpha"]) & (seen["t_boot"] >= told["t_boot"][0]) & (seen["t_boot"] <= told["t_boot"][-1])
    )
    parts = [points[: int(np.argmax(following))], points[len(following) - int(np.argmax(following[::-1])) :]]
    gap = np.full((1, 3), np.nan)
    rest = np.concatenate([row for part in parts if len(part) for row in (part[along(part, 400)], gap)] or [gap])
    moved = (
        np.isfinite(rest).all(axis=1).any() and float(np.nanmax(np.ptp(rest[np.isfinite(rest[:, 0])], axis=0))) > 0.1
    )
    return flown, rest if moved else None


def _true_track(evidence: Evidence, flown: Array | None) -> Array | None:
    """The true track, where it can be told from the seen one with the eye."""
    if evidence.truth is None or flown is None or len(evidence.truth) < 2:
        return None
    stamps, truth = evidence.told["t_boot"], evidence.truth
    rows = truth[(truth["t_boot"] >= stamps[0]) & (truth["t_boot"] <= stamps[-1])]
    if len(rows) < 2:
        return None
    true = _enu(np.asarray(rows["p_n"], dtype=float))
    there = np.stack([np.interp(stamps, rows["t_boot"], true[:, i]) for i in range(3)], axis=1)
    apart = float(np.max(np.linalg.norm((there - flown)[:, :2], axis=1)))
    return true[along(true)] if apart > SEEN_APART * float(np.max(np.ptp(flown, axis=0))) else None


def _enu(points_n: Array) -> Array:
    return np.stack([points_n[:, 1], points_n[:, 0], -points_n[:, 2]], axis=1)


def _runs(points: Array, values: Array, norm: Normalize) -> tuple[list[Array], Array]:
    """Polylines of one colour each, and where on the colour ramp (0 to 1) each lies: a track of a thousand pieces would
    be a page of a megabyte."""
    steps = 24
    level = np.clip(np.floor(np.ma.filled(norm(values), 0.0) * steps), 0, steps - 1).astype(int)
    changes = [0, *(np.flatnonzero(np.diff(level)) + 1), len(level) - 1]
    runs = [(a, b) for a, b in zip(changes, changes[1:], strict=False) if b > a]
    return [points[a : b + 1] for a, b in runs], (np.array([level[a] for a, _ in runs]) + 0.5) / steps


def _error_scale(error: Array) -> Normalize:
    top = max(float(np.max(error)), 10.0 * LEAST_ERROR)
    if top > 300.0 * LEAST_ERROR:
        return LogNorm(max(LEAST_ERROR, 1e-4 * top), top, clip=True)
    return Normalize(0.0, top, clip=True)


def _bar(figure: Figure, axes: Axes, norm: Normalize, colours: Colormap, label: str, inside: bool = False) -> None:
    mappable = ScalarMappable(norm, colours)
    if inside:
        bar = figure.colorbar(mappable, cax=axes, orientation="horizontal")
    else:
        bar = figure.colorbar(mappable, ax=axes, orientation="horizontal", shrink=0.5, aspect=26, pad=0.02)
    bar.outline.set_visible(False)  # type: ignore[operator]
    bar.set_label(label, labelpad=2)
    bar.ax.grid(False)
    bar.ax.tick_params(length=0, pad=2)
    bar.ax.minorticks_off()
    if not isinstance(norm, LogNorm):
        bar.locator = MaxNLocator(4)
        bar.update_ticks()
    bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))


def _ends(axes: Axes, flown: Array) -> None:
    """Mark where following began and ended, the words on the outer side."""
    middle = 0.5 * (np.min(flown, axis=0) + np.max(flown, axis=0))[:2]
    extent = float(np.max(np.ptp(flown[:, :2], axis=0)))
    marks = [(flown[0, :2], "start", "o")]
    if float(np.linalg.norm(flown[-1, :2] - flown[0, :2])) > 0.08 * extent:
        marks.append((flown[-1, :2], "end", "s"))
    for point, word, shape in marks:
        axes.plot(*point, shape, markersize=5.5, markerfacecolor="white", markeredgecolor=INK, zorder=6)
        away = point - middle
        size = float(np.linalg.norm(away))
        x, y = away / size if size > 1e-9 else (0.0, 1.0)
        axes.annotate(
            word,
            point,
            xytext=(11.0 * x, 11.0 * y),
            textcoords="offset points",
            ha="center" if abs(x) < 0.5 else "left" if x > 0.0 else "right",
            va="center" if abs(y) < 0.5 else "bottom" if y > 0.0 else "top",
            zorder=6,
        )


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


def _box(points: Array) -> tuple[Array, Array]:
    """Corners of a box around ``points`` that is flat only if it must be: a level path still has a floor under it."""
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    widest = float(np.max(high - low)) or 1.0
    least = widest * np.array([0.5, 0.5, 0.4])
    middle, half = 0.5 * (low + high), 0.5 * np.maximum((high - low) * 1.08, least)
    return middle - half, middle + half


def _space(axes: Any, low: Array, high: Array) -> None:
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    axes.set_box_aspect(high - low, zoom=0.98)
    axes.view_init(elev=27, azim=-62)
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
