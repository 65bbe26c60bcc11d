"""Every wait has an end and is told of; and what is said of an end is so."""

from __future__ import annotations

import pytest

from companion.flight.epilogue import Done, sentence
from companion.flight.guards import decide
from companion.flight.interruptions import ANSWER_WITHIN, DISARMED_FOR, SILENT_AFTER, STATUS_LOST_AFTER
from companion.flight.phases import TRIES, Event, Phase
from companion.flight.waiting import waited_for
from companion.vehicle import KnownStatus, Landed, Mode
from tests.flight.test_phases import situation

STANDING = KnownStatus(armed=True, mode=Mode.HOLD, intended=Mode.HOLD, landed=Landed.ON_GROUND, mode_age=0.1)


@pytest.mark.parametrize("phase", SILENT_AFTER)
def test_a_vehicle_that_is_not_heard_is_waited_for_only_so_long_and_told_of(phase: Phase) -> None:
    gone = KnownStatus(mode_age=SILENT_AFTER[phase] + 0.1)
    found = decide(situation(phase, status=gone))
    assert found is not None and found[:2] == (Phase.DONE, Event.SILENT)
    assert decide(situation(phase, status=gone._replace(mode_age=SILENT_AFTER[phase] - 0.1))) is None
    assert phase.value in str(waited_for(situation(phase, status=gone._replace(mode_age=STATUS_LOST_AFTER + 0.1))))


def test_who_waits_for_a_pilot_is_told_that_nothing_is_heard() -> None:
    assert waited_for(situation(Phase.STAND_BY)) is None
    said = waited_for(situation(Phase.STAND_BY, status=KnownStatus(mode_age=STATUS_LOST_AFTER + 0.1)))
    assert said is not None and said.startswith("nothing is heard from the vehicle in stand by")


@pytest.mark.parametrize("phase", [Phase.TAKE_OFF, Phase.LAND, Phase.RETURN])
def test_what_was_asked_for_in_vain_ends_in_seconds(phase: Phase) -> None:
    asked = situation(phase, status=STANDING._replace(landed=None), mode_seen=False, decided_in=Mode.HOLD, asked=TRIES)
    found = decide(asked._replace(asked_at=10.0 - ANSWER_WITHIN - 0.1))
    assert found is not None and found[1] is Event.TIMED_OUT
    assert "did not answer" in found[2]
    assert decide(asked._replace(asked_at=10.0 - ANSWER_WITHIN + 0.1)) is None


def test_disarmed_is_believed_only_when_it_was_said_since() -> None:
    down = situation(Phase.DISARM, status=STANDING._replace(armed=False))  # for 1 s
    assert decide(down._replace(armed_heard=1.0 - 0.5 * DISARMED_FOR)) is None
    found = decide(down._replace(armed_heard=0.5))
    assert found is not None and found[1] is Event.DISARMED


def test_a_stop_disarms_what_stands_and_holds_what_flies() -> None:
    stands = decide(situation(Phase.TAKE_OFF, status=STANDING, stop=True))
    flies = decide(situation(Phase.TAKE_OFF, status=STANDING._replace(landed=Landed.IN_AIR), stop=True))
    assert stands is not None and stands[0] is Phase.DISARM
    assert flies is not None and flies[0] is Phase.HAND_BACK


@pytest.mark.parametrize(
    ("event", "last", "done", "says"),
    [
        (Event.TIMED_OUT, Event.TIMED_OUT, Done(), "nothing was flown"),
        (Event.STALE, Event.HELD, Done(begun=True), "OFFBOARD had been asked for, setpoints have stopped"),
        (Event.REFUSED, Event.HELD, Done(begun=True), "nothing was flown"),
        (Event.SILENT, Event.SILENT, Done(arm_asked=True), "it had been asked to arm and may have done so unheard"),
        (Event.TIMED_OUT, Event.TIMED_OUT, Done(arm_asked=True), "nothing was flown"),
        (Event.SILENT, Event.SILENT, Done(armed=True), "the vehicle was armed, was last heard in Land"),
        (Event.SILENT, Event.SILENT, Done(True, True, True, True), "the vehicle was last heard in Land, and nothing more"),
        (Event.STALE, Event.TIMED_OUT, Done(True, True), "setpoints have stopped, and the autopilot's own failsafe acts"),
        (Event.STALE, Event.TIMED_OUT, Done(True, True, hold_asked=1, hold_accepted=True), "HOLD was accepted"),
        (Event.TAKEN_OVER, Event.TAKEN_OVER, Done(True, True), "nothing more was sent"),
        (Event.FAILSAFE, Event.LET_GO, Done(True, True, left=True), "nothing more was sent, and the vehicle is in Land"),
        (Event.FAILSAFE, Event.LET_GO, Done(True, True, left=True, hold_asked=1), "HOLD was asked for to end OFFBOARD"),
        (Event.TIMED_OUT, Event.LET_GO, Done(armed=True, left=True), "the vehicle is in Land and will not return"),
    ],
)  # fmt: skip
def test_what_is_said_of_an_end_is_so(event: Event, last: Event, done: Done, says: str) -> None:
    said = sentence("something happened", event, None, last, Mode.LAND, done)
    assert said.startswith(f"something happened: {says}"), said
