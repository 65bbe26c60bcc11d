"""Poles and gains of Eq. (9)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.law.gains import Level, auto_gains, default_gains, from_poles, mean_pole, path_pole_of, poles_of


def test_by_hand() -> None:
    assert from_poles([-2.0] * 4) == (16.0, 32.0, 24.0, 8.0)  # (s + 2)^4
    assert from_poles([-1.0, -3.0]) == (3.0, 4.0)
    assert from_poles([-1.5]) == (1.5,)


@given(st.lists(st.floats(-9.0, -0.2), min_size=1, max_size=4, unique_by=lambda p: round(p)))
def test_poles_come_back(poles: list[float]) -> None:
    found = sorted(root.real for root in poles_of(from_poles(poles)))
    assert found == pytest.approx(sorted(poles), rel=1e-3, abs=1e-3)


def test_defaults_fit_their_level() -> None:
    assert Level.MOTORS.degrees == (4, 4, 3, 2)
    assert Level.RATES.degrees == (3, 3, 2, 1)
    for level in Level:
        gains = default_gains(level)
        assert tuple(map(len, gains.each)) == level.degrees
        for k in gains.each:
            assert max(root.real for root in poles_of(k)) < 0.0


def test_complex_poles_come_in_pairs_and_make_real_gains() -> None:
    assert from_poles([-2.0 + 1.0j, -2.0 - 1.0j]) == (5.0, 4.0)  # (s + 2)^2 + 1
    assert all(isinstance(k, float) for k in from_poles([-1.0, -2.0 + 1.0j, -2.0 - 1.0j]))


def test_gains_chosen_for_a_flight_are_as_fast_as_the_delay_allows() -> None:
    chosen = [auto_gains(Level.RATES, horizon, 0.8 * horizon) for horizon in (0.05, 0.1, 0.3)]
    for output, wanted in (("h1", [-7.0, -6.0, -4.0]), ("vertical", [-10.5, -7.5, -4.0]), ("h3", [-3.0, -3.0, -3.0])):
        poles = [mean_pole(getattr(gains, output)) for gains in chosen]
        assert poles == pytest.approx(wanted)
    assert chosen[0].h1 == chosen[0].h2
    assert chosen[0].h4 == (4.0,)
    damping = [-root.real / abs(root) for root in poles_of(chosen[0].h1)]
    assert sorted(damping) == pytest.approx([0.85, 0.85, 1.0])
    assert auto_gains(Level.RATES, 0.05, None).vertical is None
    motors = auto_gains(Level.MOTORS, 0.1, 0.1)
    assert path_pole_of(motors) == pytest.approx(-5.0)
    assert sorted(map(abs, poles_of(motors.h1))) == pytest.approx([5.0, 5.0, 5.0, 8.0], abs=1e-3)
    assert sorted(root.real for root in poles_of(motors.h3)) == pytest.approx([-8.0, -3.0, -3.0], abs=1e-3)
    assert motors.h4 == pytest.approx(from_poles((-3.0, -3.0)))
    assert motors.vertical is not None
    assert sorted(map(abs, poles_of(motors.vertical))) == pytest.approx([6.0, 6.0, 6.0, 12.0], abs=1e-3)


def test_motors_slower_than_the_rate_loop_make_the_height_slower() -> None:
    """Their thrust is led by the difference; and they may be slower than they are told."""
    for horizon, thrust_horizon, late in ((0.03, 0.08, 0.05), (0.07, 0.033, 0.035)):
        gains = auto_gains(Level.RATES, horizon, thrust_horizon)
        assert gains.vertical is not None
        assert mean_pole(gains.vertical) == pytest.approx(-0.3 / late)


@pytest.mark.parametrize(
    ("level", "horizons", "least"), [(Level.RATES, (0.11, 0.058), 1.5), (Level.MOTORS, (0.058, 0.058), 1.4)]
)
def test_between_level_and_vertical_gains_every_mixture_is_damped(
    level: Level, horizons: tuple[float, float], least: float
) -> None:
    """On a path that slopes the vertical direction has one (law.feedback.with_vertical)."""
    gains = auto_gains(level, *horizons)
    assert gains.vertical is not None
    assert least < mean_pole(gains.vertical) / mean_pole(gains.h1) < 2.0
    for share in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0):
        mixed = [(1.0 - share) * a + share * b for a, b in zip(gains.h1, gains.vertical, strict=True)]
        assert all(-root.real > 0.65 * abs(root) for root in poles_of(mixed))
