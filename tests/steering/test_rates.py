"""Rates and attitude: signs, encodings, limits, and whole flights on the stand-in."""

from __future__ import annotations

import dataclasses
import math
import random
from pathlib import Path
from typing import Any

import pytest

from companion.daemon import preparing
from companion.daemon.conductor import Conductor
from companion.flight.conduct import Conduct, Finish
from companion.flight.phases import Phase
from companion.frames import Vec3, multiply, quaternion_from_euler, rotation_matrix, tilt
from companion.plan import Plan
from companion.steering.encoding import AsAttitude, as_attitude
from companion.study.flying import cases_of, row_of
from companion.study.reading import load_study
from companion.thrust_range import Bound, ThrustRange
from companion.vehicle import OutputLevel, RateSetpoint, Tuning
from companion.world import Battery, Deviations, Link, Start, Way
from companion.world.events import Hold, When
from sim_bridge.bridge import Bridge
from sim_bridge.control.attitude import GAINS, rates_for
from sim_bridge.plant import Truth
from tests.support.flights import Flown, flight
from trials.measured import course, machine, measure_flight, world
from trials.rivals.sorties import PLACES

ROBUSTNESS = cases_of(load_study(Path(__file__).parents[2] / "configs/studies/robustness.yaml"))


def test_an_attitude_is_what_px4_turns_back_into_the_rates() -> None:
    """Against the stand-in's own derivation of PX4's controller."""
    rng = random.Random(2)
    encoding = as_attitude(Tuning(roll_p=GAINS[0], pitch_p=GAINS[1], yaw_p=GAINS[2]))
    for _ in range(200):
        q_nb = quaternion_from_euler(rng.uniform(-3, 3), rng.uniform(-1, 1), rng.uniform(-1, 1))
        rates = (rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-1.5, 1.5))
        asked = encoding.setpoint(rates, 0.5, q_nb)
        assert rates_for(q_nb, asked.q_nb) == pytest.approx(rates, abs=1e-9)


def test_in_a_fast_turn_px4_flies_the_rates_that_were_meant() -> None:
    """Its loop smooths the attitude it is sent: what it then asks of its rate loop is what steering meant of it, a
    moment ago, neither more nor less."""
    bridges: list[Bridge] = []
    meant: list[Vec3] = []
    asked: list[tuple[float | None, ...]] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        memory = conductor.memory
        steering = None if memory is None else memory.steering.memory
        if steering is not None and truth.t_boot > 10.0:
            (p, q, r), (g, k) = steering.commands[-1].rates_b, steering.estimate.identification.gains
            meant.append((p / g, q / k, r))
            asked.append(bridges[0].autopilot.cascade.rates_wanted)

    done = measure_flight(
        course("circle_r5", 6.0, OutputLevel.ATTITUDE), machine("sih"), world("ideal"), OutputLevel.ATTITUDE,
        duration=12.0, settle=8.0, prepare=lambda _, bridge: bridges.append(bridge), watch=watch,
    )  # fmt: skip
    assert done.reason is None
    assert done.true is not None
    assert done.true.speed < 0.03 * 6.0
    late = 10  # steps of 4 ms, 2 / MC_REF_W_N
    for axis in range(3):
        pairs = [(a[axis], b[axis]) for a, b in zip(meant, asked[late:], strict=False)]
        gain = sum(a * b for a, b in pairs if b is not None) / sum(a * a for a, _ in pairs)
        assert gain == pytest.approx(1.0, abs=0.04)


def test_absurd_rates_stay_an_attitude() -> None:
    asked = AsAttitude().setpoint((50.0, -80.0, 40.0), 0.5, (1.0, 0.0, 0.0, 0.0))
    assert math.hypot(*asked.q_nb) == pytest.approx(1.0)


def test_level_keeps_the_heading() -> None:
    leaning = multiply(quaternion_from_euler(1.0, 0.0, 0.0), quaternion_from_euler(0.0, 0.3, 0.0))
    assert AsAttitude().level_setpoint((0.0, 0.0, 0.0), 0.5, leaning).q_nb == pytest.approx(
        quaternion_from_euler(1.0, 0.0, 0.0), abs=1e-9
    )


def test_thrust_stops_at_its_bounds_and_does_not_wind_up() -> None:
    limits = ThrustRange(5.0, 20.0, 60.0)
    assert limits.integrated(10.0, 30.0, 0.01, 20.0) == (pytest.approx(10.3), 30.0, Bound.NONE)
    assert limits.integrated(10.0, 90.0, 0.01, 20.0) == (pytest.approx(10.6), 60.0, Bound.SLEW)
    assert limits.integrated(19.9, 30.0, 0.01, 20.0) == (20.0, 0.0, Bound.LEVEL)
    assert limits.integrated(14.9, 30.0, 0.01, 15.0) == (15.0, 0.0, Bound.LEVEL)
    assert limits.integrated(5.1, -30.0, 0.01, 20.0) == (5.0, 0.0, Bound.LEVEL)


