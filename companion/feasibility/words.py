"""The report in plain words, for whoever is about to fly."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from companion.feasibility.geometry import STRAIGHT
from companion.feasibility.limits import Limit
from companion.feasibility.report import SCALE_MAX, Report
from companion.profiles import ConstantSpeed

LABELS = {
    "thrust_n": ("thrust", "N", 1),
    "tilt_deg": ("tilt", "deg", 1),
    "motor": ("motor", "%", 0),
    "body_rate_dps": ("turning", "deg/s", 0),
    "yaw_rate_dps": ("heading rate", "deg/s", 0),
    "yaw_acceleration_dps2": ("heading acceleration", "deg/s2", 0),
    "speed_mps": ("speed", "m/s", 1),
    "path_radius_m": ("tightest bend", "m", 2),
    "regularity": ("regularity of the law", "", 3),
    "vdot_over_g": ("acceleration over g", "", 2),
    "ground_clearance_m": ("height above ground", "m", 1),
    "fence_m": ("distance to the fence", "m", 1),
    "speed_jump_percent": ("speed's jump where it closes", "%", 1),
    "yaw_jump_deg": ("heading's jump where it closes", "deg", 1),
}
"""name -> what a person calls it, its unit, and how many digits are worth reading."""
LEAST = frozenset({"path_radius_m", "regularity", "ground_clearance_m", "fence_m"})
"""What must be more than its limit."""
ON_THE_GROUND = 0.05
"""m: a height that is written as 0.0 lies on the ground, not under it."""
COLUMN = 32
"""characters of a line's name."""


def headline(report: Report) -> str:
    """The answer in one sentence (or two)."""
    who = f"{report.mission.name} on {report.vehicle.name}"
    if report.feasible:
        return f"{who}: can be flown."
    broken = max((limit for limit in report.deciding if not limit.ok), key=lambda limit: limit.used)
    verdict = "cannot be flown like this."
    if report.may_be_flown:
        verdict = "cannot quite be flown like this."
        if report.heading_gives_way:
            verdict = "cannot be flown like this; the path can, and the heading gives way."
    return f"{who}: {verdict} {why(report, broken)}"


def why(report: Report, limit: Limit) -> str:
    """What is asked for too much, and where: a sentence."""
    most = "" if limit.limit is None else _number(limit.name, limit.limit)
    value = _number(limit.name, limit.worst)
    match limit.name:
        case "motor" if limit.worst < 0.0:
            what = f"{limit.part.capitalize()} would have to pull downwards"
        case "motor":
            what = f"{limit.part.capitalize()} would need {value} of its range"
        case "tilt_deg":
            what = f"It would tilt by {value}; {most} is the limit"
        case "thrust_n" if limit.limit is not None and limit.worst < limit.limit:
            what = f"It would fall with only {value} of thrust; {most} is the least that keeps it steerable"
        case "body_rate_dps":
            what = f"It would turn about its {limit.part} axis at {value}; {most} is the limit"
        case "path_radius_m":
            what = f"The path bends to a radius of {value}; {most} is the least that can be held"
        case "regularity":
            what = "The law is singular: it falls freely, lies on its side, or h1 and h2 leave the direction open"
        case "ground_clearance_m" if limit.worst < -ON_THE_GROUND:
            what = f"The path leads {-limit.worst:.1f} m below the ground ({report.mission.up_in_words})"
        case "ground_clearance_m":
            what = f"The path leads only {value} above the ground; {most} is the least"
        case "fence_m" if limit.worst < 0.0:
            what = f"The path leaves the fence by {-limit.worst:.1f} m"
        case "fence_m":
            what = f"The path comes within {value} of the fence; {most} is the least"
        case "speed_jump_percent":
            what = f"Where the path closes, the speed jumps by {value} of its largest"
        case "yaw_jump_deg":
            what = f"Where the path closes, the heading jumps by {value}"
        case _:
            what = f"It would need {value} of {LABELS[limit.name][0]}; {most} is the limit"
    return f"{what}, {where(report, limit.at_s)}."


def against(limit: Limit) -> str:
    """What is asked and what is allowed."""
    worst, most = (_number(limit.name, value) for value in (limit.worst, limit.limit or 0.0))
    if limit.limit is None:
        return f"{_named(limit)}: {worst}, no limit"
    return f"{_named(limit)}: {worst}, {'at least' if limit.name in LEAST else 'at most'} {most}"


def where(report: Report, s: float) -> str:
    """A place along the path, in the mission's own coordinates."""
    x, y, z = report.mission.placement.to_mission(report.mission.table.at(s)[0])
    return f"{s:.1f} m along the path (x {x:z.1f}, y {y:z.1f}, z {z:z.1f})"


