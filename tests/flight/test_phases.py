"""The state machine: reachable, always ending, never raising, the human wins."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest

from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.guards import GUARDS, decide
from companion.flight.interruptions import CONFIRM_WITHIN, STATE_AGE_MAX
from companion.flight.phases import (
    EXITS,
    FLOWN,
    PHASES,
    PRE_EMPTIONS,
    TRANSITIONS,
    Event,
    Phase,
    Request,
    diagram,
    pre_emption_table,
)
from companion.flight.safety import Action, Verdict, table
from companion.flight.situation import Answer, Situation
from companion.mavlink_common import MavResult
from companion.vehicle import KnownStatus, Landed, Mode

FLYING = KnownStatus(
    armed=True, mode=Mode.OFFBOARD, intended=Mode.OFFBOARD, landed=Landed.IN_AIR, ready=True, mode_age=0.1
)
AIRBORNE = (Phase.TAKE_OVER, *FLOWN, Phase.HAND_BACK)


def situation(phase: Phase, **changes: object) -> Situation:
    usual = Situation(
        phase=phase, now=10.0, entered=9.0, status=FLYING, mode_seen=True, state_at=10.0, answer=None, from_ground=False
    )
    return usual._replace(**changes)  # type: ignore[arg-type]


def test_every_phase_can_be_reached_and_reaches_done() -> None:
    leads_to = {phase: {following for _, following in exits} for phase, exits in EXITS.items()}

    def reach(start: Phase) -> set[Phase]:
        found, todo = {start}, [start]
        while todo:
            for following in leads_to[todo.pop()] - found:
                found.add(following)
                todo.append(following)
        return found

    assert reach(Phase.PREFLIGHT) == set(Phase)
    for phase in Phase:
        assert Phase.DONE in reach(phase)
    assert EXITS[Phase.DONE] == ()


def test_the_tables_name_every_event_and_phase_once() -> None:
    assert set(GUARDS) == set(Event)
    assert set(PHASES) == set(Phase)
    used = {event for _, event in TRANSITIONS} | {event for event, _ in PRE_EMPTIONS}
    assert used == set(Event)


@pytest.mark.parametrize("phase", AIRBORNE)
def test_a_fault_pre_empts_every_phase_that_steers(phase: Phase) -> None:
    stale = decide(situation(phase, state_at=10.0 - STATE_AGE_MAX - 0.01))
    assert stale is not None
    assert stale[0] is Phase.ABORT
    failed = decide(situation(phase, law_error="singular"))
    assert failed is not None
    assert failed[0] is Phase.ABORT
    disarmed = decide(situation(phase, status=FLYING._replace(armed=False)))
    assert disarmed is not None
    assert disarmed[0] is Phase.RELEASE
    lost = decide(situation(phase, verdict=Verdict(Action.ABORT, "the vehicle leans")))
    assert lost == (Phase.ABORT, Event.ABORT_REQUIRED, "the vehicle leans")


@pytest.mark.parametrize("phase", [Phase.TAKE_OVER, *FLOWN])
def test_a_guard_hands_back_from_every_phase_that_flies(phase: Phase) -> None:
    unsafe = decide(situation(phase, verdict=Verdict(Action.HAND_BACK, "the battery is at 5 %")))
    assert unsafe == (Phase.HAND_BACK, Event.HAND_BACK_REQUIRED, "the battery is at 5 %")


def test_a_fault_wins_over_progress() -> None:
    decision = decide(situation(Phase.FOLLOW, finished="flew 2 laps", state_at=9.0))
    assert decision is not None
    assert decision[1] is Event.STALE


def test_a_human_who_changes_the_mode_wins() -> None:
    decision = decide(situation(Phase.FOLLOW, status=FLYING._replace(mode=Mode.POSITION, intended=Mode.POSITION)))
    assert decision == (Phase.DONE, Event.TAKEN_OVER, "the operator took over: the mode is Position now")
    again = decide(situation(Phase.RETURN, status=FLYING))
    assert again is not None and again[1] is Event.TAKEN_OVER
    assert "Offboard again" in again[2]


def test_a_mode_of_our_own_asking_that_comes_once_more_is_nobodys_word_for_certain() -> None:
    held = FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD)
    landing = situation(Phase.LAND, status=held, mode_seen=True, decided_in=Mode.HOLD, entered=9.6, now=10.0)
    again = decide(landing._replace(answered=0.4))
    assert again is not None
    assert again[2] == "in land the vehicle says Hold again: somebody selected it, or an old word came once more"
    following = situation(Phase.FOLLOW, status=held, mode_seen=True, decided_in=Mode.HOLD, entered=9.0, now=10.0)
    certain = decide(following._replace(answered=1.0))
    assert certain is not None and certain[2] == "the operator took over: the mode is Hold now"


@pytest.mark.parametrize("phase", [Phase.SETTLE, Phase.LAND, Phase.RETURN])
def test_a_word_of_the_mode_before_that_was_overtaken_is_nobodys(phase: Phase) -> None:
    """The answer was lost, CURRENT_MODE showed the phase's mode, and a HEARTBEAT sent before it comes after it."""
    before = Mode.HOLD if phase is Phase.SETTLE else Mode.OFFBOARD
    old = FLYING._replace(mode=before, intended=before, mode_age=0.0)
    overtaken = situation(phase, status=old, mode_seen=True, decided_in=before, entered=9.9)
    assert decide(overtaken._replace(answered=0.02)) is None
    went_back = decide(overtaken._replace(answered=0.3))
    assert went_back is not None and went_back[1] is Event.TAKEN_OVER
    somebody = old._replace(mode=Mode.POSITION, intended=Mode.POSITION)
    at_once = decide(overtaken._replace(status=somebody, answered=0.02))
    assert at_once is not None and at_once[1] is Event.TAKEN_OVER


