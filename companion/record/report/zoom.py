"""The same figures to zoom into: matplotlib's, told to plotly.js, which lies packed in the page.

plotly.js is chosen because the `plotly` package brings it as one file that needs no network (the page stays one file),
because a finger and a mouse both zoom in it, and because it is kept by many. It is packed (1.5 MB instead of 4.8), and
nothing of it runs until a reader asks: the page opens as fast without, and reads the same where there is no JavaScript.
"""

from __future__ import annotations

import base64
import gzip
import json
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from companion.record.report.palette import FAINT, INK, RULE

DIGITS = 5
"""Significant digits of a drawn number: finer than a screen, and half the page."""
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
COLOUR_BAR = "<colorbar>"
"""matplotlib's label of the axes that hold a colour bar."""
Chart = dict[str, Any]


def library() -> str | None:
    """plotly.js, gzipped and in base64; None where the `plotly` package is not installed."""
    try:
        script = files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    except (ImportError, OSError):
        return None
    return base64.b64encode(gzip.compress(script, mtime=0)).decode("ascii")


def chart(figure: Figure) -> str:
    """A figure that has been drawn, as plotly's JSON: its lines, spans, names and axes."""
    panels = [axes for axes in figure.axes if axes.get_label() != COLOUR_BAR and _curves(axes)]
    traces: list[Chart] = []
    layout: Chart = {
        "showlegend": True,
        "hovermode": "closest",
        "dragmode": "zoom",
        "font": {"size": 12, "color": INK},
        "paper_bgcolor": "#fff",
        "plot_bgcolor": "#fff",
        "legend": {"orientation": "h", "yref": "container", "y": 0, "yanchor": "bottom", "x": 0},
        "margin": {"l": 56, "r": 12, "t": 36, "b": 84},
        "shapes": [],
        "annotations": [],
    }
    named: set[str] = set()
    for number, axes in enumerate(panels, 1):
        index = "" if number == 1 else str(number)
        traces += _traces(axes, index, named)
        _axes(layout, axes, index, number, len(panels))
    return json.dumps({"data": traces, "layout": layout}, separators=(",", ":"))


def _curves(axes: Axes) -> list[Line2D | LineCollection]:
    lines = [line for line in axes.lines if _in_data(line, axes) and len(np.atleast_1d(line.get_xdata())) > 0]
    coloured = [each for each in axes.collections if isinstance(each, LineCollection)]
    return sorted([*lines, *coloured], key=lambda each: each.get_zorder())


def _in_data(line: Line2D, axes: Axes) -> bool:
    # what spans the axes (axhline, axvline) is a rule, not a curve
    return bool(line.get_transform() == axes.transData)


def _traces(axes: Axes, index: str, named: set[str]) -> list[Chart]:
    """Every line of a panel; a name stands once in the legend of the figure."""
    traces = []
    for curve in _curves(axes):
        if isinstance(curve, LineCollection):
            traces += _coloured_traces(curve, index)
            continue
        name = str(curve.get_label())
        known = not name.startswith("_")
        marker = curve.get_marker() not in ("None", "", None)
        traces.append(
            {
                **_points(np.asarray(curve.get_xydata())),
                "xaxis": f"x{index}",
                "yaxis": f"y{index}",
                "mode": "markers" if marker else "lines",
                "name": name if known else "",
                "showlegend": known and name not in named,
                "hoverinfo": "x+y+name" if known else "x+y",
                "line": {
                    "color": to_hex(curve.get_color()),
                    "width": max(1.0, 1.2 * curve.get_linewidth()),
                    "dash": _dash(curve),
                },
                "marker": {"color": to_hex(curve.get_markeredgecolor()), "size": 8, "symbol": "circle-open"},
            }
        )
        named.add(name)
    return traces


