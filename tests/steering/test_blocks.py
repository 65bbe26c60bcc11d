"""The blocks of the rate level: each at zero, then its signs, then what always holds."""

from __future__ import annotations

import math
import random

import pytest

from companion.estimation.dead_time import DELAY_MAX, DELAY_SLEW, PX4_STEP, update_dead_time
from companion.estimation.rate_loop_model import TimedCommand, alike, recent_commands
from companion.estimation.translation import acceleration
from companion.frames import Vec3, rotation_matrix
from companion.law.errors import LawError
from companion.steering.limits import (
    LEVEL_RATE_MAX,
    THRUST_MAX,
    THRUST_MIN,
    TILT_RATE_MAX,
    ThrustConversion,
    levelling_rates,
    limit_rates,
    limit_thrust,
)
from companion.steering.timing import Timing
from companion.steering.yaw import (
    USUAL_THRUST_PER_RATE,
    YAW_AUTHORITY_MIN,
    Turning,
    YawLoop,
    follow_yaw,
    range_asked,
    usual_yaw_lag,
    yaw_authority,
    yaw_loop,
)
from companion.thrust_range import ThrustRange
from companion.vehicle import Limits

ZERO: Vec3 = (0.0, 0.0, 0.0)
LIMITS = Limits(tilt=0.8, body_rates=(3.0, 5.0, 1.0), speed=12.0)
RANGE = ThrustRange(2.0, 18.0, 30.0)
LOOP = YawLoop(lag=0.3, torque_lag=0.1, error_rate=6.0)
TURNING = Turning(r=0.0, r_dot=0.0, trim=0.0, authority=9.0, most=math.inf)
CONVERSION = ThrustConversion(mass=1.0, scale=1.0, per_specific=0.05)


class TestTranslation:
    def test_nothing_acts_in_a_hover(self) -> None:
        assert acceleration((0.0, 0.0, 9.8), ZERO, 9.8, 1.0, ZERO) == ZERO

    def test_signs(self) -> None:
        """Thrust lifts (up is -z), drag brakes, the disturbance pushes."""
        assert acceleration((0.0, 0.0, 12.0), ZERO, 9.8, 1.0, ZERO)[2] < 0.0
        assert acceleration((0.0, 0.0, 9.8), (1.0, -1.0, 0.0), 9.8, 0.5, ZERO) == (-0.5, 0.5, 0.0)
        assert acceleration((0.0, 0.0, 9.8), ZERO, 9.8, 0.5, (0.1, -0.2, 0.3)) == pytest.approx((0.1, -0.2, 0.3))


class TestLinkDelay:
    def test_nothing_measured_is_as_stated(self) -> None:
        assert update_dead_time(None, None, 0.01, 0.01) == 0.01

    def test_a_measured_link_counts_with_px4s_step(self) -> None:
        assert update_dead_time(None, 0.02, 0.01, 0.01) == 0.02 + PX4_STEP

    def test_it_follows_slowly_and_is_bounded(self) -> None:
        assert update_dead_time(0.01, 0.1, 0.01, 0.01) == pytest.approx(0.01 + 0.01 * DELAY_SLEW)
        assert update_dead_time(0.1, 0.0, 0.01, 0.01) == pytest.approx(0.1 - 0.01 * DELAY_SLEW)
        assert update_dead_time(None, 9.0, 0.01, 0.01) == DELAY_MAX


class TestLimitRates:
    def test_nothing_asked_nothing_sent(self) -> None:
        assert limit_rates(ZERO, (1.05, 1.05), LIMITS) == (ZERO, ZERO, False)

    def test_a_gain_of_the_loop_is_taken_back(self) -> None:
        limited = limit_rates((1.0, -1.0, 0.5), (1.05, 1.05), LIMITS)
        assert limited.sent == pytest.approx((1.0 / 1.05, -1.0 / 1.05, 0.5))
        assert limited.meant == pytest.approx((1.0, -1.0, 0.5))

    def test_always_within_the_limits_and_saturation_is_told_of_roll_and_pitch(self) -> None:
        rng = random.Random(1)
        for _ in range(200):
            turn = (rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(-9, 9))
            limited = limit_rates(turn, (1.0, 1.0), LIMITS)
            most = (3.0, TILT_RATE_MAX, 1.0)
            assert all(abs(sent) <= m for sent, m in zip(limited.sent, most, strict=True))
            assert all(sent * asked >= 0.0 for sent, asked in zip(limited.sent, turn, strict=True))
            assert limited.saturated is (abs(turn[0]) > most[0] or abs(turn[1]) > most[1])

    def test_without_limits_everything_goes_out(self) -> None:
        assert limit_rates((9.0, 9.0, 9.0), (1.0, 1.0), None).sent == (9.0, 9.0, 9.0)