def test_offboard_that_was_left_before_it_was_seen_is_over_with_the_next_word() -> None:
    held = FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD, mode_age=0.01)
    settling = situation(Phase.SETTLE, status=held, mode_seen=False, decided_in=Mode.HOLD, entered=9.9, now=10.0)
    assert decide(settling._replace(answered=0.1)) is None  # may have been sent before OFFBOARD was
    left = decide(settling._replace(answered=0.3))
    assert left is not None and left[1] is Event.TAKEN_OVER


def test_a_vehicle_that_does_not_say_whether_it_is_on_the_ground_may_have_landed() -> None:
    held = FLYING._replace(mode=Mode.POSITION, intended=Mode.POSITION, landed=None, mode_age=0.0)
    landing = situation(Phase.LAND, status=held, mode_seen=True, decided_in=Mode.HOLD, entered=0.0, now=10.0)
    assert decide(landing._replace(armed_heard=0.6)) is None  # HEARTBEAT has not come since CURRENT_MODE
    told = decide(landing._replace(armed_heard=0.0))
    assert told is not None and told[2] == "the operator took over: the mode is Position now"
    silent = decide(landing._replace(status=held._replace(armed=None)))
    assert silent is not None and silent[2].endswith("it has landed, or the operator took over")


def test_a_failsafe_is_left_alone_and_offboard_let_go_of() -> None:
    decision = decide(situation(Phase.FOLLOW, status=FLYING._replace(mode=Mode.HOLD)))
    assert decision is not None
    assert decision[0] is Phase.RELEASE
    assert decision[2].endswith("(a failsafe)")
    starved = situation(Phase.FOLLOW, status=FLYING._replace(mode=Mode.HOLD))
    told = decide(starved._replace(state_at=starved.now - 0.15))
    assert told is not None and told[2].endswith("after no new state had come from it for 0.15 s")
    returning = FLYING._replace(mode=Mode.RETURN, failsafe=True)
    assert decide(situation(Phase.RELEASE, status=returning)) is None
    assert decide(situation(Phase.ABORT, status=returning)) is None  # HOLD was asked for and is not there yet
    # after landing and disarming the intention is OFFBOARD again
    assert decide(situation(Phase.RELEASE, status=FLYING._replace(armed=False))) is None
    over = decide(situation(Phase.RELEASE, status=FLYING._replace(armed=False, mode=Mode.HOLD, intended=Mode.HOLD)))
    assert over is not None
    assert over[:2] == (Phase.DONE, Event.LET_GO)


def test_a_pilot_may_leave_and_come_back() -> None:
    on = situation(Phase.STAND_BY, authority=ControlAuthority.PILOT)
    assert decide(on) == (Phase.SETTLE, Event.IN_OFFBOARD, "the pilot selected OFFBOARD")
    named = on._replace(flown_in="Survey")  # as the pilot's ground station calls it
    assert decide(named) == (Phase.SETTLE, Event.IN_OFFBOARD, "the pilot selected Survey")
    waiting = decide(named._replace(phase=Phase.PREFLIGHT))
    assert waiting is not None and waiting[2].endswith("while the pilot has Survey selected")
    assert decide(on._replace(status=FLYING._replace(landed=Landed.ON_GROUND))) is None
    left = decide(situation(
        Phase.FOLLOW, authority=ControlAuthority.PILOT, status=FLYING._replace(mode=Mode.POSITION, intended=Mode.POSITION)
    ))  # fmt: skip
    assert left == (Phase.STAND_BY, Event.LEFT_OFFBOARD, "the pilot took over: the mode is Position now")
    assert decide(situation(Phase.HAND_BACK, authority=ControlAuthority.PILOT, now=1000.0, state_at=1000.0)) is None


def test_a_late_report_of_the_old_mode_is_not_a_human() -> None:
    """OFFBOARD was accepted, but a heartbeat sent before still says Hold."""
    old = FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD)
    just = situation(Phase.FOLLOW, status=old, mode_seen=False, decided_in=Mode.HOLD)
    assert decide(just) is None
    late = decide(just._replace(entered=10.0 - CONFIRM_WITHIN - 0.01))
    assert late is not None
    assert late[0] is Phase.HAND_BACK


