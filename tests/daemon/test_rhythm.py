"""When a state is expected, and what the control thread does with the time before; what the system permits."""

from __future__ import annotations

import math
import random
from collections.abc import Collection
from types import SimpleNamespace
from typing import Any, cast

import pytest

from companion import pilot
from companion.daemon import realtime
from companion.daemon.priority import split_by_priority
from companion.daemon.rhythm import MARGIN, WATCH_MAX, Rhythm
from companion.daemon.warm_up import WarmUp
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.mavlink.peer import LINE, Received
from companion.mavlink.telemetry import WANTED
from tests.support.flights import Flown, flight

PERIOD = 0.004


def heard(rhythm: Rhythm, count: int, jitter: float, begin: float = 0.0, seed: int = 3) -> float:
    """Let states arrive; when the next is due."""
    rng = random.Random(seed)
    for i in range(count):
        rhythm.add_arrival(begin + i * PERIOD + rng.uniform(-jitter, jitter))
    return begin + count * PERIOD


def test_it_is_ready_a_little_before_a_state_is_due() -> None:
    rhythm = Rhythm()
    due = heard(rhythm, 400, 5e-5)
    now = rhythm.warm_up_at(due - 0.5 * PERIOD)
    assert due - 1e-3 < now < due - 2.0 * MARGIN
    times = 0
    while (at := rhythm.warm_up_at(now)) < math.inf:
        assert at == now  # one after the other
        now += 2e-4
        rhythm.add_warm_up(at, now)
        times += 1
    assert times >= 2
    assert due - 3.0 * MARGIN - 2e-4 < now < due - MARGIN  # until none fits before the state
    assert due < rhythm.watch_until <= now + WATCH_MAX
    rhythm.add_arrival(due)
    assert rhythm.watch_until == -math.inf
    assert rhythm.warm_up_at(due) < math.inf


def test_without_a_rhythm_it_waits() -> None:
    assert Rhythm().warm_up_at(0.0) == math.inf
    rhythm = Rhythm()
    due = heard(rhythm, 400, 1.9e-3)
    assert rhythm.warm_up_at(due - 0.5 * PERIOD) == math.inf
    rhythm = Rhythm()
    due = heard(rhythm, 2, 0.0)
    assert rhythm.warm_up_at(due - 0.5 * PERIOD) == math.inf  # two are not enough to know


def test_a_stall_is_no_part_of_the_rhythm() -> None:
    rhythm = Rhythm()
    due = heard(rhythm, 400, 5e-5) + 3.0
    due = heard(rhythm, 400, 5e-5, due)
    assert due - 1e-3 < rhythm.warm_up_at(due - 0.5 * PERIOD) < due


def test_a_lost_state_leaves_the_rhythm_as_it_is() -> None:
    rng, rhythm = random.Random(5), Rhythm()
    for i in range(600):
        if i < 300 or rng.random() > 0.3:
            rhythm.add_arrival(i * PERIOD + rng.uniform(-5e-5, 5e-5))
            if i >= 300:
                due = (i + 1) * PERIOD
                assert due - 1e-3 < rhythm.warm_up_at(due - 0.5 * PERIOD) < due


@pytest.mark.parametrize("begun", [0.0, 0.1 * PERIOD, 2.0 * PERIOD])
def test_a_false_start_is_forgotten(begun: float) -> None:
    """The first two at once, in a burst, or with one lost between them."""
    rhythm = Rhythm()
    rhythm.add_arrival(-begun)
    rhythm.add_arrival(0.0)
    due = heard(rhythm, 300, 5e-5, PERIOD)
    assert due - 1e-3 < rhythm.warm_up_at(due - 0.5 * PERIOD) < due


def test_another_rate_is_another_rhythm() -> None:
    rhythm = Rhythm()
    due = heard(rhythm, 400, 5e-5)
    for i in range(400):
        rhythm.add_arrival(due + 2.0 * i * PERIOD)
    due += 800.0 * PERIOD
    assert due - 1e-3 < rhythm.warm_up_at(due - PERIOD) < due


