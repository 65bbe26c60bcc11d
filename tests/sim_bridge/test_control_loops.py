"""The inner loops: PX4's step responses, mixing and what it gives up, attitude and position control by themselves."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from companion.config.vehicle import load_vehicle
from companion.frames import (
    Quaternion,
    Vec3,
    conjugate,
    from_rotation_vector,
    multiply,
    normalised,
    rotation_matrix,
    tilt,
    to_world,
)
from companion.vehicle import Rotor, Spin, Vehicle
from companion.world import Home
from sim_bridge.autopilot.parameters import of
from sim_bridge.control.attitude import (
    GAINS,
    RATE_MAX,
    SMOOTHING,
    YAW_WEIGHT,
    AttitudeReference,
    rates_for,
    smooth_attitude,
)
from sim_bridge.control.filters import ButterworthLowPass, LowPass
from sim_bridge.control.mixing import Mixer
from sim_bridge.control.position import THRUST_MIN, TILT_MAX, PositionLoop, Target
from sim_bridge.control.rates import Axis
from sim_bridge.control.reference import Reference, TrajectoryLimits, along, arrival_speed, towards
from sim_bridge.rotors import thrust_wanted, torque_per_newton
from sim_bridge.sensors import Estimate


def test_the_mixer_has_px4s_figures_for_a_quad_x() -> None:
    mixer = Mixer(load_vehicle("sih").rotors)
    mid = 0.5
    for torque, moves in (
        ((0.1, 0.0, 0.0), (-0.0707107, 0.0707107, 0.0707107, -0.0707107)),
        ((0.0, 0.1, 0.0), (0.0707107, -0.0707107, 0.0707107, -0.0707107)),
        ((0.0, 0.0, 0.1), (0.1, 0.1, -0.1, -0.1)),
    ):
        motors, lost = mixer.mix(torque, mid)
        assert motors == pytest.approx(tuple(mid + move for move in moves), abs=1e-6)
        assert lost == (0.0, 0.0, 0.0)
    assert mixer.torque_per_unit == pytest.approx((2.828427, 2.828427, 0.4))
    assert mixer.thrust_per_unit == pytest.approx(20.0)


def some_vehicle(rng: random.Random) -> Vehicle:
    """Four rotors around the centre of mass, unequal in place, strength and torque."""
    spins = (Spin.CCW, Spin.CW, Spin.CCW, Spin.CW)
    rotors = []
    for i, spin in enumerate(spins):
        angle, radius = math.pi / 2.0 * i + rng.uniform(-0.5, 0.5), rng.uniform(0.15, 0.3)
        place = (radius * math.cos(angle), radius * math.sin(angle), rng.uniform(-0.05, 0.05))
        rotors.append(
            Rotor(place, spin, rng.uniform(8.0, 12.0), rng.uniform(0.01, 0.03), (0.0, rng.choice((0.8, 1.0))))
        )
    return replace(load_vehicle("x500"), rotors=tuple(rotors))


def test_any_geometry_gives_the_torque_and_thrust_asked_for() -> None:
    """The motors the mixer finds, put back through each rotor's own torque and thrust."""
    rng = random.Random(2)
    for _ in range(100):
        rotors = some_vehicle(rng).rotors
        mixer = Mixer(rotors)
        torque = tuple(rng.uniform(-0.05, 0.05) for _ in range(3))
        motors, lost = mixer.mix(torque, 0.35)  # type: ignore[arg-type]
        assert lost == (0.0, 0.0, 0.0)
        thrusts = [motor * rotor.thrust_max for motor, rotor in zip(motors, rotors, strict=True)]
        given = sum(f * np.array(torque_per_newton(rotor)) for f, rotor in zip(thrusts, rotors, strict=True))
        assert given == pytest.approx(np.array(torque) * mixer.torque_per_unit)
        assert sum(thrusts) == pytest.approx(0.35 * mixer.thrust_per_unit)


def test_saturation_gives_up_yaw_first_and_then_thrust_but_not_roll() -> None:
    mixer = Mixer(load_vehicle("sih").rotors)
    motors, lost = mixer.mix((0.2, 0.0, 0.6), 0.5)  # all of it does not fit
    assert lost[0] == pytest.approx(0.0, abs=1e-9)
    assert lost[2] > 0.1
    assert sum(motors) / 4.0 == pytest.approx(0.5)
    motors, lost = mixer.mix((0.2, 0.0, 0.0), 0.95)  # roll at full throttle: thrust yields
    assert lost == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert sum(motors) / 4.0 == pytest.approx(1.0 - 0.2 * math.sqrt(0.5))
    motors, lost = mixer.mix((0.2, 0.0, 0.0), 0.0)  # roll with the throttle closed: thrust never grows
    assert lost[0] == pytest.approx(0.2)
    assert motors == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-9)


