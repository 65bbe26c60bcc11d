"""A change of the thrust scale: what is none is not taken for one."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator

import pytest

from companion.estimation.estimator import (
    EstimatorState,
    Measurement,
    Prior,
    initial_estimator_state,
    update_estimate,
)
from companion.estimation.scale_change import MEMORY, STEADY, ScaleChange, fade_scale_change
from companion.frames import rotation_matrix

G = 9.80665
STILL = (0.0, 0.0, 0.0)


def test_a_step_that_teaches_nothing_lets_it_fade() -> None:
    assert fade_scale_change(STEADY, 0.01) == STEADY
    known = ScaleChange(score=3.0, information=2.0, variance=1.0)
    later = fade_scale_change(known, 0.1)
    assert later.score < known.score and later.variance < known.variance
    assert later.score / math.sqrt(later.variance) == pytest.approx(3.0)
    assert fade_scale_change(known, 10.0) == STEADY


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_gusts_are_no_change_of_it_where_learning_stops_every_now_and_then(seed: int) -> None:
    """A hover in vertical gusts of 0.3 m/s^2, a command at its limit every 0.7 s: begun anew behind each of them, the
    score was beyond four deviations once or twice in half a minute."""
    found = 0
    for t, state in hover(seed, lambda t: 1.0, limited_every=0.7):
        found += t > 8.0 and not state.past
    assert found == 0
    assert state.belief.thrust_scale == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize(("seed", "step"), [(0, 1.25), (1, 1.25), (2, 1.25), (3, 0.8), (4, 0.8)])
def test_a_change_is_known_within_a_second_and_looked_for_again(seed: int, step: float) -> None:
    at, back = 10.0, 20.0
    error = {}
    for t, state in hover(seed, lambda t: step if at < t < back else 1.0):
        error[round(t, 3)] = state.belief.thrust_scale / (step if at < t < back else 1.0) - 1.0
    assert abs(error[at + 1.0]) < 0.08 and abs(error[back + 1.0]) < 0.08
    assert abs(error[at + 5.0]) < 0.03 and abs(error[back + 5.0]) < 0.03


def test_what_is_gone_through_again_is_the_last_second_and_no_more() -> None:
    for t, state in hover(0, lambda t: 1.0):
        assert not any(step.before.past for step in state.past)
        if t > 5.0:
            since = state.flight_time - state.past[0].before.flight_time
            assert since == pytest.approx(MEMORY, abs=0.01)


def hover(
    seed: int, thrust_scale: Callable[[float], float], limited_every: float = math.inf
) -> Iterator[tuple[float, EstimatorState]]:
    """s and what is known, of 40 s in vertical gusts of 0.3 m/s^2. ``limited_every``: s between commands at their
    limit, a mean."""
    rng = random.Random(seed)
    state = initial_estimator_state(STILL, STILL, rotation_matrix((1.0, 0.0, 0.0, 0.0)), G, Prior())
    p, v, gust, dt = 0.0, 0.0, 0.0, 0.008
    for k in range(5000):
        thrust = (G + 2.0 * v + 1.5 * p + state.belief.disturbance_n[2]) / state.belief.thrust_scale
        gust += -gust * dt / 0.3 + 0.3 * math.sqrt(2.0 * dt / 0.3) * rng.gauss(0.0, 1.0)
        a = G - thrust_scale(k * dt) * thrust + gust
        p, v = p + dt * v + 0.5 * dt * dt * a, v + dt * a
        limited = rng.random() < dt / limited_every
        at, fast = p + rng.gauss(0.0, 0.002), v + rng.gauss(0.0, 0.01)
        measurement = Measurement(dt, (0.0, 0.0, thrust), (0.0, 0.0, at), (0.0, 0.0, fast), limited=limited)
        state = update_estimate(state, measurement, G)
        yield k * dt, state
