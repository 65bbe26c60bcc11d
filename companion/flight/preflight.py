"""What must be there before the flight begins, each with what to do where it is not."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from companion.flight.conduct import ControlAuthority, Finish, Limits
from companion.flight.safety import missing_estimate
from companion.vehicle import Landed, VehicleStatus

RATE_WANTED = 20.0
"""Hz of states, below which no path is flown."""


class Standing(NamedTuple):
    """What is known before a flight. ``rate``: Hz of states, None until measured. ``has_state``: one has arrived."""

    status: VehicleStatus
    authority: ControlAuthority
    finish: Finish
    limits: Limits
    has_state: bool
    rate: float | None
    companions: int = 0


def _state(s: Standing) -> str | None:
    return None if s.has_state else "no state arrives (ODOMETRY); does the autopilot send it on this link?"


def _rate(s: Standing) -> str | None:
    if s.rate is None or s.rate >= RATE_WANTED:
        return None
    return f"only {s.rate:.0f} states a second arrive, {RATE_WANTED:g} are needed; raise the link's speed (MAV_x_RATE)"


def _estimator(s: Standing) -> str | None:
    missing = missing_estimate(s.status.estimator)
    return None if missing is None else f"the estimator does not know its {missing}; wait for GPS or another source"


def _battery(s: Standing) -> str | None:
    battery = s.status.battery
    if battery is None or s.limits.battery is None or battery >= s.limits.battery:
        return None
    return f"the battery is at {100.0 * battery:.0f} %, below {100.0 * s.limits.battery:.0f} %; charge it"


def _alone(s: Standing) -> str | None:
    return "another companion speaks on the link; stop it, two cannot fly one vehicle" if s.companions else None


def _home(s: Standing) -> str | None:
    if s.finish is Finish.RETURN and s.limits.home is None:
        return "the vehicle has no home to return to; wait for its GPS, or finish with hold or land"
    return None


def _ready(s: Standing) -> str | None:
    if s.authority is not ControlAuthority.COMPANION or s.status.ready or s.status.armed:
        return None
    return "the vehicle says it is not ready to arm; see the ground station for its health report"


def _landed(s: Standing) -> str | None:
    if s.authority is not ControlAuthority.COMPANION or s.status.landed in (Landed.ON_GROUND, Landed.IN_AIR):
        return None
    return "the vehicle does not say whether it stands or flies"


CHECKS: tuple[Callable[[Standing], str | None], ...] = (
    _state, _alone, _rate, _estimator, _battery, _home, _ready, _landed,
)  # fmt: skip


def missing(standing: Standing) -> str | None:
    """The first thing that is not there, in words; None: the flight may begin."""
    for check in CHECKS:
        reason = check(standing)
        if reason is not None:
            return reason
    return None
