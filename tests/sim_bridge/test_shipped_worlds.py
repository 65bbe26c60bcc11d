"""Errors of the estimate, faults of links, and the shipped worlds as a whole."""

from __future__ import annotations

import itertools
import math
import statistics
from typing import Any

import numpy as np
import pytest

from companion.config.syntax.file_lookup import names
from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.frames import Vec3, conjugate, multiply, quaternion_from_euler
from companion.mavlink.modes import Mode
from companion.world import Errors, Event, Link, Start, Way, World
from companion.world.air import Gusts
from companion.world.estimate import Drift, Noise
from companion.world.events import (
    Push,
    When,
)
from sim_bridge.link_model import LinkWay
from sim_bridge.noise import RandomStream, normals
from sim_bridge.plant import Plant
from sim_bridge.sensors import Sensors
from tests.support.plant_client import ACCEPTED, Client

STILL: Vec3 = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)


def hovering(*events: Event, vehicle: str = "x500", **world: Any) -> Client:
    return Client(vehicle, World(events=events, **world), endpoints=2)


# The estimate


def estimates(errors: Errors, seconds: float, step: float = 0.02) -> list[Any]:
    sensors = Sensors(errors, step, normals(5, RandomStream.ESTIMATE))
    plant = Plant(load_vehicle("x500"), World(), 250)
    truth = plant.truth._replace(q_nb=quaternion_from_euler(0.4, -0.2, 0.3), w_b=(0.1, 0.2, 0.3))
    return [sensors.observe(truth._replace(t_boot=i * step)) for i in range(round(seconds / step))]


def test_a_tilt_error_may_stand_still_in_the_world() -> None:
    """About north alone: the nose turns, what the error does to the thrust axis does not."""
    errors = Errors(attitude=Noise(wander=(0.02, 0.0, 0.0), wander_time=1e9), attitude_in_world=True)
    sensors = Sensors(errors, 0.02, normals(5, RandomStream.ESTIMATE))
    truth, axes = Plant(load_vehicle("x500"), World(), 250).truth, []
    for heading in (0.0, 1.0, 2.0):
        q_nb = quaternion_from_euler(heading, 0.0, 0.0)
        error = multiply(sensors.observe(truth._replace(q_nb=q_nb)).q_nb, conjugate(q_nb))
        axes.append(error[1:])
    assert np.ptp(np.array(axes), axis=0) == pytest.approx(0.0, abs=1e-4)
    assert abs(axes[0][0]) > 1e-4
    assert axes[0][1:] == pytest.approx((0.0, 0.0), abs=1e-12)


def test_an_accelerometer_shakes_and_nothing_flies_by_it() -> None:
    seen = estimates(Errors(accelerometer=Noise((0.5, 1.7, 1.4))), 40.0)
    assert np.array([each.f_b_error for each in seen]).std(axis=0) == pytest.approx((0.5, 1.7, 1.4), rel=0.05)
    assert np.ptp(np.array([each.a_n for each in seen]), axis=0) == pytest.approx(0.0)


BANDS = ((0.015, 0.05), (0.05, 0.1), (0.1, 0.2), (0.2, 0.4), (0.4, 0.8), (0.8, 1.6), (1.6, 3.2))
"""Hz."""
RECORDED = (
    (0.104, 0.085, 0.024, 0.012, 0.010, 0.0035, 0.0013),
    (0.098, 0.089, 0.056, 0.029, 0.011, 0.0045, 0.0014),
    (0.259, 0.156, 0.063, 0.021, 0.012, 0.0044, 0.0019),
)
"""m RMS in each of them: the position error of PX4's estimate on a recorded circle at 3 m/s, 58 s."""


def test_the_noisy_world_wanders_in_the_bands_that_were_recorded() -> None:
    """Within a factor of 1.6 in every band and 1.4 of every axis; one band of 58 s has a chance of its own."""
    step = 0.02
    sensors = Sensors(load_world("sih_noisy").estimate, step, normals(5, RandomStream.ESTIMATE))
    truth = Plant(load_vehicle("sih"), World(), 250).truth
    p = np.array([sensors.observe(truth).p_n for _ in range(round(1000.0 / step))]) - np.array(truth.p_n)
    window = np.hanning(len(p))[:, None]
    density = np.abs(np.fft.rfft(p * window, axis=0)) ** 2 * (2.0 / len(p) / (window**2).sum())
    hz = np.fft.rfftfreq(len(p), step)
    made = np.array([[np.sqrt(density[(hz >= a) & (hz < b), axis].sum()) for a, b in BANDS] for axis in range(3)])
    ratio = np.log(made / np.array(RECORDED))
    assert np.abs(ratio.mean(axis=0)).max() < math.log(1.6)
    assert np.abs(ratio.mean(axis=1)).max() < math.log(1.4)


