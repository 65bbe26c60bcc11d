"""A track coloured by a quantity, and the bar that says what the colours mean."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from companion.record.report.evidence import Array
from companion.record.report.style import STEPS, plain


def runs(points: Array, values: Array, norm: Normalize) -> tuple[list[Array], Array]:
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
