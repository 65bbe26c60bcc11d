"""A log -> what it tells of the vehicle, what a better log would need, and the vehicle file with it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from companion.identification.description import Description, Entry, Source
from companion.identification.flight_data import STEP, Part, flown_parts
from companion.identification.force_fit import CURVE_RANGE_MIN, ForceFit, fit_forces
from companion.identification.rate_fit import AxisFit, Found, fit_axis
from companion.identification.ulog import Log
from companion.px4_allocation import normalised_mix
from companion.vehicle import GRAVITY

AXES = ("roll", "pitch", "yaw")
BELIEVED = 0.1
"""Standard deviation over the value up to which a value goes into the file (engineering choice)."""
WANTED = 0.05
"""The same, up to which nothing is asked of a better log."""
EXCITATION_WANTED = 0.15
"""rad/s, standard deviation of a rate setpoint that tells its loop well."""
SPEED_WANTED = 2.5
"""m/s, RMS: from here on drag shows, and is written. Engineering choice: at 0.2 to 0.9 m/s a QAV250 gave 0 to 0.5 1/s,
each +- 0.02 to 0.1."""
FLOWN_WANTED = 25.0
"""s in the air."""
TOLD_FROM = 3.0
"""Standard deviations from which on a figure that may well be none is told as found. Engineering choice: on PX4's
simulation, whose thrust knows no battery, the thrust a volt came out at -1.8 to 2.6 of them."""
BATTERY_SIGN = 0.05
"""1/V of the thrust. Only a flight that excludes it says that the thrust knows no battery. Engineering choice: half of
what the hover thrusts of a QAV250 with 4 cells show from flight to flight, 9 %."""
VOLTS_WANTED = 1.0
"""V in one flight: from here on the battery's share stands out of the thrust's slow errors (engineering choice)."""
PERIOD_WANTED = 0.008
"""s between two samples of the gyro and of the setpoints: motors of 15 ms are hardly seen with 20."""
LAG_PER_PERIOD = 2.5
"""Ratio of a motor lag to the samples' period from which on it is written. At 20 ms one QAV250 gave 19 to 44 ms from
flight to flight, each +- 2 to 4."""
YAW_INERTIA = 0.9
"""Of roll and pitch inertia together, where nobody knows it: 1 for a flat frame; x500 0.92."""


class Findings(NamedTuple):
    """``axes``: roll, pitch, yaw. ``flown``: s in the air. ``free``: the part of it without saturated motors."""

    log: Log
    parts: list[Part]
    axes: tuple[AxisFit, AxisFit, AxisFit]
    forces: ForceFit
    flown: float
    free: float

    @property
    def motor_lag(self) -> Found:
        """s, of roll, pitch and thrust together."""
        return _weighted((self.axes[0].motor_lag, self.axes[1].motor_lag, self.forces.motor_lag))

    @property
    def rate_loop_lag(self) -> Found:
        """s, of roll and pitch together."""
        return _weighted((self.axes[0].lag, self.axes[1].lag))


def identify(log: Log) -> Findings:
    """Everything that is found. CompanionError: the log holds no flight, or too little of it tells anything."""
    parts = flown_parts(log)
    cutoff = log.parameters.get("IMU_GYRO_CUTOFF", 40.0)
    roll, pitch, yaw = (fit_axis(parts, axis, cutoff) for axis in range(3))
    forces = fit_forces(parts, log.parameters, _weighted((roll.motor_lag, pitch.motor_lag)))
    flown = sum(len(part.t) for part in parts) * STEP
    free = float(np.mean(np.concatenate([part.free for part in parts])))
    return Findings(log, parts, (roll, pitch, yaw), forces, flown, free)


def _weighted(found: Sequence[Found]) -> Found:
    """Their mean by their variances; where they differ by more than they believe, that is the standard deviation. What
    was not found does not count."""
    found = [f for f in found if f.is_found] or found[:1]
    if not found[0].is_found:
        return found[0]
    values, weights = np.array([f.value for f in found]), np.array([1.0 / max(f.std, 1e-6) ** 2 for f in found])
    mean = float(values @ weights / weights.sum())
    spread = float(np.sqrt(weights @ (values - mean) ** 2 / weights.sum()))
    return Found(mean, max(spread, float(weights.sum() ** -0.5)))


def simulator_words(log: Log) -> tuple[str, ...]:
    """What is said of a log that no vehicle flew: nothing of another."""
    told = "The log is of a simulator ({}): its figures are the simulator's, not your vehicle's."
    return (told.format(log.simulator),) if log.simulator else ()


def words_of(found: Findings) -> list[str]:
    """What was found, a line each, with its standard deviation."""
    f = found.forces
    lines = [
        f"flown {found.flown:.0f} s, {100.0 * found.free:.0f} % of it without saturated motors, {f.speed:.1f} m/s RMS",
        f"hover thrust {_said(f.hover_thrust, 1.0, '')}",
        f"drag {_said(f.drag, 1.0, '1/s')}; wind times drag {math.hypot(*f.disturbance_n[:2]):.2f} m/s^2",
        f"motor lag {_said(found.motor_lag, 1e3, 'ms')}",
    ]
    for name, axis in zip(AXES, found.axes, strict=True):
        lines.append(f"{name}: {_of_axis(axis)}")
    told = found.log.parameters.get("THR_MDL_FAC", 0.0)
    if f.curve is not None:
        lines.append(f"thrust curve {_said(f.curve, 1.0, '')} (THR_MDL_FAC {told:.2g})")
        if abs(f.curve.value - told) > max(2.0 * f.curve.std, 0.1):
            lines.append(f"  THR_MDL_FAC {f.curve.value:.2g} would make thrust linear in the command")
    if f.per_volt is not None:
        lines.append(f"thrust per volt {_said(f.per_volt, 100.0, '%')} about {f.volts:.1f} V{_doubt(f.per_volt)}")
    return lines


def _doubt(per_volt: Found) -> str:
    if _tells_battery(per_volt):
        return "" if per_volt.value > TOLD_FROM * per_volt.std else ": no sign of the battery in the thrust"
    return ": this flight does not tell"


def _tells_battery(per_volt: Found) -> bool:
    """Whether the battery's share of the thrust is found, or found to be none."""
    return per_volt.value > TOLD_FROM * per_volt.std or per_volt.value + 2.0 * per_volt.std < BATTERY_SIGN