def settled(flown: Flown, after: float) -> float:
    """m, RMS of the path error of the estimated position."""
    errors = [error for t, error in flown.path_errors if t > after]
    assert errors
    return math.sqrt(sum(error * error for error in errors) / len(errors))


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_a_circle_on_the_stand_in(level: OutputLevel) -> None:
    flown = flight("circle_r5", "sih", level, duration=16.0, time_out=25.0)
    assert flown.reason is None
    assert settled(flown, 8.0) < (0.01 if level is OutputLevel.RATES else 0.03)
    for _, setpoint in flown.setpoints:
        if isinstance(setpoint, RateSetpoint):
            assert max(map(abs, setpoint.rates_b)) <= 4.0
        assert 0.0 < setpoint.thrust < 1.0  # type: ignore[union-attr]


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_a_vehicle_said_to_have_no_lag_is_flown(level: OutputLevel) -> None:
    none = machine("sih", rate_loop_lag=0.0)
    done = measure_flight(course("circle_r5", 2.0, level), none, world("ideal"), level, duration=10.0, settle=6.0)
    assert done.reason is None
    assert done.true is not None
    assert done.true.path < 0.05


@pytest.mark.parametrize(("speed", "off"), [(3.0, 0.10), (6.0, 0.35)])
def test_held_on_the_path_it_waits_and_carries_on(speed: float, off: float) -> None:
    """Held for four seconds: no leap on release, neither off the path nor ahead."""
    held = world("ideal", link=Link(Way(0.01), Way(0.01)), events=(Hold(When(8.0, 12.0)),))
    most = [0.0, 0.0]

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        if conductor.plan is not None and truth.t_boot > 12.0:
            _, distance = conductor.plan.table.locate(truth.p_n)
            most[0], most[1] = max(most[0], distance), max(most[1], math.hypot(*truth.v_n))

    done = measure_flight(course("circle_r5", speed), machine("x500"), held, duration=15.0, settle=14.0, watch=watch)
    assert done.reason is None
    assert most[0] < off
    assert 0.8 * speed < most[1] < 1.3 * speed


def test_at_the_end_of_the_thrust_the_path_comes_first_then_the_speed_then_the_heading() -> None:
    """A figure-eight that asks for 16.2 m/s^2 of the 15.5 there are, and for 1 N m of yaw torque of at most 0.27."""
    believed = machine("x500", drag=0.0, state_rate=100.0, dead_time=0.02)
    assert believed.limits is not None
    believed = dataclasses.replace(believed, limits=dataclasses.replace(believed.limits, tilt=math.radians(65.0)))
    heavy = world("ideal", link=Link(Way(0.01), Way(0.01)), truth=Deviations(mass=1.1 * believed.mass, drag=0.2))
    done = measure_flight(course("figure8", 4.0), believed, heavy, duration=25.0, settle=10.0)
    assert done.reason is None
    assert done.true is not None
    assert done.true.path < 0.025
    assert done.true.speed < 0.03 * 4.0
    assert done.true.yaw < math.radians(16.0)


@pytest.mark.parametrize("index", range(0, 60, 6))
def test_outdoors_with_a_machine_that_is_not_as_its_file_says(index: int) -> None:
    """Every sixth of the first sixty flights of the shipped study ``robustness``: all its paths, twice."""
    row = row_of(ROBUSTNESS[index])
    assert row["passed"], f"{row['outcome']}: {row['reason'] or row['unmet']}"


@pytest.mark.parametrize("speed", [3.0, 5.0, 7.0])
def test_the_drag_is_known_after_one_lap(speed: float) -> None:
    """PX4's simulated vehicle, nothing known but a hover thrust: its drag of 1 1/s within 5 %."""
    believed, there = PLACES["SIH"]()
    assert believed.drag == 0.0
    assert there.truth.drag == 1.0
    found: list[float] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        memory, last = conductor.memory, conductor.last
        if found or memory is None or memory.path.progress is None or last is None or last.outcome.steered is None:
            return
        if memory.path.progress.travelled >= conductor.plan.table.length:
            found.append(last.outcome.steered.estimates.drag)

    # up to the speed it takes half the ramp's length longer
    seconds = 10.0 * math.pi / speed + speed
    done = measure_flight(
        course("circle_r5", speed), believed, there, duration=seconds, settle=seconds - 1.0, watch=watch
    )
    assert done.reason is None
    assert found[0] == pytest.approx(1.0, abs=0.05)