def test_how_it_ends_is_the_users_choice() -> None:
    hold = FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD)
    for finish, from_ground, following in (
        (Finish.AS_BEGUN, True, Phase.LAND), (Finish.AS_BEGUN, False, Phase.DONE), (Finish.RETURN, False, Phase.RETURN),
        (Finish.LAND, False, Phase.LAND), (Finish.HOLD, True, Phase.DONE),
    ):  # fmt: skip
        held = decide(situation(Phase.HAND_BACK, finish=finish, from_ground=from_ground, status=hold))
        assert held is not None
        assert held[0] is following
    faulty = decide(situation(Phase.HAND_BACK, finish=Finish.LAND, faulty=True, status=hold))
    assert faulty is not None
    assert faulty[0] is Phase.DONE


def test_stop_hands_back_and_does_not_land() -> None:
    decision = decide(situation(Phase.FOLLOW, stop=True))
    assert decision is not None
    assert decision[0] is Phase.HAND_BACK
    held = decide(
        situation(
            Phase.HAND_BACK, stop=True, from_ground=True, status=FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD)
        )
    )
    assert held is not None
    assert held[0] is Phase.DONE
    held = decide(
        situation(Phase.HAND_BACK, from_ground=True, status=FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD))
    )
    assert held is not None
    assert held[0] is Phase.LAND


def test_refusals() -> None:
    later = Answer(Request.OFFBOARD, MavResult.TEMPORARILY_REJECTED)
    no = Answer(Request.OFFBOARD, MavResult.DENIED)
    waiting = FLYING._replace(mode=Mode.HOLD, intended=Mode.HOLD)
    assert (
        decide(situation(Phase.TAKE_OVER, answer=later, status=waiting, decided_in=Mode.HOLD, mode_seen=False)) is None
    )  # asked again until the time is out
    decision = decide(situation(Phase.TAKE_OVER, answer=no, status=waiting, decided_in=Mode.HOLD, mode_seen=False))
    assert decision is not None
    assert decision[2] == "the vehicle refused offboard mode: denied"
    decision = decide(
        situation(Phase.TAKE_OVER, answer=later, status=waiting, entered=4.0, decided_in=Mode.HOLD, mode_seen=False)
    )
    assert decision is not None
    assert decision[2] == "take over was not done within 5 s: the vehicle answered temporarily rejected"


def test_random_walks_never_raise_and_always_end() -> None:
    """Any statuses, answers and clocks, for as long as it takes."""
    rng = random.Random(5)
    for _ in range(300):
        phase, entered, now = Phase.PREFLIGHT, 0.0, 0.0
        for _ in range(4000):
            now += rng.choice((0.004, 0.05, 1.0, 20.0))
            request = PHASES[phase].request
            decision = decide(
                Situation(
                    phase=phase,
                    now=now,
                    entered=entered,
                    status=KnownStatus(
                        armed=rng.choice((None, True, False)),
                        mode=rng.choice((None, *Mode)),
                        intended=rng.choice((None, *Mode)),
                        landed=rng.choice((None, *Landed)),
                        ready=rng.choice((None, True, False)),
                        failsafe=rng.choice((None, True, False)),
                        mode_age=rng.choice((0.0, 0.5, 2.0, 3.0, math.inf)),
                        was_armed=rng.random() < 0.2,
                    ),
                    mode_seen=rng.random() < 0.5,
                    state_at=rng.choice((None, now, now - 1.0)),
                    answer=None
                    if request is None
                    else rng.choice((None, Answer(request, rng.choice(list(MavResult))))),
                    from_ground=rng.random() < 0.5,
                    authority=rng.choice(list(ControlAuthority)),
                    finish=rng.choice(list(Finish)),
                    faulty=rng.random() < 0.5,
                    stop=rng.random() < 0.02,
                    missing=rng.choice((None, "no state arrives")),
                    settled=rng.random() < 0.5,
                    joined=rng.random() < 0.5,
                    at_end=rng.random() < 0.1,
                    goes_back=rng.random() < 0.5,
                    finished=rng.choice((None, None, None, "flew 1 laps")),
                    law_error=rng.choice((None, None, None, None, "singular")),
                    verdict=Verdict(rng.choice(list(Action)), "because"),
                    decided_in=rng.choice((None, *Mode)),
                    asked=rng.randrange(4),
                    unusable=rng.choice((None, "the same one comes again and again")),
                    late=rng.choice((0.0, 0.15)),
                    answered=rng.choice((0.0, 1.0)),
                    armed_heard=rng.choice((0.0, 0.5, math.inf)),
                )
            )
            if decision is not None:
                assert decision[2]  # every event has its reason
                phase, entered = decision[0], now
            if phase is Phase.DONE:
                break
        assert phase is Phase.DONE


def test_the_diagram_in_the_docs_is_the_table() -> None:
    page = (Path(__file__).parents[2] / "docs" / "flight.md").read_text(encoding="utf-8")
    assert diagram() in page
    assert pre_emption_table() in page
    assert table() in page
