"""Whole flights on a stock PX4's XRCE client, the stand-in's, beside rates over MAVLink."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import pytest

from companion.frames import rotation_matrix
from companion.library.lockstep import fly
from companion.pilot import completed
from companion.vehicle import Mode, OutputLevel
from tests.support.flights import Between, Flown, flight, name_of
from trials.deaths import placed, selecting
from trials.xrce_circle import path_error

SETTLED = 8.0
"""s from the first setpoint until the vehicle follows."""


@cache
def at_rates(world: str, speed: float) -> float:
    return path_error(OutputLevel.RATES, world, speed)


@pytest.mark.parametrize(
    ("level", "world", "speed"),
    [(OutputLevel.MOTORS, "sih", 7.0), (OutputLevel.MOTORS, "sih_noisy", 3.0), (OutputLevel.TORQUES, "sih_noisy", 7.0)],
)
def test_the_circle_is_followed_as_closely_as_by_rates(level: OutputLevel, world: str, speed: float) -> None:
    error, by_rates = path_error(level, world, speed), at_rates(world, speed)
    print(f"{world}, {speed:g} m/s: {level.value} {100 * error:.1f} cm, rates over MAVLink {100 * by_rates:.1f} cm")
    assert error < 1.3 * by_rates


def test_a_flight_that_begins_in_a_given_state_begins_so_over_xrce_too() -> None:
    """The vehicle and its clock are held until the first command, though the client has to connect before."""
    over_xrce, over_mavlink = (
        flight("paper_case1", "x500", OutputLevel.MOTORS, 1.0, xrce=xrce) for xrce in (True, False)
    )
    assert over_xrce.reason is None, over_xrce.notes
    assert over_xrce.setpoints[0][0] > 5.0  # UXRCE_DDS_SYNCT
    worst, as_worst = (max(error for _, error in each.path_errors) for each in (over_xrce, over_mavlink))
    assert worst == pytest.approx(as_worst, rel=0.05)


def test_a_status_that_is_lost_once_does_not_end_the_flight() -> None:
    """PX4 says its mode twice a second; over XRCE it says at once where OFFBOARD is left."""
    lost: list[float] = []

    def lossy(flown: Flown) -> None:
        def down(data: bytes, now: float) -> list[bytes]:
            if name_of(data) == "CURRENT_MODE" and now > 8.0 and not lost:
                lost.append(now)
                return []
            return [data]

        flown.between.down = down

    flown = flight("circle_r5", "sih", OutputLevel.MOTORS, 4.0, xrce=True, prepare=lossy)
    assert lost
    assert flown.reason is None, flown.notes


def test_a_flight_in_a_mode_of_our_own_is_selected_flown_and_over() -> None:
    bridge, conductor = placed(OutputLevel.ATTITUDE, own_mode=True, duration=2.0)
    fly(conductor, bridge, lambda conductor, truth: selecting(bridge, conductor), 40.0)
    assert conductor.memory is not None and completed(conductor.memory), conductor.notes
    assert conductor.xrce is not None and conductor.xrce.sent > 200
    for _ in range(10):
        bridge.step()
    assert bridge.autopilot.commander.external_modes.of(Mode.EXTERNAL1) is None
    assert bridge.autopilot.commander.mode is Mode.HOLD


def test_what_px4_would_fly_on_for_too_long_is_refused_in_it() -> None:
    bridge, conductor = placed(OutputLevel.RATES, own_mode=True, duration=2.0)
    fly(conductor, bridge, lambda conductor, truth: None, 5.0)
    assert "flies attitude alone, not rates" in (conductor.refusal or "")


def test_the_ground_station_is_told_why_the_mission_cannot_be_flown_and_the_mode_goes() -> None:
    bridge, conductor = placed(OutputLevel.ATTITUDE, own_mode=True, duration=2.0)
    conductor.orders = replace(conductor.orders, objection=lambda mission, ground: "the path is under the ground")
    between = Between(bridge)
    fly(conductor, between, lambda conductor, truth: None, 20.0)  # type: ignore[arg-type]
    assert "the path is under the ground" in (conductor.refusal or "")
    assert conductor.xrce is not None and conductor.xrce.flight_mode is not None
    assert conductor.xrce.flight_mode.mode is Mode.EXTERNAL1
    pieces = [frame.format.named(frame.values) for _, frame in between.sent if frame.format.name == "STATUSTEXT"]
    text = "".join(piece["text"] for piece in pieces)
    assert text.endswith("mission cannot be flown here: in its place here, the path is under the ground"), text
    for _ in range(10):
        bridge.step()
    assert bridge.autopilot.commander.external_modes.of(Mode.EXTERNAL1) is None


def test_a_companion_that_dies_on_the_circle_leaves_a_vehicle_that_px4_holds() -> None:
    """Motors, COM_OF_LOSS_T 0.1 as it is set for the flight. PX4 looks every 0.1 s; killed 0.04 s after a look."""
    tilts: list[tuple[float, float, float]] = []

    def meddle(flown: Flown, now: float) -> None:
        between = flown.between
        if not flown.setpoints or now - flown.setpoints[0][0] < SETTLED:
            return
        if not between.dead and abs(between.truth.t_boot % 0.1 - 0.04) > 0.001:
            return
        upright = rotation_matrix(between.truth.q_nb)[8]
        held = between.bridge.autopilot.commander.mode is Mode.HOLD
        tilts.append((now, math.degrees(math.acos(upright)), float(held)))
        between.dead = True

    flown = flight("circle_r5", "sih", OutputLevel.MOTORS, 60.0, xrce=True, time_out=45.0, meddle=meddle)
    assert flown.between.dead, flown.notes
    killed_at, tilt, _ = tilts[0]
    took = next(now for now, _, held in tilts if held) - killed_at
    assert 0.17 < took < 0.2
    assert max(each for _, each, _ in tilts) < tilt + 15.0
