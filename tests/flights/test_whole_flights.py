"""Whole flights in lockstep: as they should go, and with a human, a fault or a fool in between."""

from __future__ import annotations

import itertools
import math
import random
from pathlib import Path

import pytest

from companion.cli.finish import NO_VEHICLE, Ended, Ending, finish
from companion.daemon.asked_of_vehicle import COMMANDS
from companion.flight.phases import Phase, Request
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.pilot import LEVEL_FOR, completed
from companion.record.folder import Recorder, Source
from companion.vehicle import Landed, Mode, MotorSetpoint, OutputLevel
from tests.support.flights import Flown, Operator, flight, once

HOLD = (176, 1.0, 4.0, 3.0)
RETURN = (176, 1.0, 4.0, 5.0)


def hover_command(flown: Flown) -> float:
    vehicle = flown.conductor.orders.vehicle
    return vehicle.weight / vehicle.thrust_max


def test_a_flight_from_a_hover() -> None:
    flown = flight()
    assert flown.conductor.memory is not None
    assert completed(flown.conductor.memory)
    assert "the path runs 10.0 m above home" in flown.notes
    assert [note.split(":")[0] for note in flown.notes if " -> " in note] == [
        "preflight -> take over",
        "take over -> settle",
        "settle -> join",
        "join -> follow",
        "follow -> hand back",
        "hand back -> done",
    ]
    assert flown.between.bridge.autopilot.commander.mode is Mode.HOLD
    assert max(error for now, error in flown.path_errors if now > 5.0) < 0.002


def test_a_flight_from_the_ground_lands_where_it_began() -> None:
    flown = flight(from_ground=True, duration=6.0, time_out=200.0)
    assert flown.conductor.memory is not None
    assert completed(flown.conductor.memory), flown.notes
    phases = [note.split(" -> ")[1].split(":")[0] for note in flown.notes if " -> " in note]
    assert phases == [
        "arm",
        "take off",
        "take over",
        "settle",
        "join",
        "follow",
        "hand back",
        "land",
        "disarm",
        "release",
        "done",
    ]
    assert flown.between.truth.on_ground
    assert flown.conductor.telemetry.status.last.landed is Landed.ON_GROUND
    assert flown.conductor.telemetry.status.last.armed is False


def test_every_setpoint_is_clamped_finite_and_new() -> None:
    flown = flight()
    stamps = []
    for _, frame in flown.between.sent:
        if frame.format.name == "SET_ACTUATOR_CONTROL_TARGET":
            values = frame.format.named(frame.values)
            assert all(0.0 <= c <= 1.0 for c in values["controls"][:4])
            stamps.append(values["time_usec"])
    assert len(stamps) > 2000
    assert len(set(stamps)) == len(stamps)  # never the same state twice, so never an old setpoint


def test_nothing_is_sent_before_a_vehicle_is_heard_but_heartbeats() -> None:
    flown = flight(duration=0.5)
    first_state = next(now for now, frame in flown.between.sent if frame.format.name == "COMMAND_LONG")
    before = {frame.format.name for now, frame in flown.between.sent if now < first_state}
    assert before <= {"HEARTBEAT"}


@pytest.mark.parametrize("mode", [HOLD, RETURN])
def test_an_operator_who_changes_the_mode_ends_the_flight(mode: tuple[float, ...]) -> None:
    def take_over(flown: Flown) -> None:
        Operator(flown.between.bridge).commands(int(mode[0]), *mode[1:])

    flown = flight(meddle=once(3.0, take_over))
    assert flown.reason is not None
    assert "operator took over" in flown.reason
    # telemetry shows a mode change within 50 ms; nothing is sent after that, and no mode is asked for
    assert flown.setpoints[-1][0] < 3.1
    asked = [f.format.named(f.values) for now, f in flown.between.sent if now > 3.0 and f.format.name == "COMMAND_LONG"]
    assert all(command["command"] != 176 for command in asked)


def test_stop_hands_the_vehicle_back() -> None:
    flown = flight(duration=None, meddle=once(3.0, lambda f: f.conductor.stop()))
    assert flown.reason == "stopped by the user"
    assert flown.between.bridge.autopilot.commander.mode is Mode.HOLD
    # the law flies until HOLD is confirmed: no gap
    times = [now for now, frame in flown.between.sent if frame.format.name == "SET_ACTUATOR_CONTROL_TARGET"]
    assert max(b - a for a, b in itertools.pairwise(times)) < 0.0041


def test_a_stop_before_the_flight_begins() -> None:
    flown = flight(from_ground=True, meddle=once(0.5, lambda f: f.conductor.stop()))
    assert flown.conductor.done
    assert not flown.setpoints
    assert flown.between.truth.on_ground


def test_silence_levels_asks_for_hold_and_then_falls_silent() -> None:
    """The vehicle's voice is cut; ours still reaches it."""

    def cut(flown: Flown) -> None:
        flown.between.down = lambda data, now: []

    flown = flight(meddle=once(3.0, cut), time_out=30.0)
    assert flown.reason is not None
    assert "no state from the vehicle" in flown.reason
    late = [(now, setpoint) for now, setpoint in flown.setpoints if now > 3.05]
    assert 3.2 <= late[0][0] < 3.3
    assert late[-1][0] - late[0][0] <= LEVEL_FOR + 0.01
    assert len(late) >= 10
    hover = hover_command(flown)
    for _, setpoint in late:
        assert isinstance(setpoint, MotorSetpoint)
        assert setpoint.commands == pytest.approx((hover,) * 4, rel=1e-4)  # by the thrust scale as estimated
    # HOLD was asked for, and the vehicle does it
    assert flown.between.bridge.autopilot.commander.mode is Mode.HOLD


