"""What must be there before the flight begins, each with what to do where it is not."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from companion.flight.conditions import missing_estimate
from companion.flight.conduct import ControlAuthority, Finish, Limits
from companion.flight.link_needs import BY_RATE_LOOP, RATE_WANTED, LinkNeeds
from companion.vehicle import KnownStatus, Landed, Mode

STATE_GONE = 0.5
"""s without a new state before the flight (engineering choice)."""
CLOCK_RATE_MIN = 0.3
"""Ratio: s of the vehicle's clock a second of ours, at least. Engineering choice: its stamps are seconds; its states
arrive up to 0.1 s late, and the rate is first taken over 0.2 s."""
CLOCK_RATE_MAX = 5.0
"""Ratio, the same at most. Engineering choice: as fast as a simulator may be set to run."""
CLOCK_RATE_KEPT = 0.94
"""s a second of a clock that is flown with; one that falls behind by more makes every state late. As DRIFT_MAX of
mavlink/clock.py; only a simulation's does."""

NEVER_ARMS_IN = frozenset({
    Mode.RETURN, Mode.LAND, Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION, Mode.FOLLOW, Mode.ORBIT,
})  # fmt: skip
"""Modes in which PX4 does not arm (its mode_requirements.cpp, main of March 2026)."""


class PreflightInputs(NamedTuple):
    """What is known before a flight."""

    status: KnownStatus
    authority: ControlAuthority
    finish: Finish
    limits: Limits
    has_state: bool  # one has arrived
    rate: float | None  # Hz of states; None until measured
    companions: int = 0  # others that speak on the link
    state_age: float | None = 0.0  # s since the last state
    clock_rate: float | None = 1.0  # s of the vehicle's clock a second of ours; None until measured
    round_trip: float | None = None  # s, of a message; None until measured
    needs: LinkNeeds = BY_RATE_LOOP  # of the link, at the level that is flown


def _state(s: PreflightInputs) -> str | None:
    return None if s.has_state else "no state arrives (ODOMETRY); does the autopilot send it on this link?"


def _stamps(s: PreflightInputs) -> str | None:
    rate = s.clock_rate
    if rate is None:
        return "the rate of the vehicle's clock is not known yet (the stamps of ODOMETRY)"
    if CLOCK_RATE_KEPT <= rate < CLOCK_RATE_MAX:
        return None
    if CLOCK_RATE_MIN < rate < CLOCK_RATE_KEPT:
        slow = f"the vehicle's clock runs at {rate:.2f} of real time, {CLOCK_RATE_KEPT:g} is the least"
        return f"{slow}; the simulation is slower than real time: give it more of the computer"
    stands = "do not advance" if rate <= 0.0 else f"advance by {rate:.4g} s a second"
    return f"the stamps of ODOMETRY {stands}; time_usec must be microseconds of the vehicle's clock"


def _fresh(s: PreflightInputs) -> str | None:
    if s.state_age is None or s.state_age <= STATE_GONE:
        return None
    return f"no new state has come for {s.state_age:.0f} s (ODOMETRY)" if s.state_age >= 1.0 else "no new state comes"


def _delay(s: PreflightInputs) -> str | None:
    if s.round_trip is None or s.round_trip <= s.needs.delay:
        return None
    return (
        f"a message takes {500.0 * s.round_trip:.0f} ms each way (TIMESYNC), {500.0 * s.needs.delay:.0f} ms at most "
        "can be flown with; use a quicker link"
    )


def _rate(s: PreflightInputs) -> str | None:
    if s.rate is None:
        return "the rate of states is not known yet (ODOMETRY)"
    if s.rate >= RATE_WANTED:
        return None
    return f"only {s.rate:.0f} states a second arrive, {RATE_WANTED:g} are needed; raise the link's speed (MAV_x_RATE)"


def _estimator(s: PreflightInputs) -> str | None:
    missing = missing_estimate(s.status.estimator)
    return None if missing is None else f"the estimator does not know its {missing}; wait for GPS or another source"


def _battery(s: PreflightInputs) -> str | None:
    battery = s.status.battery
    if battery is None or s.limits.battery is None or battery >= s.limits.battery:
        return None
    return f"the battery is at {100.0 * battery:.0f} %, below {100.0 * s.limits.battery:.0f} %; charge it"


def _alone(s: PreflightInputs) -> str | None:
    return "another companion speaks on the link; stop it, two cannot fly one vehicle" if s.companions else None


def _home(s: PreflightInputs) -> str | None:
    if s.finish is Finish.RETURN and s.limits.home is None:
        return "the vehicle has no home to return to (HOME_POSITION); wait for its GPS, or finish with hold or land"
    return None


def _mode(s: PreflightInputs) -> str | None:
    mode = s.status.mode
    if s.authority is not ControlAuthority.COMPANION or s.status.armed is not False or mode not in NEVER_ARMS_IN:
        return None
    return f"the vehicle is in {mode.words}, in which it does not arm; select Hold or Position"


def _ready(s: PreflightInputs) -> str | None:
    if s.authority is not ControlAuthority.COMPANION or s.status.ready or s.status.armed:
        return None
    return "the vehicle says it is not ready to arm; see the ground station for its health report"


def _landed(s: PreflightInputs) -> str | None:
    if s.authority is not ControlAuthority.COMPANION or s.status.landed in (Landed.ON_GROUND, Landed.IN_AIR):
        return None
    return "the vehicle does not say whether it stands or flies (EXTENDED_SYS_STATE)"


CHECKS: tuple[Callable[[PreflightInputs], str | None], ...] = (
    _state, _alone, _stamps, _fresh, _rate, _delay, _estimator, _battery, _home, _mode, _ready, _landed,
)  # fmt: skip


def missing(inputs: PreflightInputs) -> str | None:
    """The first thing that is not there, in words; None: the flight may begin."""
    for check in CHECKS:
        reason = check(inputs)
        if reason is not None:
            return reason
    return None