class TestLimitThrust:
    def test_a_hover_stays(self) -> None:
        limited = limit_thrust(RANGE, 10.0, 0.0, 0.01, 20.0, 0.0, CONVERSION)
        assert limited == (10.0, 0.0, 0.5, 10.0, 10.0, False, False)

    def test_sooner_and_later_follow_the_slope(self) -> None:
        assert limit_thrust(RANGE, 10.0, 5.0, 0.01, 20.0, 0.02, CONVERSION).sent == pytest.approx(0.505)
        assert limit_thrust(RANGE, 10.0, 5.0, 0.01, 20.0, -0.02, CONVERSION).sent == pytest.approx(0.495)

    def test_no_windup_at_a_bound(self) -> None:
        up = limit_thrust(RANGE, 18.0, 20.0, 0.01, 20.0, 0.02, CONVERSION)
        assert (up.zeta, up.zeta_dot, up.saturated) == (18.0, 0.0, True)
        down = limit_thrust(RANGE, 2.0, -20.0, 0.01, 20.0, 0.02, CONVERSION)
        assert (down.zeta, down.zeta_dot, down.saturated) == (2.0, 0.0, True)
        weak = limit_thrust(RANGE, 12.0, 20.0, 0.01, 12.0, 0.0, CONVERSION)
        assert (weak.zeta, weak.saturated) == (12.0, True)

    def test_a_slope_that_is_limited_is_no_thrust_that_is(self) -> None:
        """The motors make what is sent, so that the estimator may learn from it."""
        for slope in (40.0, -40.0):
            limited = limit_thrust(RANGE, 10.0, slope, 0.01, 20.0, 0.0, CONVERSION)
            assert (limited.zeta_dot, limited.slew_limited, limited.saturated) == (
                math.copysign(30.0, slope),
                True,
                False,
            )
        assert not limit_thrust(RANGE, 10.0, 20.0, 0.01, 20.0, 0.0, CONVERSION).slew_limited

    def test_what_is_sent_is_always_within_its_range(self) -> None:
        for zeta in (2.0, 10.0, 18.0):
            for scale in (0.1, 1.0, 10.0):
                sent = limit_thrust(RANGE, zeta, 0.0, 0.01, 20.0, 0.0, CONVERSION._replace(scale=scale)).sent
                assert THRUST_MIN <= sent <= THRUST_MAX


class TestNotANumber:
    """A clamp lets it through: min(max(nan, low), high) is nan, and a NaN thrust stops the motors of PX4 1.18."""

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_it_is_never_sent(self, value: float) -> None:
        for turn in ((value, 0.0, 0.0), (0.0, value, 0.0), (0.0, 0.0, value)):
            with pytest.raises(LawError):
                limit_rates(turn, (1.0, 1.0), LIMITS)
        with pytest.raises(LawError):
            limit_thrust(RANGE, value, 0.0, 0.01, 20.0, 0.0, CONVERSION)
        with pytest.raises(LawError):
            limit_thrust(RANGE, 10.0, 0.0, 0.01, 20.0, 0.0, CONVERSION._replace(scale=math.nan))


class TestLevelling:
    def test_upright_needs_nothing(self) -> None:
        assert levelling_rates(rotation_matrix((1.0, 0.0, 0.0, 0.0))) == ZERO

    @pytest.mark.parametrize("axis", [0, 1])
    @pytest.mark.parametrize("angle", [-2.5, -0.3, 0.3, 2.5])
    def test_it_turns_back(self, axis: int, angle: float) -> None:
        q = [math.cos(0.5 * angle), 0.0, 0.0, 0.0]
        q[1 + axis] = math.sin(0.5 * angle)
        rates = levelling_rates(rotation_matrix((q[0], q[1], q[2], q[3])))
        assert rates[axis] * angle < 0.0
        assert abs(rates[axis]) <= LEVEL_RATE_MAX
        assert rates[2] == 0.0


class TestTiming:
    def test_no_delay_no_horizon(self) -> None:
        assert Timing(0.0, 0.0, 0.0, 0.0).horizon == 0.0
        assert Timing(0.0, 0.0, 0.0, 0.0).attitude == 0.0

    def test_everything_adds_up(self) -> None:
        timing = Timing(delay=0.014, hold=0.004, lag=0.071, smoothing=0.0)
        assert timing.horizon == pytest.approx(0.089)
        assert timing.attitude == pytest.approx(0.014 + 0.004 - 0.5 * PX4_STEP)


