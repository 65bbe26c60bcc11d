"""Whether a position or an attitude stands still while velocity or body rates say that it moves."""

from __future__ import annotations

import math

from companion.frames import Vec3
from companion.pilot.intake import compare_states
from companion.pilot.memory import StateAgreement, ThrustResponse
from companion.vehicle import VehicleState

DT = 0.008


def stood(v_n: Vec3, moves_by: Vec3, noise: float = 0.0, w_b: Vec3 = (0.0, 0.0, 0.0)) -> list[StateAgreement]:
    """The agreements over half a second of states whose position moves by other than ``v_n``."""
    agreement, found = StateAgreement(), []
    for n in range(60):
        shaken = noise * math.sin(40.0 * n)
        p_n = (moves_by[0] * n * DT + shaken, moves_by[1] * n * DT - shaken, moves_by[2] * n * DT)
        state = VehicleState(n * DT, p_n, v_n, (1.0, shaken, 0.0, 0.0), w_b)
        agreement = compare_states(agreement, state, ThrustResponse())
        found.append(agreement)
    return found


def test_a_position_that_creeps_under_a_shaken_estimator_is_believed() -> None:
    """As PX4's EKF said it in SIH when the path was reached: 0.53 m/s, of which the position made 0.16."""
    found = stood((0.33, -0.39, 0.13), (0.03, -0.10, -0.12))
    assert not any(agreement.place_stands for agreement in found)
    assert max(agreement.velocity_off for agreement in found) < 0.6


def test_a_position_that_stands_but_for_noise_is_told_within_the_window() -> None:
    for noise in (1e-6, 1e-3):
        found = stood((0.8, -0.9, 0.0), (0.0, 0.0, 0.0), noise)
        assert all(agreement.place_stands for agreement in found[16:]), noise


def test_an_attitude_that_stands_but_for_noise_is_told() -> None:
    found = stood((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1e-6, (0.0, 0.1, 0.0))
    assert all(agreement.attitude_stands for agreement in found[16:])
    assert not any(agreement.place_stands for agreement in found)