def in_words(report: Report, places: Sequence[str] = (), warnings: Sequence[str] = (), air: str | None = None) -> str:
    """The whole report, for a terminal. ``places``: where the path runs, ``warnings``: what is likely not meant there;
    sentences. ``air``: the world it was looked at in, where one was asked for."""
    lines = [headline(report), *(f"WARNING: {warning}" for warning in warnings), ""]
    for name, text in (
        ("path", _path(report)),
        *(("where" if i == 0 else "", line) for i, line in enumerate(places)),
        *(() if air is None else (("in the air of", air),)),
        ("time", _time(report)),
        ("speed", _speed(report)),
        ("how fast at most", _at_most(report)),
        ("tightest place", _tightest(report)),
        ("the paper", _paper(report)),
    ):
        lines.append(f"  {name:18}{text}")
    lines += ["", f"  {'':{COLUMN}}{'worst':>14}{'limit':>14}{'used':>7}   where"]
    for limit in (*report.limits, *report.others):
        lines.append(_row(limit))
    return "\n".join(lines)


def _path(report: Report) -> str:
    return f"{report.length:.1f} m, {'closed' if report.mission.closed else 'open'}"


def _time(report: Report) -> str:
    mission = report.mission
    if not mission.closed:
        return f"{_seconds(report.duration)} from rest at one end to rest at the other" + (
            ", then back again" if mission.repeat else ""
        )
    laps = (
        ""
        if mission.laps is None or mission.laps == 1.0
        else f"; {mission.laps:g} laps {_seconds(mission.laps * report.duration)}"
    )
    return f"{_seconds(report.duration)} a lap{laps}"


def _speed(report: Report) -> str:
    speed = np.abs(report.at.alpha[0])
    found = ", the fastest this vehicle can keep" if report.auto else ""
    if isinstance(report.mission.speed, ConstantSpeed) or float(np.ptp(speed)) < 1e-9:
        return f"{speed[0]:.2f} m/s{found}"
    slow, fast = int(np.argmin(speed)), int(np.argmax(speed))
    s = report.at.s
    return f"{speed[slow]:.2f} m/s (at {s[slow]:.1f} m) to {speed[fast]:.2f} m/s (at {s[fast]:.1f} m){found}"


def _at_most(report: Report) -> str:
    scale, limit = report.speed_scale_max, report.at_most
    if scale == 0.0:
        return f"at no speed: {LABELS[limit.name][0]}, see above"
    if scale >= SCALE_MAX:
        return f"more than {SCALE_MAX:g} times this speed"
    fastest = scale * float(np.max(np.abs(report.at.alpha[0])))
    place = where(report, limit.at_s)
    return f"{scale:.2f} times this speed, up to {fastest:.1f} m/s; then {_named(limit)} is at its limit {place}"


def _tightest(report: Report) -> str:
    limit = report.tightest
    return f"{against(limit)}, {where(report, limit.at_s)}"


def _paper(report: Report) -> str:
    g = report.vehicle.gravity
    if report.proposition_4_2:
        return f"largest acceleration {report.max_vdot:.2f} m/s2 < g: Proposition 4.2 holds"
    return (
        f"largest acceleration {report.max_vdot:.2f} m/s2 >= g = {g:.2f}: Proposition 4.2 does not promise regularity "
        "(it is sufficient, not necessary; the limits below decide)"
    )


def _row(limit: Limit) -> str:
    label, unit, _ = LABELS[limit.name]
    most = "none" if limit.limit is None else _number(limit.name, limit.limit)
    used = "" if limit.limit is None else _percent(limit.used)
    mark = "" if limit.ok else "  too much" if limit.name != "vdot_over_g" else ""
    part = f" ({limit.part})" if limit.part and unit != "%" else ""
    name = limit.part if limit.part and unit == "%" else f"{label}{part}"
    worst = _number(limit.name, limit.worst)
    return f"  {name:{COLUMN}}{worst:>14}{most:>14}{used:>7}   {limit.at_s:.1f} m{mark}"


def _named(limit: Limit) -> str:
    return limit.part if limit.name == "motor" else LABELS[limit.name][0] + (f" ({limit.part})" if limit.part else "")


def _number(name: str, value: float) -> str:
    _, unit, digits = LABELS[name]
    if name == "path_radius_m" and value >= STRAIGHT:
        return "straight"
    scaled = 100.0 * value if name == "motor" else value
    return "without end" if not math.isfinite(scaled) else f"{scaled:z.{digits}f} {unit}".strip()


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share < 99.0 else "> 9900 %"


def _seconds(duration: float) -> str:
    if duration < 120.0:
        return f"{duration:.1f} s"
    return f"{int(duration) // 60} min {int(duration) % 60:02d} s"
