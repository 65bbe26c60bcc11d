"""Whole flights in lockstep, under every control authority: the companion's, the pilot's, rehearsed, on the bench; every ending."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.flight.bench import WRONG_FOR, Shown, fault, judge_tilt
from companion.flight.conduct import Conduct, ControlAuthority, Finish
from companion.flight.phases import Phase
from companion.frames import quaternion_from_euler
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import message
from companion.mavlink_common import (
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_TAKEOFF,
)
from companion.pilot import completed, epilogue
from companion.vehicle import Landed, Mode, OutputLevel
from companion.world import Start
from tests.support.flights import Flown, Operator, flight, once, silent

SET_MODE, HOLD, OFFBOARD = MAV_CMD_DO_SET_MODE, (1.0, 4.0, 3.0), (1.0, 6.0, 0.0)
ASKED_BY_US = {SET_MODE, MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_NAV_TAKEOFF, MAV_CMD_NAV_LAND}


def phases(flown: Flown) -> list[str]:
    return [note.split(" -> ")[1].split(":")[0] for note in flown.notes if " -> " in note]


def commands(flown: Flown) -> set[int]:
    notes = [f.format.named(f.values) for _, f in flown.between.sent if f.format.name == "COMMAND_LONG"]
    return {command["command"] for command in notes}


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_from_the_ground_and_back_to_it(level: OutputLevel) -> None:
    flown = flight(level=level, from_ground=True, duration=6.0, time_out=200.0)
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    assert phases(flown) == [
        "arm", "take off", "take over", "settle", "join", "follow", "hand back", "land", "disarm", "release", "done",
    ]  # fmt: skip
    assert flown.between.truth.on_ground
    assert not flown.between.bridge.autopilot.commander.armed
    assert flown.between.bridge.autopilot.commander.user_intended_mode is not Mode.OFFBOARD
    assert flown.between.bridge.autopilot.parameters["COM_OF_LOSS_T"] == 1.0  # set for rates, and set back


@pytest.mark.parametrize("away", [5.0, 15.0])
def test_capture_from_rest(away: float) -> None:
    """Tilt within the limit, no overshoot beyond half a metre, and it is on the path in the end."""
    tilts: list[float] = []
    heights: list[float] = []

    def watch(flown: Flown, now: float) -> None:
        tilts.append(flown.between.truth.q_nb[1] ** 2 + flown.between.truth.q_nb[2] ** 2)
        heights.append(flown.between.truth.p_n[0])

    flown = flight(
        level=OutputLevel.RATES, duration=6.0, start=Start.hover((5.0 + away, 0.0, -10.0)), meddle=watch,
    )  # fmt: skip
    assert flown.conductor.memory is not None
    assert completed(flown.conductor.memory), flown.notes
    assert 2.0 * math.asin(math.sqrt(max(tilts))) < math.radians(45.0)
    assert flown.path_errors[-1][1] < 0.02
    follows = next(i for i, (_, error) in enumerate(flown.path_errors) if error < 0.6)
    assert max(error for _, error in flown.path_errors[follows:]) < 0.6


LINE = """
mission: short-line
frame: enu
path: {{kind: line, from: [0, 0, 10], to: [6, 8, 11]}}
speed: {speed}
yaw: tangent
"""


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_an_open_path_ends_at_its_end(tmp_path: Path, speed: float) -> None:
    file = tmp_path / "line.yaml"
    file.write_text(LINE.format(speed=speed))
    flown = flight(str(file), level=OutputLevel.RATES, duration=None, time_out=60.0)
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    assert phases(flown)[-4:] == ["follow", "rest", "hand back", "done"]
    assert flown.conductor.plan is not None
    table = flown.conductor.plan.table
    end, _, _ = table.at(table.length if speed > 0.0 else 0.0)
    assert math.dist(flown.between.truth.p_n, end) < 0.6
    joined = next(i for i, (_, error) in enumerate(flown.path_errors) if error < 0.1)
    assert max(error for _, error in flown.path_errors[joined:]) < 0.2


def test_back_and_forth(tmp_path: Path) -> None:
    file = tmp_path / "line.yaml"
    file.write_text(LINE.format(speed=3.0) + "repeat: back-and-forth\nlaps: 3\n")
    flown = flight(str(file), level=OutputLevel.RATES, duration=None, time_out=90.0)
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    follows = phases(flown)
    assert follows[follows.index("follow") :] == [
        "follow", "rest", "follow", "rest", "follow", "rest", "hand back", "done",
    ]  # fmt: skip
    assert max(error for _, error in flown.path_errors) < 0.2


@pytest.mark.parametrize(("finish", "mode"), [(Finish.HOLD, Mode.HOLD), (Finish.LAND, None), (Finish.RETURN, None)])
def test_how_it_ends(finish: Finish, mode: Mode | None) -> None:
    flown = flight(duration=1.0, time_out=200.0, conduct=Conduct(finish=finish))
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    commander = flown.between.bridge.autopilot.commander
    if mode is not None:
        assert commander.mode is mode
        assert commander.armed
    else:
        assert flown.between.truth.on_ground
        assert not commander.armed
        assert finish.value in phases(flown)
    assert commander.user_intended_mode is not Mode.OFFBOARD


def test_the_pilot_begins_leaves_and_comes_back() -> None:
    """Never armed and never a mode changed by us; setpoints stream from the start, and hold his attitude until then."""

    def fly_by_hand(flown: Flown, now: float) -> None:
        for at, mode in ((1.0, OFFBOARD), (8.0, HOLD), (10.0, OFFBOARD), (16.0, HOLD)):
            if math.isclose(now, at, abs_tol=1e-6):
                Operator(flown.between.bridge).commands(SET_MODE, *mode)
        if math.isclose(now, 18.0, abs_tol=1e-6):
            flown.conductor.stop()

    flown = flight(level=OutputLevel.RATES, duration=None, conduct=Conduct(ControlAuthority.PILOT), meddle=fly_by_hand)
    assert phases(flown) == [
        "stand by", "settle", "join", "follow", "stand by", "settle", "join", "follow", "stand by", "done",
    ]  # fmt: skip
    assert not commands(flown) & ASKED_BY_US
    before = [setpoint for now, setpoint in flown.setpoints if now < 1.0]
    assert len(before) > 50
    assert all(setpoint.rates_b == (0.0, 0.0, 0.0) for setpoint in before)  # type: ignore[union-attr]
    assert max(b - a for (a, _), (b, _) in zip(flown.setpoints, flown.setpoints[1:], strict=False)) < 0.05
    assert any(error < 0.02 for now, error in flown.path_errors if 12.0 < now < 16.0)
    assert flown.between.bridge.autopilot.commander.mode is Mode.HOLD


def test_a_pilot_who_selects_offboard_after_the_states_ended_gets_no_old_setpoints() -> None:
    """They end half a second after the last state: 0.2 s until it is too old, and 0.3 s of levelling."""

    def select(flown: Flown) -> None:
        Operator(flown.between.bridge).commands(SET_MODE, *OFFBOARD)

    flown = flight(
        level=OutputLevel.ATTITUDE, conduct=Conduct(authority=ControlAuthority.PILOT), prepare=silent("ODOMETRY", since=2.0),
        meddle=once(2.3, select), time_out=20.0,
    )  # fmt: skip
    assert flown.setpoints[-1][0] < 2.0 + 0.5 + 0.01


def test_when_the_pilots_time_is_over_it_is_held_until_he_takes_it() -> None:
    takes = once(12.0, lambda flown: Operator(flown.between.bridge).commands(SET_MODE, *HOLD))

    def fly_by_hand(flown: Flown, now: float) -> None:
        if math.isclose(now, 1.0, abs_tol=1e-6):
            Operator(flown.between.bridge).commands(SET_MODE, *OFFBOARD)
        takes(flown, now)

    flown = flight(level=OutputLevel.RATES, duration=3.0, conduct=Conduct(ControlAuthority.PILOT), meddle=fly_by_hand)
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    assert phases(flown)[-2:] == ["hand back", "done"]
    assert not commands(flown) & ASKED_BY_US
    assert math.hypot(*flown.between.truth.v_n) < 0.3


def test_on_the_ground_the_pilots_offboard_does_not_take_off() -> None:
    def arm(flown: Flown, now: float) -> None:
        operator = Operator(flown.between.bridge)
        if math.isclose(now, 7.0, abs_tol=1e-6):
            operator.commands(SET_MODE, *OFFBOARD)
            operator.commands(MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        if math.isclose(now, 9.0, abs_tol=1e-6):
            flown.conductor.stop()

    flown = flight(level=OutputLevel.RATES, from_ground=True, conduct=Conduct(ControlAuthority.PILOT), meddle=arm)
    assert phases(flown) == ["stand by", "done"]
    assert flown.between.bridge.autopilot.commander.armed
    assert flown.between.truth.on_ground
    assert all(setpoint.thrust == 0.0 for _, setpoint in flown.setpoints)  # type: ignore[union-attr]


@pytest.mark.parametrize("from_ground", [True, False])
def test_a_dry_run_commands_nothing(from_ground: bool) -> None:
    flown = flight(
        level=OutputLevel.RATES, from_ground=from_ground, duration=3.0, conduct=Conduct(ControlAuthority.REHEARSAL)
    )  # fmt: skip
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    assert phases(flown) == ["rehearse", "done"]
    assert not flown.setpoints
    assert not commands(flown) & ASKED_BY_US
    assert flown.conductor.last is not None
    assert memory.steering.steered is not None  # but the law was asked


def test_the_bench_shows_that_commands_point_back() -> None:
    """The vehicle stands; a hand tilts it to every side."""
    sides = [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3)]

    def tilt(flown: Flown) -> None:
        fmt, encoder, decoder = message("ODOMETRY"), Encoder(1, 1), Decoder()

        def by_hand(data: bytes, now: float) -> list[bytes]:
            (frame,) = decoder.datagram(data)
            if frame.format is not fmt or now < 6.0:
                return [data]
            roll, pitch = sides[int(now) % 4]
            values = list(frame.values)
            values[4:8] = quaternion_from_euler(0.5, pitch, roll)
            return [encoder.encode(fmt, tuple(values))]

        flown.between.down = by_hand

    flown = flight(level=OutputLevel.RATES, from_ground=True, conduct=Conduct(ControlAuthority.BENCH), prepare=tilt)
    memory = flown.conductor.memory
    assert memory is not None
    assert completed(memory), flown.notes
    assert not flown.setpoints
    notes = [note for note in flown.notes if "turns it back" in note]
    assert len(notes) == 4
    assert memory.phase is Phase.DONE


def test_a_wrong_sign_is_found_on_the_bench() -> None:
    shown = Shown()
    for _ in range(WRONG_FOR):
        shown, notes = judge_tilt(shown, 0.3, 0.0, (2.0, 0.0, 0.0))
        assert notes is None
    assert "do not fly" in (fault(shown) or "")
    right, notes = judge_tilt(Shown(), 0.3, 0.0, (-2.0, 0.0, 0.0))
    assert notes == "roll right 17 degrees: the command turns it back"
    assert fault(right) is None


def test_a_vehicle_without_position_is_not_flown_and_it_says_why() -> None:
    def blind(flown: Flown) -> None:
        fmt, encoder = message("ESTIMATOR_STATUS"), Encoder(1, 1)

        def without(data: bytes, now: float) -> list[bytes]:
            return [encoder.message(fmt, flags=1 | 2 | 4 | 32)] if data[7] == fmt.id else [data]

        flown.between.down = without

    flown = flight(level=OutputLevel.RATES, from_ground=True, prepare=blind, time_out=90.0)
    memory = flown.conductor.memory
    assert memory is not None
    said = epilogue(memory, flown.conductor.telemetry.status.last.mode)
    assert said is not None
    assert "does not know its horizontal position" in said
    assert "nothing was flown" in said
    assert not flown.setpoints
    assert flown.conductor.telemetry.status.last.landed is Landed.ON_GROUND


def test_a_vehicle_of_another_mass_is_not_flown_and_it_says_why() -> None:
    """The vehicle file says 2 kg on rotors of 34 N; this one hovers at a third of its thrust."""

    def light(flown: Flown) -> None:
        flown.between.bridge.autopilot.parameters["MPC_THR_HOVER"] = 0.3

    flown = flight(level=OutputLevel.RATES, prepare=light)
    assert flown.conductor.refusal is not None
    assert flown.conductor.refusal.startswith("the vehicle hovers at a thrust of 0.30 (MPC_THR_HOVER) and x500 at 0.")
    assert "--vehicle" in flown.conductor.refusal
    assert not flown.setpoints