def _of_axis(axis: AxisFit) -> str:
    loop = f"rate loop lag {_said(axis.lag, 1e3, 'ms')}, gain {_said(axis.gain, 1.0, '')}"
    if axis.authority.is_found:
        return f"{loop}; a torque setpoint of 1 turns it by {_said(axis.authority, 1.0, 'rad/s^2')}"
    return f"{loop}; what torque does: not found"


def _said(found: Found, factor: float, unit: str) -> str:
    if not found.is_found:
        return "not found"
    value, std = factor * found.value, factor * found.std
    digits = max(0, 1 - math.floor(math.log10(max(std, 1e-9)))) if std < 10.0 else 0
    return f"{value:.{digits}f} +- {std:.{digits}f}" + (f" {unit}" if unit else "")


def _briefly(found: Found) -> str:
    return f"{found.value:.3g} +- {found.std:.2g}" if found.is_found else "not found"


def better_log(found: Findings) -> list[str]:
    """What another log should have, for what this one tells badly."""
    advice = []
    topics = found.log.topics
    names = ("vehicle_angular_velocity", "vehicle_rates_setpoint", "vehicle_torque_setpoint", "vehicle_acceleration")
    slow = [n for n in names if topics[n].period > PERIOD_WANTED]
    if slow:
        came = ", ".join(f"{n} came every {1e3 * topics[n].period:.0f} ms" for n in slow)
        advice.append(f"log faster: {came}; SDLOG_PROFILE 25 (default, system identification, high rate) logs each")
    if found.flown < FLOWN_WANTED:
        advice.append(f"fly longer: {found.flown:.0f} s were in the air, {FLOWN_WANTED:g} s are good")
    for name, axis in zip(AXES, found.axes, strict=True):
        doubt = max(axis.lag.relative, axis.authority.relative)
        if axis.excitation < EXCITATION_WANTED or doubt > WANTED:
            how = "turn the nose to and fro" if name == "yaw" else f"rock it about {name}, or fly a figure-eight"
            lacks = f"its setpoint moved by {axis.excitation:.2f} rad/s RMS"
            if axis.excitation >= EXCITATION_WANTED and math.isfinite(doubt):
                lacks = f"known to {100.0 * doubt:.0f} %, {100.0 * WANTED:.0f} are wanted"
            advice.append(f"more {name}: {lacks}; {how}")
    if found.forces.speed < SPEED_WANTED or found.forces.drag.std > max(WANTED * found.forces.drag.value, 0.02):
        advice.append(f"fly faster, to every side: {found.forces.speed:.1f} m/s RMS tell little of drag")
    if found.forces.curve is None:
        advice.append(
            f"climb and sink briskly: thrust moved by {100.0 * found.forces.thrust_spread:.0f} %, "
            f"{100.0 * CURVE_RANGE_MIN:.0f} are needed to see the thrust curve (THR_MDL_FAC)"
        )
    if found.forces.per_volt is None or not _tells_battery(found.forces.per_volt):
        advice.append(f"fly the battery down by {VOLTS_WANTED:g} V and more, to see what it does to the thrust")
    if found.free < 0.8:
        advice.append(f"fly gentler: motors were at their limits for {100.0 * (1.0 - found.free):.0f} % of the time")
    if found.log.lost > 0.1:
        advice.append(f"use a faster card: {found.log.lost:.1f} s were not logged")
    return advice