def test_errors_have_the_size_that_is_told() -> None:
    errors = Errors(
        Noise((0.01, 0.01, 0.02), (0.03, 0.03, 0.05), 0.5),
        Noise((0.02, 0.02, 0.02)),
        Noise(wander=(0.01, 0.01, 0.03), wander_time=0.5),
        Noise((0.01, 0.01, 0.01)),
    )
    seen = estimates(errors, 400.0)
    p = np.array([each.p_n for each in seen])
    assert p.std(axis=0) == pytest.approx(np.hypot([0.01, 0.01, 0.02], [0.03, 0.03, 0.05]), rel=0.12)
    assert np.array([each.v_n for each in seen]).std(axis=0) == pytest.approx(0.02, rel=0.05)
    assert np.array([each.w_b for each in seen]).std(axis=0) == pytest.approx(0.01, rel=0.05)
    true = quaternion_from_euler(0.4, -0.2, 0.3)
    turns = np.array([multiply(conjugate(true), each.q_nb)[1:] for each in seen]) * 2.0
    assert turns.std(axis=0) == pytest.approx(np.array([0.01, 0.01, 0.03]), rel=0.15)
    assert all(math.isclose(math.hypot(*each.q_nb), 1.0, abs_tol=1e-12) for each in seen)


def test_an_error_begins_larger_and_settles_about_a_bias() -> None:
    """Over 300 vehicles: 2 deg at the start, after many time constants the bias of 0.8 and the wander of 0.5."""
    told = Noise((0.0,) * 3, (0.5,) * 3, 0.1, True, (2.0,) * 3, 1.0, (0.8,) * 3)
    truth = Plant(load_vehicle("x500"), World(), 250).truth
    first, last = [], []
    for seed in range(300):
        sensors = Sensors(Errors(velocity=told), 0.1, normals(seed, RandomStream.ESTIMATE))
        seen = [sensors.observe(truth).v_n for _ in range(80)]
        first.append(seen[0])
        last.append(seen[60:])
    assert np.array(first).std() == pytest.approx(math.hypot(2.0, 0.8), rel=0.1)
    assert np.array(last).mean(axis=1).std() == pytest.approx(0.8, rel=0.15)
    assert (np.array(last) - np.array(last).mean(axis=1, keepdims=True)).std() == pytest.approx(0.5, rel=0.15)


def test_a_drift_is_smooth_and_the_velocity_does_not_show_it() -> None:
    """px4_flight.md 4: velocity minus the position's derivative has a standard deviation of 1.5 to 4 cm/s."""
    seen = estimates(Errors(drift=Drift((0.025, 0.025, 0.025), 1.5)), 1500.0, 0.02)
    p = np.array([each.p_n for each in seen])
    slope = np.diff(p, axis=0) / 0.02
    assert slope.std(axis=0) == pytest.approx(0.025, rel=0.12)
    assert p.std(axis=0) == pytest.approx(0.025 * 1.5, rel=0.12)
    assert np.abs(np.diff(slope, axis=0)).max() < 0.035  # to 0.05 mm from one estimate to the next
    assert all(each.v_n == STILL for each in seen)


def test_a_smooth_wander_has_the_size_told_and_no_corners() -> None:
    """px4_flight.md 4: what PX4 publishes is smooth to 0.3 mm/s over some samples."""
    seen = estimates(Errors(velocity=Noise(wander=(0.02, 0.02, 0.01), wander_time=2.0, smooth=True)), 800.0, 0.02)
    v = np.array([each.v_n for each in seen])
    assert v.std(axis=0) == pytest.approx(np.array([0.02, 0.02, 0.01]), rel=0.25)
    assert np.abs(np.diff(v, 2, axis=0)).std() < 1e-4


def test_a_world_without_errors_shows_the_truth() -> None:
    plant = Plant(load_vehicle("x500"), World(), 250)
    estimate = Sensors(Errors(), 0.004, normals(1, RandomStream.ESTIMATE)).observe(plant.truth)
    assert (estimate.p_n, estimate.v_n, estimate.q_nb, estimate.w_b) == plant.truth[1:3] + plant.truth[4:6]


# Links


