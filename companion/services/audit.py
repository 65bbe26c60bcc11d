"""The parameters that decide how a flight ends when something goes wrong: what is set, what we advise, and why."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from typing import NamedTuple

from companion.flight.output import FATAL_ON_LOSS, HOLD_ON_LOSS, LOSS_TIME_MAX, SANE_ON_LOSS, exceeds

Values = Mapping[str, float]


class Weight(enum.Enum):
    """How much a finding weighs: as it should be, better otherwise, or not to be flown with."""

    FINE = "fine"
    ADVICE = "advice"
    DANGER = "danger"


class Finding(NamedTuple):
    """``now``: what is set, None where the vehicle does not have it; ``said``: the same with its name or unit.
    ``advised``: in words, with the reason ``why``."""

    parameter: str
    now: float | None
    weight: Weight
    advised: str
    why: str
    said: str


class Rule(NamedTuple):
    """``judge``: the weight of a value, beside all the others. ``elsewhere``: the parameter that says the same in
    other versions of PX4; where that is there and this is not, there is nothing to say."""

    parameter: str
    judge: Callable[[float, Values], Weight]
    advised: str
    why: str
    elsewhere: str | None = None


_ON_LOSS = {1: "Hold", 2: "Return", 3: "Land", 5: "Terminate", 6: "Disarm"}
"""NAV_RCL_ACT and NAV_DLL_ACT in words."""
NAMES: dict[str, dict[int, str]] = {
    "COM_OBL_RC_ACT": {2: "Stabilized", **SANE_ON_LOSS, **FATAL_ON_LOSS},
    "NAV_RCL_ACT": {**_ON_LOSS, 7: "Hold, without a failsafe"},
    "COM_RC_OVERRIDE": {0: "never", 1: "in auto modes", 2: "in offboard", 3: "in auto modes and offboard"},
    "NAV_DLL_ACT": {0: "nothing", **_ON_LOSS},
    "COM_LOW_BAT_ACT": {0: "only a warning", 1: "Return", 2: "Land", 3: "Return, then Land"},
    "GF_ACTION": {0: "nothing", 1: "only a warning", 2: "Hold", 3: "Return", 4: "Terminate", 5: "Land"},
}
"""What PX4's numbers mean: the values of its parameter reference (v1.15); NAV_RCL_ACT 7 from 1.18 on."""
UNITS = {
    "COM_OF_LOSS_T": "s", "GF_MAX_HOR_DIST": "m", "GF_MAX_VER_DIST": "m", "RTL_RETURN_ALT": "m", "RTL_DESCEND_ALT": "m",
    "MAN_OVERRIDE_SPD": "1/s",
    "MIS_TAKEOFF_ALT": "m", "FD_FAIL_R": "deg", "FD_FAIL_P": "deg", "IMU_GYRO_RATEMAX": "Hz",
}  # fmt: skip


def in_words(parameter: str, value: float | None) -> str:
    """A value as a person reads it: ``2 (Return)``, ``0.5 s``."""
    if value is None:
        return "-"
    number = f"{value:g}"
    if parameter in NAMES:
        return f"{number} ({NAMES[parameter].get(int(value), 'not known to us')})"
    return f"{number} {UNITS[parameter]}" if parameter in UNITS else number


def _when(good: Callable[[float, Values], bool], otherwise: Weight) -> Callable[[float, Values], Weight]:
    return lambda value, values: Weight.FINE if good(value, values) else otherwise


FLOWN_BY_STICKS = {0, 1}
"""Codes of COM_OBL_RC_ACT, Position and Altitude. Killed on the circle without sticks: docs/px4-versions.md."""


def _on_loss(value: float, values: Values) -> Weight:
    if int(value) in FATAL_ON_LOSS:
        return Weight.DANGER
    return Weight.FINE if int(value) in SANE_ON_LOSS.keys() - FLOWN_BY_STICKS else Weight.ADVICE


def _far_enough(value: float, values: Values) -> bool:
    return value == 0.0 or value >= 20.0