def with_findings(base: Description, found: Findings, origin: tuple[str, ...]) -> Description:
    """``base`` with every value that the log tells well; the others stay, and the notes say so."""
    data = base.data
    entries: dict[str, Any] = {}
    kept: list[str] = []

    def take(key: str, what: Found, words: str, digits: int = 4) -> None:
        if what.relative < BELIEVED:
            entries[key] = Entry(float(f"{what.value:.{digits}g}"), Source.LOG, words)
        else:
            kept.append(f"{key} ({_briefly(what)})")

    f, (roll, pitch, yaw) = found.forces, found.axes
    take("hover_thrust", f.hover_thrust, f"+- {f.hover_thrust.std:.2g}, 0..1")
    hidden = _hides_motor_lag(found)
    if hidden:
        kept.append(f"motor_lag_s ({_briefly(found.motor_lag)}; {hidden})")
    else:
        take("motor_lag_s", found.motor_lag, f"+- {found.motor_lag.std:.2g} s", 3)
    lag = found.rate_loop_lag
    each = ", ".join(f"{name} {_said(axis.lag, 1e3, 'ms')}" for name, axis in zip(AXES, (roll, pitch), strict=False))
    words = f"+- {lag.std:.2g} s; {each}"
    take("rate_loop_lag_s", lag, words, 3)
    if f.speed >= SPEED_WANTED and f.drag.std < max(BELIEVED * f.drag.value, 0.03):
        entries["drag_per_s"] = Entry(float(f"{max(f.drag.value, 0.0):.3g}"), Source.LOG, f"+- {f.drag.std:.2g} 1/s")
    else:
        slow = f"; {f.speed:.1f} m/s RMS, {SPEED_WANTED:g} tell it" if f.speed < SPEED_WANTED else ""
        kept.append(f"drag_per_s ({_briefly(f.drag)}{slow})")
    hover = entries.get("hover_thrust")
    if hover is not None and max(roll.authority.relative, pitch.authority.relative, yaw.authority.relative) < BELIEVED:
        entries |= _turning(base, data, hover.value, found)
    else:
        kept.append("inertia_kgm2 and torque_per_thrust_m")
    notes = ["", "The log:", *(f"  {line}" for line in words_of(found))]
    if kept:
        notes.append(f"  not told well enough, and left as it was: {', '.join(kept)}")
    return Description(base.name, origin, {**base.entries, **entries}, (*base.notes, *notes))


def _hides_motor_lag(found: Findings) -> str:
    """Why the log cannot tell the motors' lag, however sure the fit is; empty where it can."""
    period = max(found.log.topics[name].period for name in ("vehicle_angular_velocity", "vehicle_torque_setpoint"))
    if found.motor_lag.value < LAG_PER_PERIOD * period:
        return f"samples every {1e3 * period:.0f} ms tell none under {1e3 * LAG_PER_PERIOD * period:.0f} ms"
    moved = min(axis.excitation for axis in found.axes[:2])
    if moved < EXCITATION_WANTED:
        return f"roll or pitch moved by {moved:.2f} rad/s RMS, {EXCITATION_WANTED:g} tell it"
    return ""


def _turning(base: Description, data: Mapping[str, Any], hover: float, found: Findings) -> dict[str, Any]:
    """Thrust, inertia and reaction torque, of the mass in the file and the angular acceleration of a torque setpoint.
    Where somebody knows the inertia about yaw it stays, and the reaction torque follows; only their ratio shows."""
    roll, pitch, yaw = (axis.authority for axis in found.axes)
    each = data["mass_kg"] * GRAVITY / hover / 4.0
    levers = unit_torques(data["rotors"])
    guessed = base.entries["inertia_kgm2"].source is Source.ASSUMED
    if guessed:
        jx, jy = each * levers[0] / roll.value, each * levers[1] / pitch.value
        inertia = [float(f"{j:.3g}") for j in (jx, jy, YAW_INERTIA * (jx + jy))]
    else:
        inertia = data["inertia_kgm2"]
    torque = float(f"{yaw.value * inertia[2] / (each * levers[2]):.3g}")
    spread = f"+- {100.0 * max(roll.relative, pitch.relative):.1f} % beside the mass"
    entries: dict[str, Any] = {}
    if guessed:
        words = f"kg m^2; roll and pitch {spread}; yaw {YAW_INERTIA:g} of their sum"
        entries["inertia_kgm2"] = Entry(inertia, Source.LOG, words)
    rows = []
    for i, (row, old) in enumerate(zip(data["rotors"], base.entries["rotors"], strict=True)):
        new = {**row, "thrust_max_n": float(f"{each:.4g}"), "torque_per_thrust_m": torque}
        told = "thrust by mass and hover thrust, torque by the yaw of a torque setpoint"
        source = Source.ASSUMED if old.source is Source.ASSUMED else Source.LOG
        rows.append(Entry(new, source, f"{told}; places {old.words.split(';')[0]}" if i == 0 else old.words))
    entries["rotors"] = rows
    return entries


def unit_torques(rotors: Sequence[Mapping[str, Any]]) -> tuple[float, float, float]:
    """m: what a torque setpoint of 1 gives about each axis, over the thrust of one motor at full command and, about
    yaw, over the reaction torque over thrust, by PX4's normalisation."""
    places = [row["position_m"] for row in rotors]
    spins = [1.0 if row["spin"] == "ccw" else -1.0 for row in rotors]
    effect = np.array([(-p[1], p[0], s, -1.0) for p, s in zip(places, spins, strict=True)]).T
    roll, pitch, yaw, _ = np.diag(effect @ normalised_mix(effect)).tolist()
    return roll, pitch, yaw
