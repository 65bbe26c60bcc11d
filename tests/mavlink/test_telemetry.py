"""A second of a real PX4's session through the codec and telemetry, and the traps of its wire."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from pathlib import Path

import pytest

from companion.frames import quaternion_from_euler
from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import Value, message
from companion.mavlink.telemetry import Telemetry
from companion.record.tlog import records
from companion.vehicle import Landed, Mode, VehicleState

SESSION = (Path(__file__).parents[1] / "data" / "px4_session_excerpt.tlog").read_bytes()
ODOMETRY, HEARTBEAT = message("ODOMETRY"), message("HEARTBEAT")


def frames(data: bytes) -> list[Frame]:
    decoder = Decoder()
    return [frame for _, raw in records(data) for frame in decoder.datagram(raw)]


def odometry(**changes: Value) -> Frame:
    usual = {
        "time_usec": 5_000_000, "frame_id": 1, "child_frame_id": 1, "x": 1.0, "y": 2.0, "z": -3.0,
        "q": quaternion_from_euler(math.pi / 2, 0.0, 0.0), "vx": 4.0, "reset_counter": 7,
    }  # fmt: skip
    (frame,) = Decoder().datagram(Encoder(1, 1).message(ODOMETRY, **{**usual, **changes}))
    return frame


def test_every_frame_of_the_session_is_accounted_for() -> None:
    decoder = Decoder()
    raws = [raw for _, raw in records(SESSION)]
    for raw in raws:
        decoder.datagram(raw)
    counters = decoder.counters
    assert sum(len(raw) + 8 for raw in raws) == len(SESSION)
    assert (counters.frames, counters.unknown) == (973, 0)
    assert (counters.bad_crc, counters.garbage_bytes, counters.lost) == (0, 0, 0)
    names = Counter(frame.format.name for frame in frames(SESSION))
    assert names["ATTITUDE_QUATERNION"] == 219
    assert names["ODOMETRY"] == 123
    assert names["SET_ATTITUDE_TARGET"] == 219


def test_states_of_the_session() -> None:
    telemetry = Telemetry()
    states: list[VehicleState] = []
    velocities: list[tuple[float, float, float]] = []
    for frame in frames(SESSION):
        if (frame.system, frame.component) != (1, 1):
            continue
        state = telemetry.receive(frame, 0.0)
        if state is not None:
            states.append(state)
        if frame.format.name == "LOCAL_POSITION_NED":
            velocities.append(frame.values[4:7])
    stamps = [state.t_boot for state in states]
    assert stamps == sorted(stamps)
    assert all(0.007 < b - a < 0.017 for a, b in itertools.pairwise(stamps))
    assert {state.v_n for state in states} <= set(velocities)  # velocity in NED, bit for bit PX4's own
    assert telemetry.status.last.mode is Mode.OFFBOARD
    assert telemetry.status.last.armed
    assert telemetry.status.last.landed is Landed.IN_AIR
    assert not telemetry.refused


def test_velocity_in_the_body_frame_is_turned() -> None:
    """PX4 up to 1.13: with the nose to the east, forward is east."""
    state = Telemetry().receive(odometry(child_frame_id=12), 0.0)
    assert state is not None
    assert state.v_n == pytest.approx((0.0, 4.0, 0.0), abs=1e-6)
    plain = Telemetry().receive(odometry(), 0.0)
    assert plain is not None
    assert plain.v_n == (4.0, 0.0, 0.0)
    assert plain.p_n == (1.0, 2.0, -3.0)
    assert plain.t_boot == 5.0
    assert plain.resets == 7


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"x": math.nan}, "not finite"),
        ({"vz": math.inf}, "not finite"),
        ({"q": (0.0, 0.0, 0.0, 0.0)}, "without an attitude"),
        ({"x": 3e38}, "further than 100 km"),
        ({"z": -100_001.0}, "further than 100 km"),
        ({"vy": -3e38}, "faster than 200 m/s"),
        ({"vz": 250.0}, "faster than 200 m/s"),
        ({"rollspeed": 3e38}, "turning faster than 70 rad/s"),
        ({"yawspeed": -71.0}, "turning faster than 70 rad/s"),
        ({"time_usec": 2**64 - 1}, "stamped later than"),
        ({"time_usec": 2**52}, "stamped later than"),
        ({"frame_id": 21}, "frame 21"),
        ({"child_frame_id": 3}, "frame 3"),
    ],
)
def test_what_is_no_state_is_refused_and_counted(changes: dict[str, Value], reason: str) -> None:
    telemetry = Telemetry()
    assert telemetry.receive(odometry(**changes), 0.0) is None
    ((said, count),) = telemetry.refused.items()
    assert reason in said
    assert count == 1


def test_a_state_at_the_edge_of_what_a_vehicle_can_be_is_one() -> None:
    telemetry = Telemetry()
    state = telemetry.receive(odometry(x=9e4, vx=190.0, rollspeed=69.0, time_usec=2**52 - 1), 0.0)
    assert state is not None
    assert state.t_boot < 2**52 * 1e-6
    assert not telemetry.refused


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("HOME_POSITION", {"x": 3e38}),
        ("HOME_POSITION", {"y": math.nan}),
        ("HOME_POSITION", {"latitude": 900_000_001}),
        ("HOME_POSITION", {"altitude": 2**31 - 1}),
        ("GPS_GLOBAL_ORIGIN", {"longitude": -(2**31)}),
        ("GPS_GLOBAL_ORIGIN", {"altitude": -(2**31)}),
    ],
)
def test_a_place_that_is_none_is_not_known(name: str, fields: dict[str, Value]) -> None:
    telemetry = Telemetry()
    (frame,) = Decoder().datagram(Encoder(1, 1).message(message(name), **fields))
    telemetry.receive(frame, 0.0)
    assert telemetry.home is None
    assert telemetry.origin is None


@pytest.mark.parametrize(
    ("custom_mode", "mode"),
    [(0x00060000, Mode.OFFBOARD), (0x03040000, Mode.HOLD), (99, Mode.UNKNOWN)],
)
def test_modes(custom_mode: int, mode: Mode) -> None:
    telemetry = Telemetry()
    (frame,) = Decoder().datagram(
        Encoder(1, 1).message(HEARTBEAT, custom_mode=custom_mode, base_mode=0x81, system_status=5, autopilot=12)
    )
    telemetry.receive(frame, 0.0)
    assert telemetry.status.last.mode is mode
    assert telemetry.status.last.armed
    assert telemetry.status.last.failsafe
    assert mode is Mode.UNKNOWN or Mode(mode.value).custom_mode == custom_mode
