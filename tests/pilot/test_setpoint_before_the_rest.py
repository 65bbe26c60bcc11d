"""The setpoint that goes out before the rest of its tick: when it may, and what holds it back."""

from __future__ import annotations

import math

import pytest

from companion import pilot
from companion.daemon.conductor import Tick
from companion.flight.phases import Phase
from companion.flight.safety import NOTHING_SINCE
from companion.pilot import Memory, Observation
from companion.plan import Plan
from companion.vehicle import Fact, Mode, VehicleState
from tests.support.flights import Flown, flight

pytestmark = pytest.mark.xdist_group("setpoint_before_the_rest")


@pytest.fixture(scope="module")
def following() -> tuple[Plan, Tick]:
    """A tick in the middle of following."""
    ticks: list[Tick] = []

    def meddle(flown: Flown, now: float) -> None:
        last = flown.conductor.last
        if last is not None and last.before.phase is Phase.FOLLOW and last.observation.state is not None:
            ticks.append(last)

    plan = flight(duration=1.0, meddle=meddle).conductor.plan
    assert plan is not None
    return plan, ticks[len(ticks) // 2]


def early(plan: Plan, memory: Memory, observation: Observation, now: float) -> bool:
    """Whether the setpoint would go out first."""
    return pilot.compute_setpoint(plan, memory, observation, now)[1] is not None


def test_the_setpoint_goes_first_and_is_the_tick_s(following: tuple[Plan, Tick]) -> None:
    plan, tick = following
    memory, first = pilot.compute_setpoint(plan, tick.before, tick.observation, tick.now)
    assert first is not None
    assert first.steered.setpoint == tick.outcome.setpoint
    assert pilot.supervise(plan, memory, tick.observation, tick.now, first) == (tick.memory, tick.outcome)


def test_what_must_stop_the_setpoint_is_never_late(following: tuple[Plan, Tick]) -> None:
    plan, (observation, _, _, now, before) = following
    status, state = observation.status, observation.state
    assert state is not None
    seconds_back = state._replace(t_boot=state.t_boot - 0.01)
    restarted = state._replace(t_boot=state.t_boot - 60.0)
    ahead = state._replace(t_boot=state.t_boot + 1.0)
    moved = state._replace(p_n=(state.p_n[0] + 20.0, *state.p_n[1:]), resets=state.resets + 1)
    for bad in (
        observation._replace(state=None),
        *(observation._replace(state=wrong) for wrong in (seconds_back, restarted, ahead, moved)),
        observation._replace(stop=True),
        observation._replace(companions=1),
        observation._replace(status=status._replace(mode=Fact(Mode.HOLD, now, 1.5))),
        observation._replace(status=status._replace(armed=Fact(False, now, 2.5))),
    ):
        assert not early(plan, before, bad, now)
    assert not early(plan, before._replace(breaches=(now, *NOTHING_SINCE[1:])), observation, now)
    assert not early(plan, before._replace(phase=Phase.HAND_BACK), observation, now)


def test_an_error_of_the_law_is_acted_on_in_its_own_tick(following: tuple[Plan, Tick]) -> None:
    plan, (observation, _, _, now, before) = following
    assert observation.state is not None
    broken: VehicleState = observation.state._replace(p_n=(math.nan,) * 3)
    assert not early(plan, before, observation._replace(state=broken), now)
    memory, outcome = pilot.step(plan, before, observation._replace(state=broken), now)
    assert memory.phase is Phase.ABORT
    assert outcome.setpoint is not None
