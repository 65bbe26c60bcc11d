"""Factors on the speed multiply as functions of time."""

from __future__ import annotations

import pytest

from companion.law.speed_scale import BACKWARDS, STANDSTILL, UNITY, SpeedScale

A, B, C = SpeedScale(0.8, 0.3, -0.4), SpeedScale(0.9, -0.2, 0.7), SpeedScale(1.2, 0.1, -0.3)


def at(scale: SpeedScale, t: float) -> float:
    return scale.value + scale.rate * t + 0.5 * scale.acceleration * t * t


def test_the_mission_s_own_speed_changes_nothing() -> None:
    assert A * UNITY == A
    assert UNITY * A == A
    assert A * SpeedScale() == A


def test_standing_still_stays_still() -> None:
    assert SpeedScale(0.0, 0.0, 0.0) == STANDSTILL * A


def test_backwards_turns_every_sign() -> None:
    assert SpeedScale(-0.8, -0.3, 0.4) == A * BACKWARDS
    assert A * BACKWARDS * BACKWARDS == A


def test_a_product_is_the_product_with_its_derivatives() -> None:
    h, made = 1e-4, A * B
    before, now, after = (at(A, t) * at(B, t) for t in (-h, 0.0, h))
    assert made.value == pytest.approx(now, rel=1e-15)
    assert made.rate == pytest.approx((after - before) / (2.0 * h), abs=1e-6)
    assert made.acceleration == pytest.approx((after - 2.0 * now + before) / h**2, abs=1e-6)


def test_the_order_does_not_matter() -> None:
    assert pytest.approx(B * A, rel=1e-15) == A * B
    assert pytest.approx(A * (B * C), rel=1e-15) == (A * B) * C