OVERRIDE_IN_OFFBOARD = 2
"""The bit of COM_RC_OVERRIDE (PX4 up to 1.17) for offboard."""
RULES: tuple[Rule, ...] = (
    Rule("COM_OF_LOSS_T", _when(lambda v, _: not exceeds(v, LOSS_TIME_MAX), Weight.ADVICE),
         f"{LOSS_TIME_MAX:g} s or less",
         "for so long PX4 flies the last body rate when setpoints stop; longer, and auto flies attitude"),
    Rule("COM_OBL_RC_ACT", _on_loss, f"{HOLD_ON_LOSS} (Hold), or 3 (Return), 4 (Land)",
         "what PX4 does when setpoints stop. Position and Altitude are flown by sticks: without any 1.16.0 sank where "
         "it was and landed, later versions returned"),
    Rule("NAV_RCL_ACT", _when(lambda v, _: int(v) not in (5, 6), Weight.DANGER), "2 (Return) or 1 (Hold)",
         "what a lost remote control does; 5 and 6 cut the motors"),
    Rule("NAV_DLL_ACT", _when(lambda v, _: int(v) not in (5, 6), Weight.DANGER), "0 (nothing), 1 (Hold) or 2 (Return)",
         "what a lost ground station does; 5 and 6 cut the motors"),
    Rule("COM_RC_OVERRIDE", _when(lambda v, _: int(v) & OVERRIDE_IN_OFFBOARD != 0, Weight.ADVICE),
         "3 (in auto modes and offboard)", "sticks take the vehicle from us; else only the mode switch does",
         elsewhere="MAN_OVERRIDE_SPD"),
    Rule("MAN_OVERRIDE_SPD", _when(lambda v, _: v >= 0.0, Weight.ADVICE), "1 1/s, or another that is not negative",
         "sticks that move so fast take the vehicle from us; else only the mode switch does",
         elsewhere="COM_RC_OVERRIDE"),
    Rule("COM_LOW_BAT_ACT", _when(lambda v, _: int(v) != 0, Weight.ADVICE), "3 (Return, then Land) or 2 (Land)",
         "with 0 a low battery is only warned of"),
    Rule("BAT_LOW_THR", _when(lambda v, _: v >= 0.12, Weight.ADVICE), "0.15 or more",
         "below it the companion hands the vehicle back"),
    Rule("GF_ACTION", _when(lambda v, _: int(v) not in (0, 4), Weight.ADVICE), "2 (Hold) or 3 (Return)",
         "what the vehicle's own fence does: 0 nothing, 1 only warns, 4 cuts the motors"),
    Rule("GF_MAX_HOR_DIST", _when(_far_enough, Weight.ADVICE), "0 (none), or beyond the path",
         "the companion hands back a metre before it"),
    Rule("GF_MAX_VER_DIST", _when(_far_enough, Weight.ADVICE), "0 (none), or above the path",
         "the companion hands back a metre before it"),
    Rule("RTL_RETURN_ALT", _when(lambda v, _: v >= 10.0, Weight.ADVICE), "above every obstacle of the site, in m",
         "the height PX4 returns at, also after it lost us"),
    Rule("RTL_DESCEND_ALT", _when(lambda v, _: v >= 3.0, Weight.ADVICE), "3 m or more",
         "the height at which a return waits above home"),
    Rule("MIS_TAKEOFF_ALT", _when(lambda v, _: v >= 1.5, Weight.ADVICE), "1.5 m or more",
         "the height PX4 takes off to before the path is joined"),
    Rule("FD_FAIL_R", _when(lambda v, _: v == 0.0 or v >= 45.0, Weight.ADVICE), "60 degrees",
         "the tilt at which PX4 ends the flight; the companion stays 2 degrees under it"),
    Rule("FD_FAIL_P", _when(lambda v, _: v == 0.0 or v >= 45.0, Weight.ADVICE), "60 degrees",
         "the tilt at which PX4 ends the flight; the companion stays 2 degrees under it"),
    Rule("MPC_THR_HOVER", _when(lambda v, _: 0.2 <= v <= 0.75, Weight.ADVICE), "what the log of a hover shows",
         "where the learning of the thrust begins"),
    Rule("IMU_GYRO_RATEMAX", _when(lambda v, _: v >= 400.0 or v == 0.0, Weight.ADVICE), "400 Hz or more",
         "PX4's rate loop runs at it"),
)  # fmt: skip


def audit_parameters(values: Values) -> list[Finding]:
    """Every rule on a vehicle's parameters."""
    findings = []
    for rule in RULES:
        value = values.get(rule.parameter)
        if value is None and rule.elsewhere in values:
            continue
        weight = Weight.ADVICE if value is None else rule.judge(value, values)
        why = rule.why if value is not None else f"this firmware does not have it; {rule.why}"
        findings.append(Finding(rule.parameter, value, weight, rule.advised, why, in_words(rule.parameter, value)))
    return findings
