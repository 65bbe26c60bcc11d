"""What the filter says its state and innovations go by with the motors' lag and the thrust curve, beside two filters."""

from __future__ import annotations

import random

import numpy as np
import pytest

from companion.calculus.machine_code import unpacked
from companion.estimation.kalman import initial_belief, predict_and_update
from companion.estimation.kalman_step import PARAMETERS, SIZE
from companion.estimation.noise_levels import NoiseLevels

G = 9.80665
LEVELS = NoiseLevels(
    1e-6, 1e-4, (0.01, 0.02, 0.03), (0.04, 0.05, 0.06), (0.09, 0.1, 0.04), (0.002, 0.003, 0.004), 0.05**2, 0.03**2
)


@pytest.mark.parametrize("frozen", [False, True])
@pytest.mark.parametrize("parameter", PARAMETERS)
def test_the_slopes_of_state_and_innovation_are_those_of_two_filters(parameter: str, frozen: bool) -> None:
    """Measured as one of them predicts: what its gains go by with the parameter, which is left out, says nothing then.
    The other parameter has a slope of its own and keeps out of it."""
    rng, d = random.Random(2), 1e-5
    one = other = initial_belief((1.0, 2.0, -3.0), (0.5, 0.0, 0.0), (0.1, 0.0, 0.0), (1.0, 0.2), (0.3, 0.5), LEVELS)
    for k in range(80):
        F = (rng.gauss(0.0, 1.0), rng.gauss(0.0, 1.0), rng.gauss(G, 1.0))
        by = (rng.gauss(0.0, 2.0), rng.gauss(0.0, 2.0), rng.gauss(0.0, 20.0))
        slopes = [by if each == parameter else (1.0, -2.0, 5.0) for each in PARAMETERS]
        z, learning = np.zeros(6), not (frozen and k % 3 == 0)
        for _ in range(4):  # the velocities' prediction goes with the positions' innovation
            p, v = (z[0], z[1], z[2]), (z[3], z[4], z[5])
            told, seen = predict_and_update(
                one, 0.01, F, G, p, v, LEVELS, learning, thrust_by_lag_n=slopes[0], thrust_by_curve_n=slopes[1]
            )
            z -= seen.residual
        one, more = told, (F[0] + d * by[0], F[1] + d * by[1], F[2] + d * by[2])
        other, seen_other = predict_and_update(other, 0.01, more, G, p, v, LEVELS, learning)
    of_state, of_innovation = unpacked(getattr(one, f"by_{parameter}")), getattr(seen, f"by_{parameter}")
    assert np.array(of_state) == pytest.approx((np.array(other.x) - one.x) / d, rel=0.02, abs=0.01)
    difference = (np.array(seen_other.residual) - seen.residual) / d
    assert np.array(of_innovation) == pytest.approx(difference, rel=0.02, abs=0.01)
    assert len(of_state) == SIZE and max(map(abs, of_innovation)) > 0.1
    assert one.by_lag != one.by_curve