def tell_hover_thrust(monkeypatch: pytest.MonkeyPatch, factor: float) -> None:
    """The companion is told ``factor`` times the hover thrust that the vehicle says."""
    usual = preparing.prepared

    def wrong(*given: Any) -> Plan:
        tuning: Tuning = given[5]
        assert tuning.hover_thrust is not None
        return usual(*given[:5], tuning._replace(hover_thrust=tuning.hover_thrust * factor), *given[6:])

    monkeypatch.setattr(preparing, "prepared", wrong)


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_a_wrong_hover_thrust_is_found_before_the_path_is_flown(factor: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Told 30 % too little or 40 % too much: half a metre of height is never lost, and it takes less than 10 s."""
    tell_hover_thrust(monkeypatch, factor)
    heights: list[float] = []
    converged_at: list[float] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        if conductor.memory is None or conductor.memory.steering.memory is None:
            return
        heights.append(truth.p_n[2])
        if conductor.memory.steering.memory.estimate.motion.estimator.converged and not converged_at:
            converged_at.append(now)

    done = measure_flight(
        course("circle_r5", 3.0), machine("x500"), world("ideal"), duration=5.0, settle=3.0, watch=watch
    )
    assert done.reason is None
    assert max(abs(height + 10.0) for height in heights) < 0.5
    assert converged_at[0] < 3.0
    assert done.estimates is not None
    assert done.estimates.thrust_scale == pytest.approx(factor, rel=0.06)


@pytest.mark.parametrize("factor", [0.7, 1.4])
@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_a_wrong_hover_thrust_from_the_ground(
    factor: float, level: OutputLevel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same after a take-off: neither the place where it settles nor the path is left by half a metre of height."""
    tell_hover_thrust(monkeypatch, factor)
    heights: dict[Phase, list[float]] = {}
    known_at: list[float] = []

    def watch(flown: Flown, now: float) -> None:
        memory = flown.conductor.memory
        if memory is None or memory.phase not in (Phase.SETTLE, Phase.FOLLOW):
            return
        heights.setdefault(memory.phase, []).append(-flown.between.truth.p_n[2])
        if memory.phase is Phase.SETTLE:
            known_at.append(now - memory.entered)

    flown = flight(
        level=level, from_ground=True, duration=5.0, time_out=60.0, meddle=watch, conduct=Conduct(finish=Finish.HOLD)
    )
    assert flown.reason is None
    settled_at = heights[Phase.SETTLE]
    assert max(abs(height - settled_at[0]) for height in settled_at) < 0.5
    assert max(abs(height - 10.0) for height in heights[Phase.FOLLOW]) < 0.5
    assert known_at[-1] < 10.0


def test_thrust_that_drifts_in_flight_is_followed() -> None:
    """A fading battery: 15 % less thrust for the same command within 12 s, the height kept."""
    fading = world("ideal", battery=Battery(capacity=500.0, resistance=0.01, full_current=60.0))
    lowest: list[float] = []
    commands: list[float] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        lowest.append(truth.p_n[2])
        if conductor.last is not None and conductor.last.outcome.setpoint is not None:
            commands.append(conductor.last.outcome.setpoint.thrust)

    done = measure_flight(course("circle_r5", 3.0), machine("x500"), fading, duration=12.0, settle=5.0, watch=watch)
    assert done.reason is None
    assert max(abs(height + 10.0) for height in lowest) < 0.3
    assert commands[-1] > commands[len(commands) // 12] / 0.85  # the same lift takes that much more
    assert done.true is not None
    assert done.true.path < 0.05


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
@pytest.mark.parametrize("away", [(5.0, 0.0), (15.0, 0.0), (0.0, 5.0), (10.0, 11.2)])
def test_captured_from_beside_and_above(away: tuple[float, float], level: OutputLevel) -> None:
    """From rest, so far out and so far up (m): within the tilt limit, and once there it stays within half a metre."""
    tilts: list[float] = []
    off: list[float] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        x, y, z = truth.p_n
        tilts.append(tilt(rotation_matrix(truth.q_nb)))
        off.append(math.hypot(math.hypot(x, y) - 5.0, z + 10.0))

    start = Start.hover((0.0, 5.0 + away[0], -10.0 - away[1]))
    done = measure_flight(
        course("circle_r5", 3.0), machine("x500"), world("ideal"), level, duration=4.0, settle=2.0, start=start,
        watch=watch,
    )  # fmt: skip
    assert done.reason is None
    assert off[0] == pytest.approx(math.hypot(*away), abs=0.01)
    there = next(i for i, distance in enumerate(off) if distance < 0.1)
    assert max(off[there:]) < 0.5
    assert off[-1] < 0.1
    assert max(tilts) < math.radians(45.0)


@pytest.mark.parametrize("off", [5.0, 15.0])
def test_captured_from_far_without_overshoot(off: float) -> None:
    """From rest beside the path: within the tilt limit, and never more than half a metre on its other side."""
    most = [0.0, 0.0]

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        x, y, _ = truth.p_n
        most[0] = max(most[0], 5.0 - math.hypot(x, y))
        most[1] = max(most[1], tilt(rotation_matrix(truth.q_nb)))

    start = Start.hover((0.0, 5.0 + off, -10.0))
    done = measure_flight(
        course("circle_r5", 3.0), machine("x500"), world("ideal"), duration=4.0, settle=2.0, start=start, watch=watch
    )
    assert done.reason is None
    assert most[0] < 0.5
    assert most[1] < math.radians(45.0)
