"""The figures of a study's page."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from companion.record.report.figures import inline
from companion.record.report.palette import BLUE, VERMILION
from companion.record.report.style import WIDTH, drawing, legend, name_y

Row = dict[str, Any]
HEIGHT = 2.9
"""inches."""
BINS = 30
SCATTERED = 5
"""Values that the error is drawn over, the strongest first; an even number of figures with the first."""


def draw_figures(rows: list[Row], name: str, ranks: list[tuple[str, float]]) -> list[tuple[str, str]]:
    """Each as SVG, and the sentence under it. ``name``: of the error; ``ranks``: what goes with it, strongest first."""
    known = [row for row in rows if row.get(name) is not None]
    of_all = f"Of {len(known)} flights that have one: {name}."
    figures = [(_draw("errors", of_all, lambda panel: _histogram(panel, known, name)), of_all)]
    for number, (key, correlation) in enumerate(ranks[:SCATTERED], 1):
        caption = f"The error over {key}: rank correlation {correlation:+.2f}."
        svg = _draw(f"over-{number}", caption, lambda panel, key=key: _scatter(panel, known, name, key))
        figures.append((svg, caption))
    return figures


def _draw(name: str, caption: str, draw: Any) -> str:
    with drawing():
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        draw(figure.subplots())
        return inline(figure, name, caption)


def _parts(known: list[Row]) -> list[tuple[str, str, list[Row]]]:
    parts = [("passed", BLUE, [row for row in known if row["passed"]])]
    parts.append(("did not pass", VERMILION, [row for row in known if not row["passed"]]))
    return [part for part in parts if part[2]]


def _histogram(panel: Axes, known: list[Row], name: str) -> None:
    parts = _parts(known)
    errors = [[100.0 * row[name] for row in part] for _, _, part in parts]
    colours, labels = [colour for _, colour, _ in parts], [label for label, _, _ in parts]
    panel.hist(errors, bins=min(BINS, max(5, len(known) // 4)), stacked=True, color=colours, label=labels)
    panel.set_xlabel("path error, cm rms, settled")
    name_y(panel, "Flights")
    panel.yaxis.set_major_locator(MaxNLocator(integer=True))
    legend(panel)


def _scatter(panel: Axes, known: list[Row], name: str, key: str) -> None:
    for label, colour, part in _parts(known):
        xs, ys = [row[f"vary.{key}"] for row in part], [100.0 * row[name] for row in part]
        panel.plot(xs, ys, ".", markersize=3.5, color=colour, label=label, alpha=0.7)
    panel.set_xlabel(key)
    name_y(panel, "Path error, cm rms, settled")
    legend(panel)
