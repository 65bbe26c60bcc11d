"""A vehicle that somebody holds is waited for; one that tumbles is not."""

from companion.flight.conduct import Limits
from companion.flight.safety import NOTHING_SINCE, Action, SafetyInputs, update_breaches
from companion.vehicle import KnownStatus

LIMITS = Limits(tilt=1.0)
HELD = SafetyInputs(KnownStatus(), following=True, rate_error=3.9, body_rate=0.0, still=True, saturated=True)


def after(seconds: float, inputs: SafetyInputs) -> Action:
    since, _ = update_breaches(NOTHING_SINCE, inputs, LIMITS, 0.0)
    return update_breaches(since, inputs, LIMITS, seconds)[1].action


def test_held_still_the_flight_waits_to_be_let_go() -> None:
    assert after(10.0, HELD) is Action.NONE


def test_turning_otherwise_than_told_ends_it() -> None:
    assert after(1.0, HELD._replace(body_rate=3.9, still=False)) is Action.ABORT


def test_at_its_limits_and_moving_it_is_handed_back() -> None:
    assert after(10.0, HELD._replace(rate_error=0.0, still=False)) is Action.HAND_BACK
