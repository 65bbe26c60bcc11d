"""The planned yaw rate: the optimum of its cost, held to a numerical one; without lag, within its bounds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from companion.steering.yaw import Turning, WantedYaw, YawLoop, YawMemory, compensate_yaw
from companion.steering.yaw_forecast import FORECAST_LENGTH, FORECAST_STEP
from companion.steering.yaw_reference import HEADING_WORTH, YawDrive, YawReference, advance_reference, solution

FREE = YawDrive(lag=0.37, torque_lag=0.12, authority=2.0, low=-math.inf, high=math.inf)
LEAD, H = 0.07, 0.004


def forecast(wanted: Callable[[float], float], t: float) -> tuple[float, ...]:
    return tuple(wanted(t + k * FORECAST_STEP) for k in range(FORECAST_LENGTH))


@pytest.mark.parametrize("lag", [0.1, 0.37, 0.8])
@pytest.mark.parametrize("torque_lag", [0.03, 0.12, 0.3])
def test_its_poles_are_the_optimum_of_riccati(lag: float, torque_lag: float) -> None:
    grid = [math.exp(round(20.0 * math.log(value)) / 20.0) for value in (lag, torque_lag, 2.0)]
    T, theta, most = grid
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / theta]])
    B = np.array([[0.0], [0.0], [1.0 / (T * theta)]])
    Q, R = np.diag([HEADING_WORTH**-2, 0.0, 0.0]), np.array([[most**-2]])
    K = np.linalg.solve(R, B.T @ solve_continuous_are(A, B, Q, R))
    d2, d1, d0, weights = solution(YawDrive(lag, torque_lag, 2.0, 0.0, 0.0))
    assert np.poly(A - B @ K) == pytest.approx([1.0, d2, d1, d0], rel=1e-6)
    assert sum(weights) == pytest.approx(d1 / d0)  # a steady rate is followed


def test_a_steady_rate_is_followed_without_an_error() -> None:
    planned = YawReference()
    for _ in range(1000):
        planned = advance_reference(planned, (0.5,) * FORECAST_LENGTH, FREE, H)
    assert planned == pytest.approx((0.0, 0.5, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("rate", [1.0, 3.0, 5.0])
def test_what_swings_is_followed_with_hardly_a_lag(rate: float) -> None:
    def wanted(t: float) -> float:
        return math.sin(rate * t)

    planned, lagging, size = YawReference(), 0.0, 0.0
    for k in range(4000):
        t = k * H
        planned = advance_reference(planned, forecast(wanted, t), FREE, H)
        if t > 16.0 - 2.0 * math.tau / rate:
            lagging += planned.rate * math.cos(rate * (t + H))
            size += planned.rate * math.sin(rate * (t + H))
    assert abs(lagging) < 0.035 * rate * size  # the forecast ends after 0.4 s


def test_a_pulse_is_met_half_way_by_beginning_before_it() -> None:
    def pulse(t: float) -> float:
        return 1.3 * math.exp(-(((t - 2.0) / 0.2) ** 2))

    planned, errors = YawReference(), []
    for k in range(1000):
        planned = advance_reference(planned, forecast(pulse, k * H), FREE, H)
        errors.append(planned.error)
    assert 0.4 < max(errors) / -min(errors) < 2.5
    assert max(map(abs, errors)) < 0.25 * 1.3 * 0.2 * math.sqrt(math.pi)  # of the turn
    assert abs(errors[-1]) < 0.01


def test_it_stays_within_what_the_vehicle_has() -> None:
    bound, planned = FREE._replace(low=-0.5, high=0.8), YawReference()
    for k in range(500):
        planned = advance_reference(planned, (4.0 * math.sin(k * H * 3.0),) * FORECAST_LENGTH, bound, H)
        assert -0.5 <= planned.drive <= 0.8
    assert abs(planned.error) <= 0.35


def test_seldom_states_do_not_swing_it() -> None:
    planned = YawReference(error=0.1)
    for _ in range(60):
        planned = advance_reference(planned, (0.0,) * FORECAST_LENGTH, FREE, 0.07)
    assert planned == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-4)


class TestTheWhole:
    """What is planned and what is commanded, on the model of the loop."""

    LOOP = YawLoop(lag=0.37, torque_lag=0.12, error_rate=2.5 / 0.37)

    def flown(
        self, wanted: Callable[[float], float], heading: float = 0.0, *, ahead: bool = True, most: float = math.inf,
        gain: float = 1.0,
    ) -> list[float]:  # fmt: skip
        """rad: the heading error at every step of 8 ms for 8 s, of a loop with a trim that yaws at ``wanted``.
        ``gain``: of a loop that is damped."""
        loop = self.LOOP._replace(gain=gain)
        dt, trim, memory = 0.008, 0.2, YawMemory()
        e, r, r_dot, errors = heading, 0.0, 0.0, list[float]()
        for k in range(1000):
            t = k * dt
            coming = forecast(wanted, t) if ahead else None
            there = e + LEAD * (r - wanted(t))
            law = WantedYaw(wanted(t + LEAD), there, 3.0, 1.0, coming, LEAD, chosen=False)
            commanded, memory = compensate_yaw(memory, loop, law, Turning(r, r_dot, trim, 2.0, most), dt)
            assert abs(commanded) <= most or abs(commanded - r) <= 2.0
            driven = gain * (min(max(commanded, -most), most) + trim)
            for _ in range(8):
                r_dot += 0.001 * ((driven - r) / loop.lag - r_dot) / loop.torque_lag
                r += 0.001 * r_dot
                e += 0.001 * (r - wanted(t))
            errors.append(e)
        return errors

    def test_a_heading_error_goes_as_the_gain_says(self) -> None:
        errors = self.flown(lambda t: 0.0, heading=0.1)
        assert 0.25 < next(k for k, e in enumerate(errors) if e < 0.1 / math.e) * 0.008 < 0.6
        assert abs(errors[-1]) < 1e-3
        assert min(errors) > -0.015

    def test_a_bend_is_kept_better_where_it_was_known(self) -> None:
        def bends(t: float) -> float:
            return 1.2 * math.sin(2.6 * t) ** 5

        known, unknown = (max(map(abs, self.flown(bends, ahead=ahead)[500:])) for ahead in (True, False))
        assert known < 0.5 * unknown
        assert known < math.radians(3.0)

    def test_a_damped_loop_is_led_as_well(self) -> None:
        errors = self.flown(lambda t: 1.2 * math.sin(2.6 * t) ** 5, gain=0.75)
        assert max(map(abs, errors[500:])) < math.radians(4.0)

    def test_a_bend_beyond_the_limit_does_not_wind_it_up(self) -> None:
        errors = self.flown(lambda t: 1.5 if 2.0 < t < 3.0 else 0.0, most=1.0)
        assert max(map(abs, errors)) > 0.15
        assert abs(errors[-1]) < 0.01
