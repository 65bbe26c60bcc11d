"""What was estimated of the vehicle; and PX4's own curves from its log beside ours."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.record.report.curves import DASHED, DOTTED, draw_curve, ends, label_time
from companion.record.report.evidence import Array, Evidence, Series
from companion.record.report.palette import BLUE, FAINT, GREEN, INK, LINES, TRUE, VERMILION
from companion.record.report.style import figure_legend, legend, name_y, span_y, stack_panels
from companion.record.series import roll_pitch
from companion.record.ulog.reading import LogSeries
from companion.record.ulog.topics import BODY_RATES
from companion.vehicle import OutputLevel

HEIGHT = 3.6
"""inches, of the figures of estimates."""
Within = tuple[Array, Series]
"""s of following, and the columns."""


def has_estimates(evidence: Evidence) -> bool:
    """Whether the level that was flown estimates anything, and the record holds it."""
    return "thrust_scale" in evidence.estimated and bool(np.isfinite(evidence.estimated["thrust_scale"]).any())


def machine(evidence: Evidence) -> Figure:
    """Of the vehicle itself, over the time of following; dotted what its file says."""
    figure, (scale, drag) = stack_panels([1.0, 1.0], HEIGHT)
    estimated, vehicle = evidence.estimated, evidence.plan.vehicle
    _draw_estimate(scale, estimated, "thrust_scale", 1.0, "Thrust made over thrust asked for", 0.04)
    _draw_estimate(drag, estimated, "drag", vehicle.drag, "Drag, 1/s", 0.05)
    label_time(drag, 0.0, evidence.following_s)
    return figure


def surroundings(evidence: Evidence) -> Figure:
    """What else pushes it, and how late everything comes."""
    figure, (disturbance, delay) = stack_panels([1.0, 1.0], HEIGHT)
    estimated, lag = evidence.estimated, 1e3 * evidence.plan.vehicle.rate_loop_lag
    lines = []
    for name, colour in (("north", BLUE), ("east", VERMILION), ("down", GREEN)):
        lines.append(estimated[f"push_{name}"])
        draw_curve(disturbance, estimated["t"], lines[-1], colour, name)
    name_y(disturbance, "Disturbance, m/s²")
    legend(disturbance)
    span_y(disturbance, *ends(lines), 0.2)
    lines = [np.array([lag])]
    for column, name, colour in (
        ("delay", "state to effect", BLUE), ("rate_lag", "rate loop", VERMILION), ("motor_lag", "motors", GREEN),
    ):  # fmt: skip
        if column in estimated and np.isfinite(estimated[column]).any():
            lines.append(1e3 * estimated[column])
            draw_curve(delay, estimated["t"], lines[-1], colour, name)
    delay.axhline(lag, color=FAINT, linewidth=0.8, linestyle=DOTTED)
    name_y(delay, "Delays, ms")
    legend(delay)
    span_y(delay, *ends(lines), 10.0)
    label_time(delay, 0.0, evidence.following_s)
    return figure


def _draw_estimate(panel: Axes, estimated: Series, column: str, file: float, name: str, least: float) -> None:
    values = estimated[column]
    draw_curve(panel, estimated["t"], values, BLUE, "estimated")
    panel.axhline(file, color=FAINT, linewidth=0.8, linestyle=DOTTED, label="vehicle file")
    name_y(panel, name)
    legend(panel)
    span_y(panel, *ends([values, np.array([file])]), least)


def px4_estimate(evidence: Evidence, topics: dict[str, LogSeries]) -> Figure:
    """PX4's estimate beside the states that reached us: place apart, roll and pitch over one another."""
    figure, (apart, angles) = stack_panels([1.0, 1.2], 3.8)
    estimated = evidence.estimated
    t, theirs = _within(evidence, topics.get("vehicle_local_position"))
    lines = []
    for name, colour in zip(("north", "east", "down"), LINES, strict=False):
        if name in theirs:
            lines.append(100.0 * (theirs[name] - np.interp(t, estimated["t"], estimated[name])))
            draw_curve(apart, t, lines[-1], colour, name, 1.1)
    name_y(apart, "Place in PX4's log less the one received, cm")
    legend(apart)
    span_y(apart, *ends(lines), 2.0)
    t, theirs = _within(evidence, topics.get("vehicle_attitude"))
    lines = [np.degrees(estimated[name]) for name in ("roll", "pitch")]
    for values, name, colour in zip(lines, ("roll", "pitch"), (BLUE, VERMILION), strict=True):
        draw_curve(angles, estimated["t"], values, colour, name, 1.1)
    if len(theirs) == 4:
        for values, label in zip(
            roll_pitch(*(theirs[f"q_{axis}"] for axis in "wxyz")), ("PX4's log", None), strict=True
        ):
            lines.append(np.degrees(values))
            draw_curve(angles, t, lines[-1], INK, label, 1.1, DASHED)
    name_y(angles, "Roll and pitch, deg")
    legend(angles)
    span_y(angles, *ends(lines), 2.0)
    label_time(angles, 0.0, evidence.following_s)
    return figure


