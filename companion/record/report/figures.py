"""The figures of a page in their order, each as inline SVG with the sentence that says what to see in it."""

from __future__ import annotations

import io
import re
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from companion.record.report import errors, maps, marks, motion, vehicle, zoom
from companion.record.report.evidence import Evidence
from companion.record.report.page import Picture, Section
from companion.record.report.style import drawing
from companion.record.report.text import escaped, event_sentences, number_text
from companion.record.ulog.joined import VehicleLog
from companion.vehicle import OutputLevel

NOT_FOLLOWED = Section(
    "Following", ["The flight never came to follow its path, so there are no errors, commands or timing to show."], []
)


def figure_sections(evidence: Evidence) -> list[Section]:
    """Every figure, or the words that stand in its place."""
    with drawing():
        if not evidence.has_following:
            return [_track(evidence), NOT_FOLLOWED]
        found = [_estimates(evidence)] if vehicle.has_estimates(evidence) else []
        found += [] if evidence.vehicle_log is None else [_vehicle_log(evidence, evidence.vehicle_log)]
        return [_track(evidence), _errors(evidence), _motion(evidence), *found, _timing(evidence)]


STILL_ONLY = ("space", "gaps", "latency")
"""Pictures without a chart to zoom into: the one in space, and the histograms."""


def _picture(name: str, draw: Callable[[], Figure], caption: str) -> Picture:
    figure = draw()
    svg = inline(figure, name, caption)
    return Picture(name, svg, caption, None if name in STILL_ONLY else zoom.chart(figure))


def _track(evidence: Evidence) -> Section:
    title = "Path and track"
    if not evidence.has_following and not (evidence.table["fresh"] == 1).any():
        return Section(title, ["The companion saw no state of the vehicle, so there is no track to draw."], [])
    if evidence.has_following:
        ghost = marks.timetable(evidence) is not None
        above_caption = "From above: the path (dashed) and the track that was flown, coloured by its speed." + (
            " Dotted: where a reference on a timetable would have run while the vehicle was held." if ghost else ""
        )
        space_caption = "In space: the same track, coloured by its distance to the path, whose shadow is on the floor."
    else:
        above_caption = "From above: the path it was to follow, and where the vehicle was (a square at the end)."
        space_caption = "In space: the path it was to follow, its shadow on the floor, and where the vehicle was."
    return Section(
        title,
        event_sentences(evidence),
        [
            _picture("above", lambda: maps.from_above(evidence), above_caption),
            _picture("space", lambda: maps.in_space(evidence), space_caption),
        ],
    )


def _errors(evidence: Evidence) -> Section:
    title = "The three goals"
    true = "; the broad pale line is the plant’s true state" if evidence.true else ""
    shades = marks.legend_words(evidence)
    time = f"Over time: how fast the errors of path, speed and yaw go away, and what stays of them{true}.{shades}"
    flown = "Speed and heading themselves; dashed, what the mission asks for at the place where the vehicle is."
    along, leaves = errors.over_path(evidence)
    approach = ", while the approach to it leaves the frame" if leaves else ""
    place = f"Along the path: where the errors arise, lap over lap, on the scale of the settled flight{approach}."
    raised = f", also in the {number_text(evidence.plan.ramp_time)} s in which the vehicle is brought up to it"
    words = [
        "G1: converge to the path; the path error is the distance to it. G2: fly at the mission’s speed; the speed "
        f"error counts against that speed from the first moment on{raised if evidence.plan.ramp_time > 0.0 else ''}. "
        "G3: face where the mission says."
    ]
    return Section(
        title,
        words,
        [
            _picture("errors-time", lambda: errors.over_time(evidence), time),
            _picture("errors-path", lambda: along, place),
            _picture("speed-yaw", lambda: errors.speed_and_heading(evidence), flown),
        ],
    )


def _motion(evidence: Evidence) -> Section:
    level = evidence.plan.level
    title = "Attitude, thrust and " + ("motors" if level is OutputLevel.MOTORS else "body rates")
    shown = {
        OutputLevel.MOTORS: "roll, pitch, thrust and motor commands, as in the paper’s Figs. 3 and 4",
        OutputLevel.TORQUES: "roll, pitch, thrust, and the body rates that came of the torques",
        OutputLevel.RATES: "roll, pitch, thrust, and the body rates that were asked for and measured",
        OutputLevel.ATTITUDE: "roll and pitch as asked for and measured, thrust, and the body rates that came of it",
    }[level]
    negative = level is OutputLevel.MOTORS and _goes_negative(evidence)
    below = "; in the red band a motor would have to pull" if negative else ""
    thrusts = {rotor.thrust_max for rotor in evidence.plan.vehicle.rotors}
    words = (
        [f"A motor’s command is shown as the force it asks for: a command of 1 is {number_text(thrusts.pop())} N."]
        if level is OutputLevel.MOTORS and len(thrusts) == 1
        else []
    )
    pictures = [
        _picture(
            "motion", lambda: motion.motion_figure(evidence, motion.whole(evidence)), f"All of it: {shown}{below}."
        )
    ]
    late = motion.last_lap(evidence)
    if late is not None:
        window, lap = late
        name = "The last lap" if lap else "The settled part"
        caption = f"{name}, each axis on its own scale: what the path itself asks of the vehicle."
        pictures.append(_picture("motion-late", lambda: motion.motion_figure(evidence, window), caption))
    return Section(title, words, pictures)


def _goes_negative(evidence: Evidence) -> bool:
    return any(float(evidence.estimated[f"sent_{i}"].min()) < 0.0 for i in range(4))