def test_motor_commands_stay_in_range_whatever_is_asked() -> None:
    rng = random.Random(4)
    for name in ("sih", "x500", "paper"):
        rotors = load_vehicle(name).rotors
        mixer = Mixer(rotors)
        for _ in range(500):
            torque = tuple(rng.gauss(0.0, rng.choice((0.1, 1.0, 1e6))) for _ in range(3))
            motors, _ = mixer.mix(torque, rng.uniform(-0.5, 1.7))  # type: ignore[arg-type]
            assert all(r.command[0] - 1e-9 <= m <= r.command[1] + 1e-9 for m, r in zip(motors, rotors, strict=True))


def test_rotors_that_cannot_turn_the_vehicle_are_refused() -> None:
    rotors = tuple(replace(rotor, spin=Spin.CW) for rotor in load_vehicle("sih").rotors)
    with pytest.raises(ValueError, match="cannot turn the vehicle"):
        Mixer(rotors)


def test_yaw_still_answers_at_full_thrust() -> None:
    mixer = Mixer(load_vehicle("sih").rotors)
    motors, lost = mixer.mix((0.0, 0.0, 0.1), 1.0)
    assert lost[2] < 0.03  # a little, at the cost of thrust
    assert sum(motors) / 4.0 < 0.95


def test_the_rate_integral_waits_for_saturation_and_for_wild_errors() -> None:
    def grown(error: float, lost: float, integrate: bool = True) -> float:
        axis = Axis(0.15, 0.2, 0.003, 0.004)
        for _ in range(50):
            axis.update(0.0, error, lost, integrate)
        return axis.integral

    steady = 0.2 * 0.5 * 50 * 0.004
    assert grown(0.5, 0.0) == pytest.approx(steady, rel=0.01)
    assert grown(0.5, -0.1) == pytest.approx(steady, rel=0.01)
    assert grown(0.5, 0.1) == grown(-0.5, -0.1) == grown(0.5, 0.0, integrate=False) == 0.0
    assert grown(5.0, 0.0) < 0.6 * 10.0 * steady
    assert grown(8.0, 0.0) == 0.0
    assert grown(2.0, 0.0) < 0.3


def still(a_n: Vec3 = (0.0, 0.0, 0.0)) -> Estimate:
    return Estimate(0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), a_n, (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0)


def commanded(loop: PositionLoop, target: Target, now: Estimate | None = None) -> tuple[Vec3, float]:
    """The acceleration (m/s^2) a thrust in the attitude that is asked for gives, and the thrust."""
    attitude, thrust = loop.update(now or still(), target)
    x, y, z = to_world(rotation_matrix(attitude), (0.0, 0.0, -thrust / 0.5 * 9.81))
    return (x, y, z + 9.81), thrust