def px4_setpoints(evidence: Evidence, topics: dict[str, LogSeries]) -> Figure:
    """Body rates and thrust: what we sent, what PX4 flew by, and the rates that came of it."""
    figure, panels = stack_panels([0.7, 0.7, 0.7, 0.8], 5.4)
    estimated = evidence.estimated
    t, theirs = _within(evidence, topics.get("vehicle_rates_setpoint"))
    measured_t, measured = _within(evidence, topics.get(BODY_RATES))
    sends_rates = evidence.plan.level is OutputLevel.RATES
    for number, (panel, axis) in enumerate(zip(panels, "pqr", strict=False)):
        lines = []
        if axis in measured:
            lines.append(np.degrees(measured[axis]))
            draw_curve(panel, measured_t, lines[-1], TRUE, "measured, PX4's log", 2.4)
        if sends_rates:
            lines.append(np.degrees(estimated[f"sent_{number}"]))
            draw_curve(panel, estimated["t"], lines[-1], BLUE, "sent by us", 1.1)
        if axis in theirs:
            lines.append(np.degrees(theirs[axis]))
            draw_curve(panel, t, lines[-1], INK, "setpoint, PX4's log", 1.1, DASHED)
        name_y(panel, f"Body rate {axis}, deg/s")
        span_y(panel, *ends(lines), 5.0)
    lines = []
    column = {OutputLevel.RATES: "sent_3", OutputLevel.ATTITUDE: "sent_4"}.get(evidence.plan.level)
    if column is not None:
        lines.append(estimated[column])
        draw_curve(panels[3], estimated["t"], lines[-1], BLUE, "sent by us", 1.1)
    if "thrust_z" in theirs:
        lines.append(-theirs["thrust_z"])
        draw_curve(panels[3], t, lines[-1], INK, "setpoint, PX4's log", 1.1, DASHED)
    name_y(panels[3], "Thrust, 0..1")
    span_y(panels[3], *ends(lines), 0.05)
    label_time(panels[3], 0.0, evidence.following_s)
    figure_legend(figure, panels[0])
    return figure


def px4_motors(evidence: Evidence, topics: dict[str, LogSeries]) -> Figure:
    """The motors' commands; where we sent them, ours under PX4's."""
    figure, (panel,) = stack_panels([1.0], 2.4)
    estimated = evidence.estimated
    t, theirs = _within(evidence, topics.get("actuator_motors"))
    lines = []
    for number, colour in enumerate(LINES):
        if evidence.plan.level is OutputLevel.MOTORS:
            lines.append(estimated[f"sent_{number}"])
            draw_curve(panel, estimated["t"], lines[-1], TRUE, "sent by us" if number == 0 else None, 2.4)
        if f"motor_{number}" in theirs:
            lines.append(theirs[f"motor_{number}"])
            draw_curve(panel, t, lines[-1], colour, f"motor {number + 1}", 1.1)
    name_y(panel, "Commands, 0..1")
    legend(panel, 5)
    span_y(panel, *ends(lines), 0.05)
    label_time(panel, 0.0, evidence.following_s)
    return figure


def _within(evidence: Evidence, topic: LogSeries | None) -> Within:
    """A topic while the path was followed, over the time of following."""
    if topic is None:
        return np.zeros(0), {}
    stamps, t = evidence.estimated["t_boot"], evidence.estimated["t"]
    rows = (topic.t >= stamps[0]) & (topic.t <= stamps[-1])
    columns = {name: values[rows] for name, values in topic.columns.items()}
    return np.interp(topic.t[rows], stamps, t), columns