def _coloured_traces(curve: LineCollection, index: str) -> list[Chart]:
    """A track in colours: its pieces, those of a colour as one broken line."""
    by_colour: dict[str, list[Any]] = {}
    colours: Any = curve.get_colors()
    for piece, colour in zip(curve.get_segments(), colours, strict=False):
        by_colour.setdefault(to_hex(colour), []).append(np.vstack([piece, [np.nan, np.nan]]))
    return [
        {
            **_points(np.concatenate(pieces)),
            "xaxis": f"x{index}",
            "yaxis": f"y{index}",
            "mode": "lines",
            "name": "track",
            "legendgroup": "track",
            "showlegend": first,
            "hoverinfo": "x+y",
            "line": {"color": colour, "width": 3},
        }
        for first, (colour, pieces) in zip([True] + [False] * len(by_colour), by_colour.items(), strict=False)
    ]


def _points(points: Any) -> Chart:
    return {"x": [_number(value) for value in points[:, 0]], "y": [_number(value) for value in points[:, 1]]}


def _number(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


def _dash(line: Line2D) -> str:
    style = line.get_linestyle()
    return DASHES.get(str(style), "solid") if not line.is_dashed() else "dash"


def _axes(layout: Chart, axes: Axes, index: str, number: int, count: int) -> None:
    """The axes of a panel, its name over it, its spans and rules."""
    top, bottom = 1.0 - (number - 1) / count, 1.0 - number / count
    gap = 0.0 if count == 1 else 0.18 / count
    logarithmic = axes.get_yscale() == "log"
    ends = [float(np.log10(end)) if logarithmic else float(end) for end in axes.get_ylim()]
    grid = {"gridcolor": RULE, "zeroline": False, "linecolor": FAINT, "showline": True}
    equal = axes.get_aspect() == 1.0
    layout[f"yaxis{index}"] = {
        **grid,
        "domain": [bottom, top - gap],
        "range": ends,
        "type": "log" if logarithmic else "linear",
        "title": {"text": axes.get_ylabel()},
        **({"dtick": 1} if logarithmic else {}),
        **({"scaleanchor": f"x{index}"} if equal else {}),
    }
    layout[f"xaxis{index}"] = {
        **grid,
        "anchor": f"y{index}",
        "range": [float(end) for end in axes.get_xlim()],
        # panels over one another are zoomed together along what they share
        **({"matches": "x"} if number > 1 else {}),
        "showticklabels": number == count,
        "title": {"text": axes.get_xlabel()},
    }
    name = axes.get_title(loc="left")
    if name:
        layout["annotations"].append(
            {
                "text": f"<b>{name}</b>", "xref": "paper", "yref": "paper", "x": 0, "y": top - gap, "showarrow": False,
                "xanchor": "left", "yanchor": "bottom",
            }
        )  # fmt: skip
    layout["shapes"] += [_span(patch, index) for patch in axes.patches if isinstance(patch, Rectangle)]
    layout["shapes"] += [shape for line in axes.lines if (shape := _rule(line, axes, index)) is not None]


def _span(patch: Rectangle, index: str) -> Chart:
    return {
        "type": "rect", "xref": f"x{index}", "yref": f"y{index} domain", "x0": float(patch.get_x()),
        "x1": float(patch.get_x() + patch.get_width()), "y0": 0, "y1": 1, "fillcolor": to_hex(patch.get_facecolor()),
        "line": {"width": 0}, "layer": "below",
    }  # fmt: skip


def _rule(line: Line2D, axes: Axes, index: str) -> Chart | None:
    if _in_data(line, axes):
        return None
    (x0, x1), (y0, y1) = (np.asarray(values, dtype=float) for values in (line.get_xdata(), line.get_ydata()))
    upright = x0 == x1
    return {
        "type": "line", "xref": f"x{index}" if upright else f"x{index} domain",
        "yref": f"y{index} domain" if upright else f"y{index}", "x0": float(x0), "x1": float(x1), "y0": float(y0),
        "y1": float(y1), "line": {"color": to_hex(line.get_color()), "width": 1, "dash": "dot"},
    }  # fmt: skip
