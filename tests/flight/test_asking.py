"""What is asked of a vehicle: on fresh knowledge, three times at most, never against somebody's word."""

from __future__ import annotations

import itertools
import random

import pytest

from companion.flight.asking import BACK_AFTER, FRESH, TRIES, Asking, begin_asking, update_asking
from companion.flight.phases import PHASES, Phase, Request
from companion.flight.situation import Answer
from companion.mavlink_common import MavResult
from companion.vehicle import KnownStatus, Landed, Mode

ASKED_IN = [(phase, row.request) for phase, row in PHASES.items() if row.request is not None]
MODES = (None, Mode.HOLD, Mode.OFFBOARD, Mode.LAND, Mode.POSITION)


def some_status(rng: random.Random, away: float) -> KnownStatus:
    mode = rng.choice(MODES)
    return KnownStatus(
        armed=rng.choice((None, True, False)),
        mode=mode,
        intended=rng.choice((None, mode, Mode.OFFBOARD)),
        landed=rng.choice((None, Landed.ON_GROUND, Landed.IN_AIR)),
        mode_age=rng.choice((0.01, 0.2, 0.9, 1.2, away)),
        was_armed=rng.random() < 0.3,
    )


@pytest.mark.parametrize(("phase", "request_"), ASKED_IN)
def test_random_walks_ask_three_times_and_not_after_an_answer(phase: Phase, request_: Request) -> None:
    """Any statuses, answers and clocks: HOLD gets three more only where the link was away between."""
    rng = random.Random(f"{phase} {request_}")
    for _ in range(400):
        first = some_status(rng, BACK_AFTER + 1.0)
        asking = begin_asking(request_, None, first)
        assert asking is not None
        now, answer, sent_at, away_seen = 0.0, None, [], False
        for _ in range(150):
            now += rng.choice((0.004, 0.05, 0.3))
            status = some_status(rng, BACK_AFTER + 1.0)
            away_seen = away_seen or status.mode_age > BACK_AFTER
            asking, sent = update_asking(asking, answer, status, phase, now, lost=rng.random() < 0.5)
            if sent:
                assert answer is None or not answer.accepted
                assert status.mode_age <= FRESH
                if request_ is Request.HOLD:
                    assert Mode.OFFBOARD in (status.intended, status.mode)
                else:
                    assert status.mode is first.mode is not None
                if request_ is Request.ARM:
                    assert not status.was_armed
                    assert status.armed is False
                sent_at.append(now)
            if rng.random() < 0.03 and (answer is None or not answer.accepted):
                answer = Answer(request_, rng.choice(list(MavResult)))
        most = 2 * TRIES if request_ is Request.HOLD and away_seen else TRIES
        assert len(sent_at) <= most
        assert all(b - a > 0.34 for a, b in itertools.pairwise(sent_at))


def test_three_tries_lie_within_a_second_and_a_half_and_end() -> None:
    status = KnownStatus(armed=True, mode=Mode.HOLD, intended=Mode.HOLD, landed=Landed.IN_AIR, mode_age=0.1)
    asking, times = Asking(Request.OFFBOARD, Mode.HOLD), []
    for i in range(1000):
        asking, sent = update_asking(asking, None, status, Phase.TAKE_OVER, 0.01 * i, lost=False)
        times += [0.01 * i] if sent else []
    assert len(times) == TRIES
    assert times[-1] - times[0] <= 1.5
