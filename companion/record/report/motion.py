"""How it flew: roll and pitch, thrust, and what was sent, as in the paper's Figs. 3 and 4; and how steadily."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from companion.record.report.curves import DASHED, DOTTED, draw_curve, ends, label_time
from companion.record.report.evidence import Array, Evidence, Series
from companion.record.report.marks import shade
from companion.record.report.palette import BLUE, FAINT, INK, LINES, TRUE, VERMILION
from companion.record.report.style import WIDTH, legend, name_y, plain, span_y, stack_panels
from companion.record.series import FOLLOW, roll_pitch
from companion.vehicle import OutputLevel

STEADY = 1e-6
"""s; gaps between setpoints that differ by less are all the same."""


class Window(NamedTuple):
    """The part of following that is shown, s."""

    begin: float
    end: float


def whole(evidence: Evidence) -> Window:
    """All of it."""
    return Window(0.0, evidence.following_s)


def last_lap(evidence: Evidence) -> tuple[Window, bool] | None:
    """The last lap of the settled part, or all of it where it is shorter (then False); None where nothing settled."""
    settled, estimated = evidence.settled_from, evidence.estimated
    if settled is None or estimated["t"][-1] - settled < 0.5:
        return None
    end, way = float(estimated["t"][-1]), estimated["travelled"]
    before = np.flatnonzero(way <= way[-1] - evidence.plan.table.length)
    begin = float(estimated["t"][before[-1]]) if len(before) else -1.0
    if begin >= settled:
        return Window(begin, end), True
    return Window(settled, end), False


def motion_figure(evidence: Evidence, window: Window) -> Figure:
    """Attitude, thrust, and the motors or the rates, over the window's time."""
    motors = evidence.plan.level is OutputLevel.MOTORS
    heights = [1.1, 0.8, 1.2] if motors else [1.0, 0.8, 0.62, 0.62, 0.62]
    figure, panels = stack_panels(heights, 5.6 if motors else 6.6)
    shade(panels, evidence, window.begin, window.end)
    estimated = _within(evidence.estimated, window)
    true = None if evidence.true is None else _within(evidence.true, window)
    _attitude(panels[0], evidence, estimated)
    _thrust(panels[1], evidence, estimated, true)
    if motors:
        _motors(panels[2], evidence, estimated)
    else:
        _rates(panels[2:], evidence, estimated)
    label_time(panels[-1], window.begin, window.end)
    return figure


def _within(series: Series, window: Window) -> Series:
    rows = (series["t"] >= window.begin) & (series["t"] <= window.end)
    return {name: values[rows] for name, values in series.items()}


def _attitude(panel: Axes, evidence: Evidence, estimated: Series) -> None:
    roll, pitch = np.degrees(estimated["roll"]), np.degrees(estimated["pitch"])
    shown = [roll, pitch]
    if evidence.plan.level is OutputLevel.ATTITUDE:
        asked, asked_pitch = map(np.degrees, roll_pitch(*(estimated[f"sent_{i}"] for i in range(4))))
        draw_curve(panel, estimated["t"], asked, INK, "setpoint", 0.8, DASHED)
        draw_curve(panel, estimated["t"], asked_pitch, INK, None, 0.8, DASHED)
        shown += [asked, asked_pitch]
    draw_curve(panel, estimated["t"], roll, BLUE, "roll φ")
    draw_curve(panel, estimated["t"], pitch, VERMILION, "pitch θ")
    name_y(panel, "Roll and pitch, deg")
    span_y(panel, *ends(shown), 1.0)
    legend(panel)


def _thrust(panel: Axes, evidence: Evidence, estimated: Series, true: Series | None) -> None:
    weight = evidence.plan.vehicle.weight
    shown = [estimated["thrust"], np.array([weight])]
    if true is not None:
        draw_curve(panel, true["t"], true["thrust"], TRUE, "true", 3.4)
        shown.append(true["thrust"])
    panel.axhline(weight, color=FAINT, linewidth=0.8, linestyle=DOTTED, label="weight")
    draw_curve(panel, estimated["t"], estimated["thrust"], BLUE, "sent")
    name_y(panel, "Thrust, N")
    span_y(panel, *ends(shown), 0.02 * weight)
    legend(panel)


