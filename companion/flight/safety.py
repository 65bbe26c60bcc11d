"""What may not go on: rows of (condition, how long, what is done). The worst row that has lasted decides.

A condition is a pure function of what is seen; it says in words why it holds, or nothing.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from typing import NamedTuple

from companion.flight.conduct import TILT_MARGIN, Limits
from companion.vehicle import KnownStatus

ESTIMATOR_PARTS = (
    (1, "attitude"),
    (2, "horizontal velocity"),
    (4, "vertical velocity"),
    (8 | 16, "horizontal position"),
    (32, "height"),
)
"""The bits of ESTIMATOR_STATUS that must be there (one of each group), and what they stand for."""
CLOCK_JUMP = 0.5
"""s that the vehicle's clock may run ahead of ours between two states (engineering choice)."""
VELOCITY_OFF, RATES_OFF = 3.0, 1.5
"""m/s and rad/s that position and velocity, attitude and rates may disagree by (engineering choice: PX4's own differ by
0.04 m/s, px4_flight.md, 4)."""
TILT_ERROR = math.radians(40.0)
"""rad between the thrust axis asked for and the one flown (engineering choice)."""
RATE_ERROR = 3.0
"""rad/s between the rates asked for and flown (engineering choice)."""
TURNING = 1.0
"""rad/s: a vehicle that turns slower than that is not out of hand (engineering choice)."""
BEHIND = 5
"""states that arrive together with the newest, from which on the computer is behind (engineering choice)."""
SLOW_RATE = 12.0
"""Hz of states, of which fewer are not flown by; preflight asks for 20 (engineering choice)."""
GAP, GAPS, GAPS_WITHIN = 0.1, 5, 10.0
"""s without a state that count as a gap; so many gaps within so many s are too many."""
FENCE_AHEAD = 1.0
"""m before the vehicle's own fence, which PX4 would act on (engineering choice)."""
FAR_OFF = 1.0
"""m from the path that a vehicle may be for a while and not for good (engineering choice)."""


THRUST_SPENT, SINKING = 0.95, 0.8
"""Of the largest thrust; m/s. One motor at half its thrust comes to this within 0.5 s (engineering choice)."""
PULLED_DOWN, OFF_THE_PATH = 0.5, 0.5
"""m/s^2, m: at the bottom of a steep curve a sound vehicle sinks at full thrust too, but neither is it pulled down nor
does it leave its path (engineering choice)."""
LINK_DELAY_MAX = 0.2
"""s there and back (issue 11: 100 ms each way). Beyond it the law leans too far."""


class Action(enum.IntEnum):
    """What is done, the worse the larger: nothing; HOLD is asked for and the law flies until it is there; HOLD is asked
    for and the vehicle is only levelled."""

    NONE = 0
    HAND_BACK = 1
    ABORT = 2


class SafetyInputs(NamedTuple):
    """What the rows look at.

    ``following``: the path is flown now, and it was reached. ``path_error``: m. ``height``: m above the ground, None
    where that is not known. ``fence_margin``: m to the mission's fence, inside positive. ``from_home``: m level, and
    ``above_home`` m. ``tilt``: rad. ``tilt_error``: rad between the thrust axis and the one the law asks for.
    ``rate_error``: rad/s between the rates asked for and flown, None where none are. ``turning``: rad/s, how fast it
    turns. ``still``: it neither moves nor turns.
    ``saturated``: a limit of the vehicle was met. ``thrust_share``: of the largest thrust, asked for; ``sinking``: m/s
    downwards; ``pulled_down``: m/s^2 that thrust, drag and weight do not explain, None where it is not estimated.
    ``link_delay``: s there and back, None where it is not known. ``jump``: m that the position jumped, ``flagged`` by
    the estimator's reset counter.
    ``velocity_off`` m/s, ``rates_off`` rad/s: how far position and velocity, and attitude and rates, disagree.
    ``same_place``, ``same_attitude``: the last state repeated those of the one before, although it moves, or turns.
    ``clock_jump``: s that the vehicle's clock ran ahead of ours since the last state. ``behind``: states that arrived
    together with the newest and were passed over. ``rate``: Hz of states, None until measured. ``gaps``: in the states,
    of the last while. ``companions``: others that speak on the link.
    """

    status: KnownStatus
    following: bool = False
    path_error: float = 0.0
    height: float | None = None
    fence_margin: float = math.inf
    from_home: float | None = None
    above_home: float | None = None
    tilt: float = 0.0
    tilt_error: float = 0.0
    rate_error: float | None = None
    turning: float = 0.0
    still: bool = False
    saturated: bool = False
    thrust_share: float = 0.0
    sinking: float = 0.0
    pulled_down: float | None = None
    link_delay: float | None = None
    jump: float = 0.0
    flagged: bool = True
    velocity_off: float = 0.0
    rates_off: float = 0.0
    same_place: bool = False
    same_attitude: bool = False
    clock_jump: float = 0.0
    behind: int = 0
    rate: float | None = None
    gaps: int = 0
    companions: int = 0