def test_both_ways_cut_leaves_it_to_the_autopilots_failsafe() -> None:
    def cut(flown: Flown) -> None:
        flown.between.down = lambda data, now: []
        flown.between.up = lambda data, now: []

    flown = flight(meddle=once(3.0, cut), time_out=30.0)
    assert flown.conductor.done
    commander = flown.between.bridge.autopilot.commander
    assert commander.mode is not Mode.OFFBOARD
    assert commander.failsafe is not None


def test_a_short_gap_is_flown_through() -> None:
    def meddle(flown: Flown, now: float) -> None:
        gap = 3.0 <= now < 3.12
        flown.between.down = (lambda data, now: []) if gap else (lambda data, now: [data])

    flown = flight(meddle=meddle)
    assert flown.reason is None
    assert max(error for now, error in flown.path_errors if now > 3.0) < 0.3


def test_disarming_in_the_air_ends_the_flight() -> None:
    flown = flight(meddle=once(3.0, lambda f: Operator(f.between.bridge).commands(400, 0.0, 21196.0)))
    assert flown.reason == "the vehicle was disarmed"


def test_garbage_on_the_port_is_counted_and_harmless() -> None:
    rng = random.Random(1)

    def spoil(data: bytes, now: float) -> list[bytes]:
        return [bytes(rng.randrange(256) for _ in range(rng.randrange(60))), data, data[: rng.randrange(len(data))]]

    def meddle(flown: Flown, now: float) -> None:
        flown.between.down = spoil

    flown = flight(duration=3.0, meddle=meddle)
    assert flown.reason is None
    assert flown.conductor.decoder.counters.garbage_bytes > 10_000


def test_states_out_of_order_and_twice_do_no_harm() -> None:
    rng = random.Random(2)
    kept: list[bytes] = []

    def shuffle(data: bytes, now: float) -> list[bytes]:
        kept.append(data)
        if len(kept) < 6:
            return []
        rng.shuffle(kept)
        out = [kept.pop(), kept[-1]]
        return out

    def meddle(flown: Flown, now: float) -> None:
        if now > 3.0:
            flown.between.down = shuffle

    flown = flight(duration=6.0, meddle=meddle)
    assert flown.reason is None, flown.notes
    assert max(error for _, error in flown.path_errors) < 0.3
    stamps = [f.format.named(f.values)["time_usec"] for _, f in flown.between.sent if f.format.id == 139]
    assert stamps == sorted(stamps)


def test_a_state_that_is_not_finite_is_no_state() -> None:
    def poison(flown: Flown) -> None:
        fmt = message("ODOMETRY")
        bad = Encoder(1, 1).message(fmt, frame_id=1, child_frame_id=1, q=(1, 0, 0, 0), x=math.nan)
        flown.between.down = lambda data, now: [bad]

    flown = flight(meddle=once(3.0, poison), time_out=30.0)
    assert flown.reason is not None
    assert "no state" in flown.reason
    assert flown.conductor.telemetry.refused


def test_motor_commands_are_not_sent_to_a_vehicle_that_does_not_take_them() -> None:
    def honest(flown: Flown) -> None:
        def say(data: bytes, now: float) -> list[bytes]:
            if len(data) > 9 and data[7] == 148:  # AUTOPILOT_VERSION: take the capability out
                return [Encoder(1, 1).message(message("AUTOPILOT_VERSION"), capabilities=59647)]
            return [data]

        flown.between.down = say

    flown = flight(prepare=honest)
    assert flown.conductor.refusal is not None
    assert "does not take motor commands" in flown.conductor.refusal
    assert "--output rates" in flown.conductor.refusal
    assert not flown.setpoints


def test_another_autopilot_is_left_alone(tmp_path: Path) -> None:
    def ardupilot(flown: Flown) -> None:
        beat = Encoder(1, 1).message(message("HEARTBEAT"), autopilot=3, type=2, system_status=4)
        flown.between.down = lambda data, now: [beat]

    flown = flight(prepare=ardupilot)
    assert flown.conductor.refusal is not None
    assert "not PX4" in flown.conductor.refusal
    recorder = Recorder(tmp_path / "record", Source("m", ""), Source("v", ""), epoch=0.0)
    assert finish(flown.conductor, recorder, Ending(json=False, settle=0.0), Ended(0.0, stopped=False)) == NO_VEHICLE
    assert {frame.format.name for _, frame in flown.between.sent} <= {"HEARTBEAT", "COMMAND_LONG", "TIMESYNC"}


def test_every_request_has_its_command() -> None:
    assert set(COMMANDS) == set(Request)


def test_the_same_flight_twice_is_the_same_bytes() -> None:
    first, second = (flight(duration=2.0) for _ in range(2))
    assert [f.raw for _, f in first.between.sent] == [f.raw for _, f in second.between.sent]


def test_level_and_phase_at_the_end() -> None:
    flown = flight(duration=1.0)
    assert flown.conductor.memory is not None
    assert flown.conductor.memory.phase is Phase.DONE
    assert flown.conductor.orders.level is OutputLevel.MOTORS
