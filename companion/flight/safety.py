"""What may not go on: rows of (condition, how long, what is done). The worst row that has lasted decides."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from typing import NamedTuple

from companion.flight import conditions
from companion.flight.conditions import SafetyInputs
from companion.flight.conduct import Limits
from companion.flight.link_needs import BY_RATE_LOOP, RATE_WANTED, WITHOUT_RATE_LOOP
from companion.vehicle import TILT_MARGIN


class Action(enum.IntEnum):
    """What is done, the worse the larger: nothing; HOLD is asked for and the law flies until it is there; HOLD is asked
    for and the vehicle is only levelled."""

    NONE = 0
    HAND_BACK = 1
    ABORT = 2


class Row(NamedTuple):
    """``breached`` for ``after`` s: ``action``. ``words``: the condition, for docs; ``advice``: what to do next, for
    the pilot."""

    words: str
    breached: Callable[[SafetyInputs, Limits], str | None]
    after: float
    action: Action
    advice: str


LOOK_AT_ROTORS = "land it and look at motors and propellers, and at the link up to it"
LOOK_AT_THRUST = "land it and look at its battery, motors and propellers, and at the link up to it"
RAISE_SPEED = "raise the link's speed"
MEND_LINK = "mend the link: antennas, range, another radio; or ask for fewer states"
LINK_ADVICE = frozenset({RAISE_SPEED, MEND_LINK})
"""What is advised where the link is to blame."""


def _too_few_to_hold(s: SafetyInputs, limits: Limits) -> str | None:
    """The attitude is not held, because states are too far apart."""
    if s.rate is None or s.rate >= RATE_WANTED:
        return None
    off = conditions.rates(s, limits)
    return off and f"only {s.rate:.0f} states a second arrive, too few to hold the attitude by: {off}"


ROWS: tuple[Row, ...] = (
    Row(
        "the estimator has lost attitude, velocity, position or height",
        conditions.estimator,
        0.3,
        Action.ABORT,
        "land it by hand and see the estimator's log",
    ),
    Row(
        "the position jumps out of the tube, or by more than 1 m without the reset counter",
        conditions.jump,
        0.0,
        Action.ABORT,
        "see why the estimator was reset, then start again",
    ),
    Row(
        "the position stands still, and it moves",
        conditions.same_place,
        0.15,
        Action.ABORT,
        "see the estimator's log",
    ),
    Row(
        "the attitude stands still, and it turns",
        conditions.same_attitude,
        0.2,
        Action.ABORT,
        "see the estimator's log",
    ),
    Row(
        f"position and velocity disagree by {conditions.VELOCITY_OFF:g} m/s",
        conditions.velocity_off,
        0.15,
        Action.ABORT,
        "see the estimator's log",
    ),
    Row(
        f"attitude and body rates disagree by {conditions.RATES_OFF:g} rad/s",
        conditions.rates_off,
        0.15,
        Action.ABORT,
        "see the estimator's log",
    ),
    Row(
        "the vehicle's clock jumps",
        conditions.clock,
        0.0,
        Action.ABORT,
        "see whether the autopilot restarted, then start again",
    ),
    Row(
        f"the tilt comes within {math.degrees(TILT_MARGIN):g} degrees of the vehicle's failure detector",
        conditions.tilt,
        0.15,
        Action.ABORT,
        f"{LOOK_AT_ROTORS}, or fly slower",
    ),
    Row(
        f"the tilt is {math.degrees(conditions.TILT_ERROR):.0f} degrees off the commanded one",
        conditions.tilt_error,
        0.4,
        Action.ABORT,
        LOOK_AT_ROTORS,
    ),
    Row(
        f"the body rates are {conditions.RATE_ERROR:g} rad/s off on fewer than {RATE_WANTED:g} states a second",
        _too_few_to_hold,
        0.2,
        Action.ABORT,
        RAISE_SPEED,
    ),
    Row(
        f"the body rates are {conditions.RATE_ASTRAY:g} rad/s off on states "
        f"that come {conditions.LATE_ASTRAY:g} s late",
        conditions.late,
        0.1,
        Action.ABORT,
        MEND_LINK,
    ),
    Row(
        f"the body rates are {conditions.RATE_ERROR:g} rad/s off the commanded ones",
        conditions.rates,
        0.4,
        Action.ABORT,
        LOOK_AT_ROTORS,
    ),
    Row(
        f"at motors and torques: it turns at {conditions.TURNS_TOO_FAST:g} times the vehicle's greatest body rate",
        conditions.turns,
        0.05,
        Action.ABORT,
        f"{LOOK_AT_ROTORS}, or fly slower",
    ),
    Row(
        f"under {100.0 * conditions.THRUST_RATIO_GONE:g} % of the thrust that is commanded comes, or under "
        f"{100.0 * conditions.THRUST_RATIO_ASTRAY:g} % while the rates are {conditions.RATE_ASTRAY:g} rad/s off",
        conditions.thrust_gone,
        0.1,
        Action.ABORT,
        LOOK_AT_THRUST,
    ),
    Row(
        f"under {100.0 * conditions.THRUST_RATIO_SHORT:g} % of the thrust that is commanded comes, or under "
        f"{100.0 * conditions.ROTOR_WEAK:g} % of one motor's at motors",
        conditions.thrust_short,
        0.25,
        Action.ABORT,
        LOOK_AT_THRUST,
    ),
    Row(
        f"under {100.0 * conditions.THRUST_RATIO_SPENT:g} % of it comes, it is at its limit, and the vehicle sinks at "
        f"{conditions.SINKING:g} m/s",
        conditions.thrust_spent,
        0.3,
        Action.HAND_BACK,
        "land it and look at motors, propellers and battery",
    ),
    Row(
        f"a message takes {BY_RATE_LOOP.delay:g} s there and back, {WITHOUT_RATE_LOOP.delay:g} s at motors",
        conditions.delay,
        0.3,
        Action.HAND_BACK,
        "use a quicker link, or send less over it",
    ),
    Row("below the floor", conditions.floor, 0.1, Action.HAND_BACK, "raise the path, or lower the floor"),
    Row("above the ceiling", conditions.ceiling, 0.1, Action.HAND_BACK, "lower the path, or raise the ceiling"),
    Row("outside the mission's fence", conditions.fence, 0.1, Action.HAND_BACK, "move the path, or the fence"),
    Row(
        f"within {conditions.FENCE_AHEAD:g} m of the vehicle's own fence",
        conditions.own_fence,
        0.1,
        Action.HAND_BACK,
        "move the path, or the vehicle's fence",
    ),
    Row(
        "outside the tube around the path",
        conditions.tube,
        1.0,
        Action.HAND_BACK,
        "fly slower or in less wind, or widen the tube",
    ),
    Row(
        "at the limits of the vehicle",
        conditions.saturated,
        4.0,
        Action.HAND_BACK,
        "fly slower; companion check says how much",
    ),
    Row("the battery is low", conditions.battery, 2.0, Action.HAND_BACK, "land it and charge"),
    Row(
        f"more than {conditions.FAR_OFF:g} m from the path",
        conditions.off_the_path,
        20.0,
        Action.HAND_BACK,
        "fly slower or in less wind",
    ),
    Row(
        f"{conditions.BEHIND} states at once: the computer is behind",
        conditions.behind,
        0.5,
        Action.HAND_BACK,
        "end what else runs on the computer, or ask for fewer states",
    ),
    Row(
        f"fewer than {BY_RATE_LOOP.rate:g} states a second ({WITHOUT_RATE_LOOP.rate:g} at motors and torques)",
        conditions.slow,
        1.0,
        Action.HAND_BACK,
        RAISE_SPEED,
    ),
    Row(
        f"{conditions.GAPS} gaps of over {conditions.GAP:g} s in the states within {conditions.GAPS_WITHIN:g} s",
        conditions.gaps,
        0.0,
        Action.HAND_BACK,
        MEND_LINK,
    ),
    Row("another companion speaks on the link", conditions.others, 0.0, Action.HAND_BACK, "stop the other companion"),
)
"""s, how long each condition must last, beside what is done then. Engineering choice."""

_BREACHED = tuple(row.breached for row in ROWS)

Since = tuple[float | None, ...]
"""For each row since when (s) it is breached; None where it is not."""
NOTHING_SINCE: Since = (None,) * len(ROWS)


class Verdict(NamedTuple):
    """The worst that has lasted long enough, why, and what to do next."""

    action: Action
    reason: str | None
    advice: str | None = None


NO_FAULT = Verdict(Action.NONE, None)


def update_breaches(since: Since, inputs: SafetyInputs, limits: Limits, now: float) -> tuple[Since, Verdict]:
    """Look at every row: since when each is breached, and the verdict."""
    reasons = [breached(inputs, limits) for breached in _BREACHED]
    if not any(reasons):
        return NOTHING_SINCE, NO_FAULT
    later: list[float | None] = []
    worst = NO_FAULT
    for row, reason, begun in zip(ROWS, reasons, since, strict=True):
        start = None if reason is None else (now if begun is None else begun)
        later.append(start)
        if start is not None and now - start >= row.after and row.action > worst.action:
            worst = Verdict(row.action, reason, row.advice)
    return tuple(later), worst


def table() -> str:
    """The rows as a Markdown table, for docs/."""
    lines = ["| what | for | then |", "|---|---|---|"]
    for row in ROWS:
        lines.append(f"| {row.words} | {row.after:g} s | {row.action.name.lower().replace('_', ' ')} |")
    return "\n".join(lines) + "\n"