class Row(NamedTuple):
    """``breached`` for ``after`` s: ``action``. ``words``: the condition, for docs; ``advice``: what to do next, for
    the pilot."""

    words: str
    breached: Callable[[SafetyInputs, Limits], str | None]
    after: float
    action: Action
    advice: str


def missing_estimate(flags: int | None) -> str | None:
    """What the estimator does not know; None where it knows enough, or has not said."""
    if flags is None:
        return None
    missing = [words for bits, words in ESTIMATOR_PARTS if not flags & bits]
    return " and ".join(missing) if missing else None


def _estimator(s: SafetyInputs, limits: Limits) -> str | None:
    missing = missing_estimate(s.status.estimator)
    return None if missing is None else f"the estimator has lost its {missing}"


def _jump(s: SafetyInputs, limits: Limits) -> str | None:
    if not s.flagged and s.jump > 0.0:
        return f"the position jumped by {s.jump:.1f} m, and the estimator's reset counter says nothing of it"
    if limits.tube is None or s.jump <= limits.tube:
        return None
    return f"the estimator moved the vehicle by {s.jump:.1f} m at once, out of the tube of {limits.tube:g} m"


def _same_place(s: SafetyInputs, limits: Limits) -> str | None:
    return "the vehicle says that it moves, and always the same position" if s.same_place else None


def _same_attitude(s: SafetyInputs, limits: Limits) -> str | None:
    return "the vehicle says that it turns, and always the same attitude" if s.same_attitude else None


def _velocity_off(s: SafetyInputs, limits: Limits) -> str | None:
    if s.velocity_off <= VELOCITY_OFF:
        return None
    return f"the position moves {s.velocity_off:.1f} m/s otherwise than the velocity says"


def _rates_off(s: SafetyInputs, limits: Limits) -> str | None:
    if s.rates_off <= RATES_OFF:
        return None
    return f"the attitude turns {s.rates_off:.1f} rad/s otherwise than the body rates say"


def _clock(s: SafetyInputs, limits: Limits) -> str | None:
    if abs(s.clock_jump) <= CLOCK_JUMP:
        return None
    way = "ahead" if s.clock_jump > 0.0 else "back"
    return f"the vehicle's clock jumped {way} by {abs(s.clock_jump):.1f} s"