def test_a_slow_machine_does_not_warm_up() -> None:
    rhythm = Rhythm()
    for _ in range(200):
        at = heard(rhythm, 1, 0.0, _ * PERIOD)
        rhythm.add_warm_up(at, at + 2e-3)
    assert rhythm.warm_up_at(at - 0.5 * PERIOD) == math.inf


def test_states_that_came_during_warm_ups_make_them_earlier() -> None:
    early, late = Rhythm(), Rhythm()
    for i in range(300):
        early.add_arrival(i * PERIOD)
        if i % 2:
            late.was_late()
        late.add_arrival(i * PERIOD + (1e-4 if i % 2 else 0.0))
    now = 299.5 * PERIOD
    assert late.warm_up_at(now) < early.warm_up_at(now)


def test_what_the_setpoint_needs_goes_first() -> None:
    encoder = Encoder(1, 1)
    frames = (encoder.message(message(name)) for name in ("ODOMETRY", "CURRENT_MODE", "VFR_HUD"))
    state, mode, unread = ((frame, LINE) for frame in frames)

    def split(batch: list[Received], wanted: Collection[int] | None = WANTED) -> tuple[list[Received], list[Received]]:
        return split_by_priority(batch, wanted, LINE)

    assert split([mode, state, mode, unread]) == ([mode, state], [mode, unread])
    assert split([state, mode, state]) == ([state, mode, state], [])
    assert split([mode, unread]) == ([mode, unread], [])  # no state, no hurry
    assert split([unread, mode, state]) == ([mode, state], [unread])
    assert split([unread, mode, state], None) == ([unread, mode, state], [])
    two = (unread[0] + mode[0], LINE)  # what else may be in there is not known from the first bytes
    empty, cut = (b"", LINE), (b"\xfd", LINE)
    assert split([two, empty, cut, state]) == ([two, empty, cut, state], [])


def test_another_source_can_wait() -> None:
    state, mode = (Encoder(1, 1).message(message(name)) for name in ("ODOMETRY", "CURRENT_MODE"))
    stranger = ("127.0.0.1", 9)
    batch: list[Received] = [(mode, stranger), (state, LINE), (state, stranger)]
    assert split_by_priority(batch, WANTED, LINE) == ([batch[1]], [batch[0], batch[2]])


def test_a_warm_up_leaves_no_trace() -> None:
    """The same flight, bit for bit, with a warm-up at every step; and it does the work of the tick it repeats."""
    warm_up, flown_again = WarmUp(), []

    def meddle(flown: Flown, now: float) -> None:
        flown_again.append(warm_up.run(flown.conductor))

    plain = flight(duration=1.0)
    warmed = flight(duration=1.0, meddle=meddle)
    assert warmed.setpoints == plain.setpoints
    assert sum(flown_again) > 200
    tick = warmed.conductor.last
    assert tick is not None
    assert warmed.conductor.plan is not None
    assert pilot.step(warmed.conductor.plan, tick.before, tick.observation, tick.now) == (tick.memory, tick.outcome)


def test_a_conductor_without_a_plan_has_nothing_to_warm_up() -> None:
    assert WarmUp().run(cast(Any, SimpleNamespace(last=None, plan=None))) is False


def test_what_is_permitted_is_said_in_one_line() -> None:
    assert realtime._realtime_words(True, True) == "real time: SCHED_FIFO 50 and locked memory"
    assert realtime._realtime_words(False, False) == (
        "real time: at normal priority; not permitted: SCHED_FIFO (LimitRTPRIO=50 or CAP_SYS_NICE), "
        "locked memory (LimitMEMLOCK=infinity or CAP_IPC_LOCK)"
    )
    assert "not permitted: locked memory" in realtime._realtime_words(True, False)


def test_priority_is_given_back() -> None:
    import os

    before = os.sched_getscheduler(0)
    with realtime.punctual() as told:
        assert told.startswith("real time: ")
    assert os.sched_getscheduler(0) == before