def sent_and_heard(way: Way, n: int = 4_000) -> list[tuple[float, int]]:
    """(s on the way, number) of datagrams sent every 4 ms, in the order they arrive."""
    link_way = LinkWay(way, 7, RandomStream.DOWN)
    heard = []
    for i in range(n + 500):
        if i < n:
            link_way.send(i * 4_000, 0, i.to_bytes(4))
        heard += [
            (i * 0.004 - int.from_bytes(d) * 0.004, int.from_bytes(d)) for _, d in link_way.take_arrived(i * 4_000)
        ]
    return heard


def test_a_link_delays_and_jitters_in_order() -> None:
    heard = sent_and_heard(Way(delay=0.1, jitter=0.05))
    delays = [delay for delay, _ in heard]
    assert [number for _, number in heard] == list(range(4_000))
    assert min(delays) >= 0.1 - 1e-9
    assert max(delays) < 0.156
    assert statistics.stdev(delays) > 0.003


def test_a_link_loses_doubles_and_reorders_its_share() -> None:
    assert len(sent_and_heard(Way(loss=0.2))) == pytest.approx(3_200, abs=120)
    assert len(sent_and_heard(Way(duplicated=0.1))) == pytest.approx(4_400, abs=90)
    numbers = [number for _, number in sent_and_heard(Way(reordered=0.1))]
    assert sorted(numbers) == list(range(4_000))
    late = sum(1 for before, after in itertools.pairwise(numbers) if after < before)
    assert late == pytest.approx(380, abs=80)
    assert len(sent_and_heard(Way(loss=1.0))) == 0


def test_a_bad_link_is_flown_through_in_both_ways() -> None:
    way = Way(0.02, 0.01, 0.2, 0.05, 0.05)
    client = hovering(link=Link(way, way))
    client.ground_station()
    client.run(2.0, lambda: client.rates(thrust=0.57))
    assert 130 < len(client.all("ATTITUDE", since=0.1)) / 1.9 * 2.0 < 175  # 200 less a fifth, and a few twice
    assert client.bridge.counters[0].lost > 0


# Whole worlds


@pytest.mark.parametrize("name", sorted(names("worlds")))
def test_every_world_is_hovered_in_and_is_the_same_for_its_seed(name: str) -> None:
    def flown(seed: int) -> Client:
        client = Client("x500", load_world(name), seed=seed, endpoints=1)
        client.run(4.0)
        return client

    first = flown(1)
    assert math.dist(first.bridge.truth.p_n, (0.0, 0.0, -10.0)) < (3.0 if name == "storm" else 0.7)
    again, other = flown(1), flown(2)
    assert again.bridge.truth == first.bridge.truth
    assert repr(again.heard) == repr(first.heard)  # NaN equals NaN there
    if name not in ("ideal", "sih"):
        assert other.bridge.truth != first.bridge.truth


def test_one_chance_more_leaves_the_others_as_they_were() -> None:
    errors = Errors(position=Noise((0.01, 0.01, 0.01)))
    alone = Client("x500", World(estimate=errors), seed=3, endpoints=1)
    gusty = Client("x500", World(estimate=errors, gusts=Gusts((1.0,) * 3, (10.0,) * 3)), seed=3, endpoints=1)
    assert alone.bridge.autopilot.estimate == gusty.bridge.autopilot.estimate


def test_take_off_and_landing_in_wind_end_on_the_ground_where_it_stands() -> None:
    client = Client(
        "x500", World(wind_n=(5.0, 0.0, 0.0), gusts=Gusts((0.7,) * 3, (8.0,) * 3)), landed=True, endpoints=2
    )
    client.ground_station()
    client.run(5.0)
    assert client.bridge.truth.p_n == STILL  # the wind does not carry it away
    assert client.command(22, *([math.nan] * 7)) == ACCEPTED
    assert client.command(400, 1.0) == ACCEPTED
    client.run_until(lambda: client.flown is Mode.HOLD, 20.0)
    client.run(2.0)
    assert client.height == pytest.approx(2.5, abs=0.7)
    assert client.command(21, *([math.nan] * 7)) == ACCEPTED
    client.run_until(lambda: not client.bridge.autopilot.commander.armed, 30.0)
    assert client.bridge.truth.on_ground
    assert client.bridge.truth.p_n[2] == 0.0


def test_a_held_start_does_not_let_events_pass() -> None:
    start = Start((0.0, 0.0, -10.0), held=True)
    client = Client("paper", World(events=(Push(When(0.1), (5.0, 0.0, 0.0)),)), start=start, endpoints=1)
    client.run(1.0)
    assert client.bridge.plant.push_n == STILL