def _tilt(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.tilt is None or s.tilt <= limits.tilt:
        return None
    return f"the vehicle leans by {math.degrees(s.tilt):.0f} degrees, more than {math.degrees(limits.tilt):.0f}"


def _tilt_error(s: SafetyInputs, limits: Limits) -> str | None:
    # a vehicle that is held does not lean as it is told either; it is to carry on when it is let go
    if limits.tilt is None or s.tilt_error <= min(TILT_ERROR, limits.tilt) or s.still:
        return None
    return f"the vehicle leans {math.degrees(s.tilt_error):.0f} degrees otherwise than it is told"


def _rates(s: SafetyInputs, limits: Limits) -> str | None:
    if s.rate_error is None or s.rate_error <= RATE_ERROR or s.turning <= TURNING:
        return None
    return f"the vehicle turns {s.rate_error:.1f} rad/s otherwise than it is told"


def _thrust(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.tilt is None or s.thrust_share < THRUST_SPENT or s.sinking < SINKING:
        return None
    if s.pulled_down < PULLED_DOWN if s.pulled_down is not None else s.path_error < OFF_THE_PATH:
        return None  # the bottom of a steep curve, flown as it should be
    return f"the thrust does not answer: it is at its limit, and the vehicle sinks at {s.sinking:.1f} m/s"


def _delay(s: SafetyInputs, limits: Limits) -> str | None:
    if s.link_delay is None or s.link_delay <= LINK_DELAY_MAX:
        return None
    return f"a message takes {s.link_delay:.2f} s there and back, more than {LINK_DELAY_MAX:g} s"


def _floor(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.floor is None or s.height is None or s.height >= limits.floor:
        return None
    return f"{s.height:.1f} m above the ground, below the floor of {limits.floor:g} m"


def _ceiling(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.ceiling is None or s.height is None or s.height <= limits.ceiling:
        return None
    return f"{s.height:.1f} m above the ground, above the ceiling of {limits.ceiling:g} m"


def _fence(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.fence_margin >= 0.0 else f"the vehicle is {-s.fence_margin:.1f} m outside the mission's fence"


def _own_fence(s: SafetyInputs, limits: Limits) -> str | None:
    if limits.radius and s.from_home is not None and s.from_home > limits.radius - FENCE_AHEAD:
        return f"{s.from_home:.0f} m from home, at the vehicle's own fence of {limits.radius:g} m (GF_MAX_HOR_DIST)"
    if limits.height and s.above_home is not None and s.above_home > limits.height - FENCE_AHEAD:
        return f"{s.above_home:.0f} m above home, at the vehicle's own fence of {limits.height:g} m (GF_MAX_VER_DIST)"
    return None


def _tube(s: SafetyInputs, limits: Limits) -> str | None:
    if not s.following or limits.tube is None or s.path_error <= limits.tube:
        return None
    return f"{s.path_error:.1f} m from the path, outside the tube of {limits.tube:g} m"


def _saturated(s: SafetyInputs, limits: Limits) -> str | None:
    # whoever holds a vehicle still brings the law to its limits, not the path
    if not s.saturated or s.still or limits.tilt is None:
        return None
    return "the vehicle is at its limits and cannot fly this"


def _battery(s: SafetyInputs, limits: Limits) -> str | None:
    battery = s.status.battery
    if battery is None or limits.battery is None or battery >= limits.battery:
        return None
    return f"the battery is at {100.0 * battery:.0f} %, below {100.0 * limits.battery:.0f} %"


def _off_the_path(s: SafetyInputs, limits: Limits) -> str | None:
    if not s.following or s.path_error <= FAR_OFF:
        return None
    return f"{s.path_error:.1f} m from the path and not coming nearer"


def _behind(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.behind < BEHIND else f"the computer is {s.behind} states behind"


def _slow(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.rate is None or s.rate >= SLOW_RATE else f"only {s.rate:.0f} states a second arrive"


def _gaps(s: SafetyInputs, limits: Limits) -> str | None:
    return None if s.gaps < GAPS else f"the link has gaps: {s.gaps} of over {GAP:g} s within {GAPS_WITHIN:g} s"


def _others(s: SafetyInputs, limits: Limits) -> str | None:
    return "another companion speaks on the link (a heartbeat of component 191)" if s.companions else None


# each with the s it must last (engineering choices)
ROWS: tuple[Row, ...] = (
    Row(
        "the estimator has lost attitude, velocity, position or height",
        _estimator,
        0.3,
        Action.ABORT,
        "land it by hand and see the estimator's log",
    ),
    Row(
        "the position jumps out of the tube, or by more than 1 m without the reset counter",
        _jump,
        0.0,
        Action.ABORT,
        "see why the estimator was reset, then start again",
    ),
    Row("the position stands still, and it moves", _same_place, 0.2, Action.ABORT, "see the estimator's log"),
    Row("the attitude stands still, and it turns", _same_attitude, 0.2, Action.ABORT, "see the estimator's log"),
    Row(
        f"the position moves {VELOCITY_OFF:g} m/s otherwise than the velocity says",
        _velocity_off,
        0.15,
        Action.ABORT,
        "see the estimator's log",
    ),
    Row(
        f"the attitude turns {RATES_OFF:g} rad/s otherwise than the body rates say",
        _rates_off,
        0.15,
        Action.ABORT,
        "see the estimator's log",
    ),
    Row(
        "the vehicle's clock jumps", _clock, 0.0, Action.ABORT, "see whether the autopilot restarted, then start again"
    ),
    Row(
        f"the lean comes within {math.degrees(TILT_MARGIN):g} degrees of the vehicle's failure detector",
        _tilt,
        0.15,
        Action.ABORT,
        "land it and look at motors and propellers, or fly slower",
    ),
    Row(
        f"the vehicle leans {math.degrees(TILT_ERROR):.0f} degrees otherwise than it is told",
        _tilt_error,
        0.4,
        Action.ABORT,
        "land it and look at motors and propellers",
    ),
    Row(
        f"the vehicle turns {RATE_ERROR:g} rad/s otherwise than it is told",
        _rates,
        0.4,
        Action.ABORT,
        "land it and look at motors and propellers",
    ),
    Row(
        f"the thrust is at its limit, and the vehicle sinks at {SINKING:g} m/s",
        _thrust,
        0.3,
        Action.HAND_BACK,
        "land it and look at motors, propellers and battery",
    ),
    Row(
        f"a message takes {LINK_DELAY_MAX:g} s there and back",
        _delay,
        0.3,
        Action.HAND_BACK,
        "use a quicker link, or send less over it",
    ),
    Row("below the floor", _floor, 0.1, Action.HAND_BACK, "raise the path, or lower the floor"),
    Row("above the ceiling", _ceiling, 0.1, Action.HAND_BACK, "lower the path, or raise the ceiling"),
    Row("outside the mission's fence", _fence, 0.1, Action.HAND_BACK, "move the path, or the fence"),
    Row(
        f"within {FENCE_AHEAD:g} m of the vehicle's own fence",
        _own_fence,
        0.1,
        Action.HAND_BACK,
        "move the path, or the vehicle's fence",
    ),
    Row(
        "outside the tube around the path",
        _tube,
        1.0,
        Action.HAND_BACK,
        "fly slower or in less wind, or widen the tube",
    ),
    Row("at the limits of the vehicle", _saturated, 4.0, Action.HAND_BACK, "fly slower; companion check says how much"),
    Row("the battery is low", _battery, 2.0, Action.HAND_BACK, "land it and charge"),
    Row(f"more than {FAR_OFF:g} m from the path", _off_the_path, 20.0, Action.HAND_BACK, "fly slower or in less wind"),
    Row(
        f"{BEHIND} states at once: the computer is behind",
        _behind,
        0.5,
        Action.HAND_BACK,
        "end what else runs on the computer, or ask for fewer states",
    ),
    Row(f"fewer than {SLOW_RATE:g} states a second", _slow, 1.0, Action.HAND_BACK, "raise the link's speed"),
    Row(
        f"{GAPS} gaps of over {GAP:g} s in the states within {GAPS_WITHIN:g} s",
        _gaps,
        0.0,
        Action.HAND_BACK,
        "mend the link: antennas, range, another radio; or ask for fewer states",
    ),
    Row("another companion speaks on the link", _others, 0.0, Action.HAND_BACK, "stop the other companion"),
)

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


def watched(since: Since, sight: SafetyInputs, limits: Limits, now: float) -> tuple[Since, Verdict]:
    """Look at every row: since when each is breached, and the verdict."""
    reasons = [breached(sight, limits) for breached in _BREACHED]
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