class TestYaw:
    def test_nothing_asked_nothing_commanded(self) -> None:
        assert follow_yaw(LOOP, 0.0, 0.0, TURNING) == 0.0

    def test_a_rate_that_is_already_there_is_commanded_as_it_is(self) -> None:
        assert follow_yaw(LOOP, 0.7, 0.0, TURNING._replace(r=0.7)) == 0.7

    def test_signs(self) -> None:
        assert follow_yaw(LOOP, 0.0, 1.0, TURNING) > 0.0
        assert follow_yaw(LOOP, 0.0, 0.0, TURNING._replace(trim=0.2)) == -0.2  # it turns by itself
        assert follow_yaw(LOOP, 0.5, 0.0, TURNING._replace(r=0.2)) > 0.5  # short of what is wanted
        assert follow_yaw(LOOP, 0.5, 0.0, TURNING._replace(r=0.5, r_dot=1.0)) < 0.5  # it will go beyond by itself

    def test_an_error_goes_as_fast_as_it_is_told_once_the_torque_is_there(self) -> None:
        """(theta s + 1)(s + k): the step response of two lags, without overshoot."""
        r, r_dot, h, k, theta = 0.0, 0.0, 0.0005, LOOP.error_rate, LOOP.torque_lag
        for i in range(2000):
            t = i * h
            lags = 1.0 - (math.exp(-k * t) - k * theta * math.exp(-t / theta)) / (1.0 - k * theta)
            assert r == pytest.approx(lags, abs=0.01)
            commanded = follow_yaw(LOOP, 1.0, 0.0, TURNING._replace(r=r, r_dot=r_dot))
            r_dot += h * ((commanded - r) / LOOP.lag - r_dot) / theta
            r += h * r_dot

    def test_it_stays_within_its_authority_of_what_the_vehicle_does(self) -> None:
        """Neither what it is to be turned by nor what the vehicle is told is more."""
        weak = Turning(0.4, 0.0, 0.0, 0.5, math.inf)
        for wanted in (-5.0, 5.0):
            assert follow_yaw(LOOP, wanted, 0.0, weak) == pytest.approx(0.4 + math.copysign(0.5, wanted))
        assert follow_yaw(LOOP, 5.0, 0.0, weak._replace(trim=0.1)) == pytest.approx(0.8)
        assert follow_yaw(LOOP, -5.0, 0.0, weak._replace(trim=0.1)) == pytest.approx(-0.1)

    def test_thrust_and_tilting_come_first(self) -> None:
        easy = yaw_authority(5.0, 20.0, 0.0)
        assert yaw_authority(15.0, 20.0, 0.0) < easy
        assert yaw_authority(5.0, 20.0, 2.0) < easy
        assert yaw_authority(20.0, 20.0, 9.0) == YAW_AUTHORITY_MIN

    def test_a_quick_vehicle_is_led_less(self) -> None:
        slow, quick = (yaw_loop(alike(lag, 0.05, usual_yaw_lag(lag)), lag, 0.0) for lag in (0.06, 0.02))
        assert quick.lag < slow.lag
        assert 1.0 < quick.lag * quick.error_rate < slow.lag * slow.error_rate <= 2.5
        smoothed = yaw_loop(alike(0.2, 0.05), 0.2, 0.14)
        assert smoothed.error_rate * smoothed.lag < 1.5
        assert yaw_loop(alike(0.06, 0.2), 0.06, 0.0).error_rate < slow.error_rate  # never quicker than its torque


def test_commands_that_have_acted_are_let_go() -> None:
    commands = tuple(TimedCommand(t, ZERO, 9.8) for t in (1.0, 2.0, 3.0))
    assert recent_commands(commands, 0.5) == commands
    assert [c.at for c in recent_commands(commands, 2.5)] == [2.0, 3.0]
    assert [c.at for c in recent_commands(commands, 9.0)] == [3.0]


class TestRangeAsked:
    def test_rates_that_are_there_ask_for_nothing(self) -> None:
        assert range_asked(0.5, (1.0, -2.0, 0.5), (1.0, -2.0, 0.5), USUAL_THRUST_PER_RATE) == 0.5

    def test_each_error_takes_its_part_whatever_its_sign(self) -> None:
        """PX4's P gains: 0.15 for roll and pitch, 0.2 for yaw."""
        asked = range_asked(0.6, (1.0, -1.0, -1.0), ZERO, USUAL_THRUST_PER_RATE)
        assert asked == pytest.approx(0.6 + 0.15 + 0.15 + 0.2)
        assert range_asked(0.6, ZERO, (1.0, -1.0, -1.0), USUAL_THRUST_PER_RATE) == pytest.approx(asked)