STAY = Target((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.7)


def test_position_control_at_rest_and_signs() -> None:
    assert commanded(PositionLoop(0.5, 9.81, 0.008), STAY) == (pytest.approx((0.0, 0.0, 0.0), abs=1e-9), 0.5)
    for axis, gain in enumerate((0.95 * 1.8, 0.95 * 1.8, 4.0)):
        place = tuple(0.1 if i == axis else 0.0 for i in range(3))
        given, _ = commanded(PositionLoop(0.5, 9.81, 0.008), STAY._replace(position=place))
        assert given == pytest.approx(tuple(gain * p for p in place), abs=1e-6)
    braking, _ = commanded(PositionLoop(0.5, 9.81, 0.008), STAY, still(a_n=(3.0, 0.0, 0.0)))
    assert -0.2 < braking[0] < -0.05  # the derivative, through its filter
    rising, _ = commanded(PositionLoop(0.5, 9.81, 0.008), Target((None,) * 3, (None,) * 3, 0.0, (1.0, 0.0, -2.0)))
    assert rising == pytest.approx((1.0 * (1.0 + 2.0 / 9.81), 0.0, -2.0), abs=1e-6)


def test_the_thrust_vector_stays_within_tilt_and_strength() -> None:
    loop = PositionLoop(0.5, 9.81, 0.008)
    for place in ((100.0, 0.0, 0.0), (100.0, -100.0, -100.0), (0.0, 0.0, 100.0)):
        attitude, thrust = loop.update(still(), STAY._replace(position=place))
        assert tilt(rotation_matrix(attitude)) <= TILT_MAX + 1e-9
        assert THRUST_MIN <= thrust <= 1.0 + 1e-9


def test_saturation_does_not_wind_the_integrals_up() -> None:
    loop = PositionLoop(0.5, 9.81, 0.008)
    for _ in range(600):
        loop.update(still(), Target((None,) * 3, (12.0, 0.0, 0.0), 0.0))
    assert abs(commanded(loop, STAY)[0][0]) < 2.0
    loop = PositionLoop(0.5, 9.81, 0.008)
    for _ in range(600):
        loop.update(still(), Target((None,) * 3, (0.0, 0.0, -3.0), 0.0))  # climb, but it does not: thrust at its most
    assert abs(commanded(loop, STAY)[0][2]) < 6.0


def by_the_paper(q: Quaternion, wanted: Quaternion) -> Vec3:
    """PX4's controller as its source has it: reduced attitude in the world, then mixed with the full one."""
    z_now, z_wanted = (to_world(rotation_matrix(a), (0.0, 0.0, 1.0)) for a in (q, wanted))
    axis = np.cross(z_now, z_wanted)
    angle = math.atan2(float(np.linalg.norm(axis)), float(np.dot(z_now, z_wanted)))
    x, y, z = axis / np.linalg.norm(axis) * angle
    reduced = multiply(from_rotation_vector((float(x), float(y), float(z))), q)
    rest = multiply(conjugate(reduced), wanted)
    w, z = (rest[0], rest[3]) if rest[0] >= 0.0 else (-rest[0], -rest[3])
    turn = (math.cos(YAW_WEIGHT * math.acos(min(1.0, w))), 0.0, 0.0, math.sin(YAW_WEIGHT * math.asin(z)))
    error = multiply(conjugate(q), multiply(reduced, turn))
    sign = 1.0 if error[0] >= 0.0 else -1.0
    gains = (GAINS[0], GAINS[1], GAINS[2] / YAW_WEIGHT)
    rates = [2.0 * sign * e * g for e, g in zip(error[1:], gains, strict=True)]
    p, q_, r = (max(-most, min(most, rate)) for rate, most in zip(rates, RATE_MAX, strict=True))
    return (p, q_, r)


def test_attitude_control_is_the_papers() -> None:
    rng = random.Random(6)
    for _ in range(300):
        q, wanted = (normalised(tuple(rng.gauss(0.0, 1.0) for _ in range(4))) for _ in range(2))  # type: ignore[arg-type]
        assert rates_for(q, wanted) == pytest.approx(by_the_paper(q, wanted), abs=1e-8)
        back = (-q[0], -q[1], -q[2], -q[3])
        assert rates_for(back, wanted) == pytest.approx(rates_for(q, wanted))


def test_attitude_control_at_rest_and_signs() -> None:
    level = (1.0, 0.0, 0.0, 0.0)
    assert rates_for(level, level) == (0.0, 0.0, 0.0)
    for axis in range(3):
        small = tuple(0.1 if i == axis else 0.0 for i in range(3))
        rates = rates_for(level, from_rotation_vector(small))  # type: ignore[arg-type]
        assert rates == pytest.approx(tuple(GAINS[axis] * x for x in small), abs=2e-3)
    upside_down = (0.0, 1.0, 0.0, 0.0)
    assert abs(rates_for(upside_down, level)[0]) == RATE_MAX[0]
    on_its_side = from_rotation_vector((math.pi / 2, 0.0, 0.0))
    assert rates_for(on_its_side, on_its_side, heading_rate=0.5) == pytest.approx((0.0, 0.5, 0.0))


def test_a_wanted_attitude_is_smoothed_by_a_critically_damped_model() -> None:
    wanted = from_rotation_vector((0.0, 0.1, 0.0))
    model = AttitudeReference((1.0, 0.0, 0.0, 0.0))
    for step in range(1, 60):
        model = smooth_attitude(model, wanted, 0.0, 0.004)
        reached = 2.0 * math.asin(model.q_nb[2])
        t = 0.004 * step * SMOOTHING
        assert reached == pytest.approx(0.1 * (1.0 - (1.0 + t) * math.exp(-t)), abs=2e-4)
    # one long step is as many short ones
    assert smooth_attitude(AttitudeReference((1.0, 0.0, 0.0, 0.0)), wanted, 0.0, 0.236).q_nb == pytest.approx(
        model.q_nb, abs=2e-4
    )


def test_a_turning_attitude_comes_out_late_and_a_told_turn_does_not() -> None:
    late, known_rate = AttitudeReference((1.0, 0.0, 0.0, 0.0)), AttitudeReference((1.0, 0.0, 0.0, 0.0))
    for step in range(1, 126):
        wanted = from_rotation_vector((0.0, 0.0, 0.004 * step))  # 1 rad/s
        late, known_rate = smooth_attitude(late, wanted, 0.0, 0.004), smooth_attitude(known_rate, wanted, 1.0, 0.004)
    # 2 / wn, less half a step because a new attitude counts for the time before it
    assert 2.0 * math.asin(late.q_nb[3]) == pytest.approx(0.5 - (2.0 / SMOOTHING - 0.002), abs=1e-3)
    assert late.nearing[2] == pytest.approx(1.0, abs=1e-2)
    assert 2.0 * math.asin(known_rate.q_nb[3]) == pytest.approx(0.5, abs=0.004)
    assert known_rate.nearing[2] == 0.0


def test_filters_pass_what_is_slow_and_halve_power_at_the_cutoff() -> None:
    for make in (LowPass, ButterworthLowPass):
        low = make(10.0, 0.001)
        for _ in range(2000):
            steady = low.update(3.0)
        assert steady == pytest.approx(3.0)
    second = ButterworthLowPass(10.0, 0.001)
    outputs = [second.update(math.sin(2.0 * math.pi * 10.0 * i * 0.001)) for i in range(3000)]
    assert max(outputs[2000:]) == pytest.approx(math.sqrt(0.5), rel=1e-3)
    settled = ButterworthLowPass(10.0, 0.001)
    settled.settle(2.0)
    assert settled.update(2.0) == pytest.approx(2.0)
    assert ButterworthLowPass(40.0, 0.0125).update(7.0) == 7.0  # at half the sample rate: everything


def test_a_reference_arrives_at_its_place_within_its_limits() -> None:
    pace, step = TrajectoryLimits(), 0.008
    reference = Reference((0.0, 0.0, 0.0), (1.0, -2.0, 0.5))
    speeds, accelerations, jerks = [], [], []
    for _ in range(3000):
        before, reference = reference, towards(reference, (30.0, 20.0, -12.0), pace, step)
        speeds.append(math.hypot(*reference.v_n[:2]))
        accelerations.append(math.hypot(*reference.a_n[:2]))
        jerks.append(math.dist(reference.a_n[:2], before.a_n[:2]) / step)
    assert reference.p_n == pytest.approx((30.0, 20.0, -12.0), abs=0.02)
    assert reference.v_n == pytest.approx((0.0, 0.0, 0.0), abs=0.02)
    assert max(speeds) == pytest.approx(pace.cruise, rel=0.05)
    assert max(accelerations) <= pace.acceleration * 1.001
    assert max(jerks) <= pace.jerk * 1.001


def test_a_reference_told_to_stop_stops() -> None:
    reference = Reference((0.0, 0.0, -5.0), (8.0, 0.0, -2.0))
    for _ in range(1000):
        reference = along(reference, (0.0, 0.0, 0.0), TrajectoryLimits(), 0.008)
    assert reference.v_n == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert 8.0**2 / 2 / 3.0 < reference.p_n[0] < 8.0**2 / 2 / 3.0 + 8.0


def test_arrival_speed_grows_with_the_distance() -> None:
    speeds = [arrival_speed(distance, 5.0, TrajectoryLimits()) for distance in (0.0, 0.1, 1.0, 5.0, 50.0)]
    assert speeds[0] == 0.0
    assert speeds == sorted(speeds)
    assert speeds[-1] == 5.0


def test_rate_gains_of_a_vehicle_are_px4s_for_its_own_torque_and_are_told() -> None:
    """MC_*RATE_P times the angular acceleration of a torque of 1 is alike on every vehicle; a tuner's factor on top."""
    for name in ("sih", "x500"):
        vehicle = load_vehicle(name)
        mixer = Mixer(vehicle.rotors)
        told, tuned = of(vehicle, Home()), of(vehicle, Home(), rate_gains=(1.5, 1.0, 0.7))
        for axis, (which, usual, factor) in enumerate((("ROLL", 0.15, 1.5), ("PITCH", 0.15, 1.0), ("YAW", 0.2, 0.7))):
            p = told[f"MC_{which}RATE_P"]
            stiffness = p * mixer.torque_per_unit[axis] / vehicle.inertia[axis]
            assert stiffness == pytest.approx(usual * (113.137, 113.137, 13.3333)[axis], rel=1e-4)
            assert tuned[f"MC_{which}RATE_P"] == pytest.approx(factor * p, rel=1e-4)
            if name == "sih":
                assert p == pytest.approx(usual, rel=1e-6)


def test_a_thrust_curve_bends_between_nothing_and_everything() -> None:
    rotors = load_vehicle("sih").rotors
    straight, curved = thrust_wanted(rotors), thrust_wanted(rotors, 0.3)
    for command in (0.0, 1.0, 2.0, math.nan):
        assert curved((command,) * 4) == pytest.approx(straight((command,) * 4))
    assert curved((0.5,) * 4)[0] == pytest.approx(5.0 * (0.3 * 0.25 + 0.7 * 0.5))