def _motors(panel: Axes, evidence: Evidence, estimated: Series) -> None:
    rotors = evidence.plan.vehicle.rotors
    forces = [estimated[f"sent_{i}"] * rotor.thrust_max for i, rotor in enumerate(rotors)]
    for i, force in enumerate(forces):
        draw_curve(panel, estimated["t"], force, LINES[i % len(LINES)], f"motor {i + 1}" if i == 0 else f"{i + 1}", 1.1)
    low, high = ends(forces)
    span_y(panel, low, high, 0.02 * max(rotor.thrust_max for rotor in rotors))
    name_y(panel, "Motor commands, N")
    legend(panel)
    bottom, top = panel.get_ylim()
    if low < 0.0:
        panel.axhspan(bottom, 0.0, color=VERMILION, alpha=0.09, linewidth=0)
        panel.axhline(0.0, color=VERMILION, linewidth=0.8)
    ceiling = min(rotor.command[1] * rotor.thrust_max for rotor in rotors)
    if bottom < ceiling < top:
        panel.axhline(ceiling, color=FAINT, linewidth=0.8, linestyle=DOTTED)


def _rates(panels: list[Axes], evidence: Evidence, estimated: Series) -> None:
    sent = evidence.plan.level is OutputLevel.RATES
    for i, (panel, axis) in enumerate(zip(panels, "pqr", strict=True)):
        measured = np.degrees(estimated[axis])
        shown = [measured]
        draw_curve(panel, estimated["t"], measured, LINES[i], "measured")
        if sent:
            asked = np.degrees(estimated[f"sent_{i}"])
            draw_curve(panel, estimated["t"], asked, INK, "setpoint", 0.8, DASHED)
            shown.append(asked)
        name_y(panel, f"Body rate {axis}, deg/s")
        span_y(panel, *ends(shown), 2.0)
        if i == 0 and sent:
            legend(panel)


def setpoint_gaps(evidence: Evidence) -> Array:
    """s between one setpoint and the next while following."""
    table = evidence.table
    sent = table[(table["phase"] == FOLLOW) & (table["setpoint"] > 0)]
    between: Array = np.diff(np.asarray(sent["now"], dtype=float))
    return between


def latencies(evidence: Evidence) -> Array:
    """s from the arrival of a state to the return of its setpoint's send, while following."""
    table = evidence.table
    values = np.asarray(table[(table["phase"] == FOLLOW) & (table["setpoint"] > 0)]["latency"], dtype=float)
    known: Array = values[np.isfinite(values)]
    return known


def histogram(values: Array, name: str, unit: str) -> Figure:
    """How often each value came, the counts on a logarithmic axis so that the rare late one is seen."""
    figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
    panel = figure.add_subplot()
    top = float(np.max(values)) * 1.03
    bins = np.linspace(0.0, top, 81)
    counts, _ = np.histogram(values, bins)
    panel.bar(bins[:-1], counts, width=np.diff(bins), align="edge", color=BLUE, linewidth=0)
    panel.set_yscale("log")
    panel.set_ylim(0.7, float(np.max(counts)) * 4.0)
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    panel.yaxis.minorticks_off()
    panel.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    panel.grid(axis="x", visible=False)
    panel.set_xlim(0.0, top)
    panel.set_xlabel(f"{name}, {unit}")
    name_y(panel, "Setpoints")
    half, most = float(np.percentile(values, 50)), float(np.percentile(values, 99))
    _mark_quantile(panel, half, "half", FAINT, left=half > 0.1 * top)
    _mark_quantile(panel, most, "99 %", VERMILION, left=most > 0.9 * top and most - half > 0.2 * top)
    return figure


def _mark_quantile(panel: Axes, value: float, word: str, colour: str, left: bool) -> None:
    panel.axvline(value, color=colour, linewidth=0.9, linestyle=DOTTED)
    panel.annotate(
        word,
        (value, 1.0),
        xytext=(-3 if left else 3, -2),
        ha="right" if left else "left",
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        va="top",
        fontsize=8,
        color=colour,
    )
