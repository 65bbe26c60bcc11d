"""Curves to draw: the path and the track as rows of east, north, up (m), quantities over the time of following; the
points of each that matter, and their colours."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from companion.record.report.evidence import Array, Evidence
from companion.record.report.style import STEPS, name_x, plain

SEEN_APART = 0.003
"""Share of the picture by which the true track must differ from the estimated one to be drawn beside it."""
STILL = 0.1
"""m; what moved less before and after following is not drawn."""
POINTS = 1600
"""About as many as a figure has pixels, twice over."""
Dashes = str | tuple[int, tuple[float, float]]
"""matplotlib's line style: a word, or an offset with on and off in line widths."""
DASHED: Dashes = (0, (3, 1.5))
"""What was asked for, and PX4's own curves over ours."""
DOTTED: Dashes = (0, (2, 2))
"""Rules: a limit, a weight, what the vehicle file says."""


def path(evidence: Evidence) -> Array:
    """The path."""
    table = evidence.plan.table
    return _enu(table.samples(min(2000, max(361, 6 * len(table.pieces))))[1])


def estimated_track(evidence: Evidence) -> tuple[Array | None, Array | None]:
    """The track of every followed tick, and the rest of the flight (thinned; NaN where it was following)."""
    estimated = evidence.estimated
    states = evidence.table[evidence.table["fresh"] == 1]
    points = np.stack([states["east"], states["north"], -states["down"]], axis=1)
    if not evidence.has_following:
        return None, points[points_along(points)] if len(points) else None
    following = (
        np.isfinite(states["alpha"])
        & (states["t_boot"] >= estimated["t_boot"][0])
        & (states["t_boot"] <= estimated["t_boot"][-1])
    )
    parts = [points[: int(np.argmax(following))], points[len(following) - int(np.argmax(following[::-1])) :]]
    flown = np.stack([estimated["east"], estimated["north"], -estimated["down"]], axis=1)
    gap = np.full((1, 3), np.nan)
    rest = np.concatenate([gap, *(row for part in parts if len(part) for row in (part[points_along(part, 400)], gap))])
    known = rest[np.isfinite(rest[:, 0])]
    moved = len(known) > 0 and float(np.max(np.ptp(known, axis=0))) > STILL
    return flown, rest if moved else None


def true_track(evidence: Evidence, flown: Array | None) -> Array | None:
    """The true track, where the eye can tell it from the estimated one."""
    if evidence.truth is None or flown is None or len(evidence.truth) < 2:
        return None
    stamps, truth = evidence.estimated["t_boot"], evidence.truth
    rows = truth[(truth["t_boot"] >= stamps[0]) & (truth["t_boot"] <= stamps[-1])]
    if len(rows) < 2:
        return None
    true = _enu(np.asarray(rows["p_n"], dtype=float))
    there = np.stack([np.interp(stamps, rows["t_boot"], true[:, i]) for i in range(3)], axis=1)
    apart = float(np.max(np.linalg.norm((there - flown)[:, :2], axis=1)))
    return true[points_along(true)] if apart > SEEN_APART * float(np.max(np.ptp(flown, axis=0))) else None


def _enu(points_n: Array) -> Array:
    return np.stack([points_n[:, 1], points_n[:, 0], -points_n[:, 2]], axis=1)


def coloured_runs(points: Array, values: Array, norm: Normalize) -> tuple[list[Array], Array]:
    """Polylines of one colour each, and where on the colour ramp (0 to 1) each lies: a track of a thousand pieces would
    be a page of a megabyte."""
    level = np.clip(np.floor(np.ma.filled(norm(values), 0.0) * STEPS), 0, STEPS - 1).astype(int)
    changes = [0, *(np.flatnonzero(np.diff(level)) + 1), len(level) - 1]
    runs = [(a, b) for a, b in pairwise(changes) if b > a]
    return [points[a : b + 1] for a, b in runs], (np.array([level[a] for a, _ in runs]) + 0.5) / STEPS


def colour_bar(figure: Figure, norm: Normalize, colours: Colormap, label: str, beside: Axes | None = None) -> None:
    """A bar under the picture: ``beside`` axes that make room for it, or in a place of its own."""
    mappable = ScalarMappable(norm, colours)
    if beside is None:
        place = figure.add_axes((0.27, 0.078, 0.46, 0.017))
        bar = figure.colorbar(mappable, cax=place, orientation="horizontal")
    else:
        bar = figure.colorbar(mappable, ax=beside, orientation="horizontal", shrink=0.5, aspect=26, pad=0.02)
    bar.outline.set_visible(False)
    if bar.solids is not None:
        # else the paper shines through between the steps
        bar.solids.set_edgecolor("face")
    bar.set_label(label, labelpad=2)
    bar.ax.grid(False)
    bar.ax.tick_params(length=0, pad=2)
    bar.ax.minorticks_off()
    if not isinstance(norm, LogNorm):
        bar.locator = MaxNLocator(4, steps=[1, 2, 5, 10])
        bar.update_ticks()
    bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))


def draw_curve(
    panel: Axes, t: Array, y: Array, colour: str, label: str | None = None, width: float = 1.2, dashes: Dashes = "-"
) -> None:
    """Draw a quantity over time, without the points that would lie over one another."""
    if len(t):
        chosen = points_to_draw(y)
        panel.plot(t[chosen], y[chosen], color=colour, linewidth=width, linestyle=dashes, label=label)


def ends(curves: list[Array]) -> tuple[float, float]:
    """The least and the greatest finite value of all ``curves``; zeros where there is none."""
    values = np.concatenate(curves) if curves else np.zeros(0)
    values = values[np.isfinite(values)]
    return (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 0.0)


def label_time(panel: Axes, begin: float, end: float) -> None:
    """Name and set the x axis of a figure over the time of following, s."""
    name_x(panel, "time since following began, s", begin, max(end, 1e-3))


def points_to_draw(*curves: Array, points: int = POINTS) -> NDArray[np.intp]:
    """Indices to draw of curves over a common axis: of every stretch the least and the greatest of each curve, so that
    no spike is lost."""
    count = len(curves[0])
    if count <= points:
        return np.arange(count)
    buckets = max(1, points // (2 * len(curves)))
    width = -(-count // buckets)
    starts = np.arange(0, count, width)
    chosen = [np.array([0, count - 1])]
    for curve in curves:
        # the last stretch may be short; what fills it up is never chosen
        filled = np.full(len(starts) * width, np.nan)
        filled[:count] = curve
        grid = filled.reshape(len(starts), width)
        chosen.append(starts + np.argmin(np.where(np.isnan(grid), np.inf, grid), axis=1))
        chosen.append(starts + np.argmax(np.where(np.isnan(grid), -np.inf, grid), axis=1))
    return np.unique(np.minimum(np.concatenate(chosen), count - 1))


def points_along(points: Array, count: int = POINTS) -> NDArray[np.intp]:
    """Indices to draw of a track in space, rows of ``points``: evenly along its length, so that neither a hover nor a
    dash gets more than its share."""
    if len(points) <= count:
        return np.arange(len(points))
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if walked[-1] == 0.0:
        return np.array([0, len(points) - 1])
    return np.unique(np.searchsorted(walked, np.linspace(0.0, walked[-1], count)).clip(0, len(points) - 1))