def _estimates(evidence: Evidence) -> Section:
    estimated = evidence.estimated
    slowest = float(np.nanmin(estimated["pace"])) if np.isfinite(estimated["pace"]).any() else 1.0
    words = []
    if slowest < 0.995:
        share = 100.0 * float(np.mean(estimated["pace"] < 0.995))
        words.append(
            f"For {number_text(share)} % of the time the vehicle flew slower than the mission says, down to "
            f"{number_text(100.0 * slowest)} % of its speed: there the path asked for more than its limits allow."
        )
    machine = "The vehicle itself: the scale of its thrust and its drag as steering estimates them; dotted, its file."
    around = (
        "What else pushes it, and the delays that steering reckons with; dotted, the rate loop of the vehicle file."
    )
    pictures = [
        _picture("machine", lambda: vehicle.machine(evidence), machine),
        _picture("surroundings", lambda: vehicle.surroundings(evidence), around),
    ]
    return Section("What it learned about the vehicle", words, pictures)


def _vehicle_log(evidence: Evidence, log: VehicleLog) -> Section:
    offset, correlation, overlap = log.alignment
    words = [
        f"{log.file}, the vehicle’s ULog, joined by the body rates that both hold: correlation {correlation:.3f} over "
        f"{number_text(overlap)} s, its clock {number_text(1e3 * offset)} ms from the stamps of the states."
    ]
    pictures = [
        _picture("px4-estimate", lambda: vehicle.px4_estimate(evidence, log.topics),
                 "PX4’s estimate beside the states that reached us."),
        _picture("px4-setpoints", lambda: vehicle.px4_setpoints(evidence, log.topics),
                 "What we sent, the setpoint that PX4 flew by, and the body rates that came of it."),
        _picture("px4-motors", lambda: vehicle.px4_motors(evidence, log.topics), "What PX4 told its motors."),
    ]  # fmt: skip
    return Section("Beside PX4’s own log", words, pictures)


def _timing(evidence: Evidence) -> Section:
    title = "The loop"
    gaps, latencies = motion.setpoint_gaps(evidence), motion.latencies(evidence)
    if len(gaps) == 0:
        return Section(title, ["No setpoints went out while following, so there is no timing to show."], [])
    words, pictures = [], []
    rate = evidence.number("loop", "rate_hz")
    if float(gaps.max() - gaps.min()) < motion.STEADY:
        words.append(
            f"Setpoints went out every {number_text(1e3 * float(gaps.mean()))} ms without exception"
            + (f", {rate:.0f} a second" if rate is not None else "")
            + "."
        )
    else:
        half, most = sorted(gaps)[len(gaps) // 2], float(gaps.max())
        caption = (
            f"Time from one setpoint to the next: {number_text(1e3 * float(half))} ms in the middle, "
            f"{number_text(1e3 * most)} ms at most."
        )
        pictures.append(_picture("gaps", lambda: motion.histogram(1e3 * gaps, "gap between setpoints", "ms"), caption))
    if len(latencies):
        p50, p99, top = (evidence.number("loop", "latency_us", key) for key in ("p50", "p99", "max"))
        of_the_loop = (
            f": {number_text(p50 / 1e3)} ms in the middle, {number_text(p99 / 1e3)} ms or less in 99 of 100, "
            f"{number_text(top / 1e3)} ms at most"
            if p50 is not None and p99 is not None and top is not None
            else ""
        )
        caption = f"Time from the arrival of a state to the return of its setpoint’s send{of_the_loop}."
        pictures.append(
            _picture("latency", lambda: motion.histogram(1e3 * latencies, "state to setpoint", "ms"), caption)
        )
    elif evidence.lockstep:
        words.append(
            "This flight was simulated in lockstep: its clock stands still while the companion computes, so there is "
            "no latency to measure. Fly it in real time to see one."
        )
    else:
        words.append("No latency was recorded.")
    return Section(title, words, pictures)


_FONT = re.compile(r"font: (?P<weight>(?:bold |[0-9]+ )?)(?P<style>(?:italic |oblique )?)(?P<size>[\d.]+px) [^;\"]*")
_LONG = re.compile(r"-?\d+\.\d{3,}")
_TAG = re.compile(r"<[^>]+>")
_ID = re.compile(r'(?P<before>\bid="|href="#|url\(#)(?P<name>[^")]+)')
_NAMED_GROUP = re.compile(r'<g id="[a-zA-Z]\w*_\d+">')


def inline(figure: Figure, name: str, description: str) -> str:
    """``figure`` as an <svg> element. ``name``: unique in the page; ``description``: for those who cannot see it."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    body = re.sub(r"<!--.*?-->", "", body, flags=re.DOTALL)
    body = body.replace("xlink:href", "href")
    body = _NAMED_GROUP.sub("<g>", body)
    # ids are the page's, not the figure's: two figures may not share one
    body = _ID.sub(lambda found: f"{found['before']}{name}-{found['name']}", body)
    body = _FONT.sub(_font, body)
    # a hundredth of a point is finer than any eye and any printer
    body = _TAG.sub(lambda tag: _LONG.sub(lambda found: f"{float(found[0]):.2f}", tag[0]), body)
    body = re.sub(r"\s*\n\s*", "\n", body).strip()
    width, height = (72.0 * inches for inches in figure.get_size_inches())
    return (
        f'<svg viewBox="0 0 {width:.0f} {height:.0f}" role="img" aria-label="{escaped(description)}">\n{body}\n</svg>'
    )


def _font(found: re.Match[str]) -> str:
    weight = found["weight"].strip()
    return (f"font-weight: {weight}; " if weight else "") + f"font-size: {found['size']}"
