"""PX4's own curves from its log beside ours: what it estimated, what it was asked, what it told its motors."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.record.report.evidence import Array, Evidence, Series
from companion.record.report.palette import BLUE, INK, LINES, TRUE, VERMILION
from companion.record.report.style import along_x, figure_legend, legend, named, spanned, stacked
from companion.record.report.tracks import kept
from companion.record.series import roll_pitch
from companion.record.ulog.reading import LogSeries
from companion.record.ulog.topics import BODY_RATES
from companion.vehicle import OutputLevel

TIME = "time since following began, s"
THEIRS = (0, (3, 1.5))
"""on and off, in line widths: PX4's curves over ours."""
Within = tuple[Array, Series]
"""s of following, and the columns."""


def estimate(evidence: Evidence, topics: dict[str, LogSeries]) -> Figure:
    """PX4's estimate beside the states that reached us: place apart, roll and pitch over one another."""
    figure, (apart, angles) = stacked([1.0, 1.2], 3.8)
    estimated = evidence.estimated
    t, theirs = _within(evidence, topics.get("vehicle_local_position"))
    lines = []
    for name, colour in zip(("north", "east", "down"), LINES, strict=False):
        if name in theirs:
            lines.append(100.0 * (theirs[name] - np.interp(t, estimated["t"], estimated[name])))
            _line(apart, t, lines[-1], colour, name)
    named(apart, "Place in PX4's log less the one received, cm")
    legend(apart)
    spanned(apart, *_ends(lines), 2.0)
    t, theirs = _within(evidence, topics.get("vehicle_attitude"))
    lines = [np.degrees(estimated[name]) for name in ("roll", "pitch")]
    for values, name, colour in zip(lines, ("roll", "pitch"), (BLUE, VERMILION), strict=True):
        _line(angles, estimated["t"], values, colour, name)
    if len(theirs) == 4:
        for values, label in zip(
            roll_pitch(*(theirs[f"q_{axis}"] for axis in "wxyz")), ("PX4's log", None), strict=True
        ):
            lines.append(np.degrees(values))
            _line(angles, t, lines[-1], INK, label, THEIRS)
    named(angles, "Roll and pitch, deg")
    legend(angles)
    spanned(angles, *_ends(lines), 2.0)
    _along(angles, evidence)
    return figure


def setpoints(evidence: Evidence, topics: dict[str, LogSeries]) -> Figure:
    """Body rates and thrust: what we sent, what PX4 flew by, and the rates that came of it."""
    figure, panels = stacked([0.7, 0.7, 0.7, 0.8], 5.4)
    estimated = evidence.estimated
    t, theirs = _within(evidence, topics.get("vehicle_rates_setpoint"))
    measured_t, measured = _within(evidence, topics.get(BODY_RATES))
    sent_rates = evidence.plan.level is OutputLevel.RATES
    for number, (panel, axis) in enumerate(zip(panels, "pqr", strict=False)):
        lines = []
        if axis in measured:
            lines.append(np.degrees(measured[axis]))
            _line(panel, measured_t, lines[-1], TRUE, "measured, PX4's log", width=2.4)
        if sent_rates:
            lines.append(np.degrees(estimated[f"sent_{number}"]))
            _line(panel, estimated["t"], lines[-1], BLUE, "sent by us")
        if axis in theirs:
            lines.append(np.degrees(theirs[axis]))
            _line(panel, t, lines[-1], INK, "setpoint, PX4's log", THEIRS)
        named(panel, f"Body rate {axis}, deg/s")
        spanned(panel, *_ends(lines), 5.0)
    lines = []
    column = {OutputLevel.RATES: "sent_3", OutputLevel.ATTITUDE: "sent_4"}.get(evidence.plan.level)
    if column is not None:
        lines.append(estimated[column])
        _line(panels[3], estimated["t"], lines[-1], BLUE, "sent by us")
    if "thrust_z" in theirs:
        lines.append(-theirs["thrust_z"])
        _line(panels[3], t, lines[-1], INK, "setpoint, PX4's log", THEIRS)
    named(panels[3], "Thrust, 0..1")
    spanned(panels[3], *_ends(lines), 0.05)
    _along(panels[3], evidence)
    figure_legend(figure, panels[0])
    return figure


def motors(evidence: Evidence, topics: dict[str, LogSeries]) -> Figure:
    """The motors' commands; where we sent them, ours under PX4's."""
    figure, (panel,) = stacked([1.0], 2.4)
    estimated = evidence.estimated
    t, theirs = _within(evidence, topics.get("actuator_motors"))
    lines = []
    for number, colour in enumerate(LINES):
        if evidence.plan.level is OutputLevel.MOTORS:
            lines.append(estimated[f"sent_{number}"])
            _line(panel, estimated["t"], lines[-1], TRUE, "sent by us" if number == 0 else None, width=2.4)
        if f"motor_{number}" in theirs:
            lines.append(theirs[f"motor_{number}"])
            _line(panel, t, lines[-1], colour, f"motor {number + 1}")
    named(panel, "Commands, 0..1")
    legend(panel, 5)
    spanned(panel, *_ends(lines), 0.05)
    _along(panel, evidence)
    return figure


def _within(evidence: Evidence, topic: LogSeries | None) -> Within:
    """A topic while the path was followed, over the time of following."""
    if topic is None:
        return np.zeros(0), {}
    stamps, t = evidence.estimated["t_boot"], evidence.estimated["t"]
    rows = (topic.t >= stamps[0]) & (topic.t <= stamps[-1])
    columns = {name: values[rows] for name, values in topic.columns.items()}
    return np.interp(topic.t[rows], stamps, t), columns


def _line(
    panel: Axes, t: Array, y: Array, colour: str, label: str | None, dashes: object = "-", width: float = 1.1
) -> None:
    if len(t):
        chosen = kept(y)
        panel.plot(t[chosen], y[chosen], color=colour, linewidth=width, label=label, linestyle=dashes)


def _along(panel: Axes, evidence: Evidence) -> None:
    along_x(panel, TIME, 0.0, max(float(evidence.estimated["t"][-1]), 1e-3))


def _ends(curves: list[Array]) -> tuple[float, float]:
    values = np.concatenate(curves) if curves else np.zeros(0)
    values = values[np.isfinite(values)]
    return (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 0.0)
