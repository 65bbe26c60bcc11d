"""What the stand-in PX4 says by itself and when: rates, stamps, frames, identity, answers about streams."""

from __future__ import annotations

import math

import pytest

from companion.frames import quaternion_from_euler
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.world import Home, Link, Start, Way, World
from tests.support.plant_client import (
    ACCEPTED,
    DENIED,
    FAILED,
    GET_INTERVAL,
    NAN,
    REQUEST,
    SET_INTERVAL,
    UNSUPPORTED,
    Client,
)  # fmt: skip

ONBOARD_HZ = {
    "ATTITUDE": 100, "ATTITUDE_QUATERNION": 50, "GLOBAL_POSITION_INT": 50, "HIGHRES_IMU": 50,
    "LOCAL_POSITION_NED": 30, "ODOMETRY": 30, "TIMESYNC": 10, "ALTITUDE": 10, "DISTANCE_SENSOR": 10, "ESC_INFO": 10,
    "ESC_STATUS": 10, "ATTITUDE_TARGET": 10, "POSITION_TARGET_LOCAL_NED": 10, "SERVO_OUTPUT_RAW": 10, "VFR_HUD": 10,
    "GPS_RAW_INT": 8, "EXTENDED_SYS_STATE": 5, "SYS_STATUS": 5, "HEARTBEAT": 1, "PING": 1, "SYSTEM_TIME": 1,
    "ESTIMATOR_STATUS": 1, "SCALED_PRESSURE": 1, "LINK_NODE_STATUS": 1, "ESTIMATOR_SENSOR_FUSION_STATUS": 1,
    "GNSS_INTEGRITY": 1, "OPEN_DRONE_ID_LOCATION": 1, "OPEN_DRONE_ID_SYSTEM": 1, "BATTERY_STATUS": 0.5,
    "CURRENT_MODE": 0.5, "HOME_POSITION": 0.5, "VIBRATION": 0.5, "TIME_ESTIMATE_TO_TARGET": 0.5, "MISSION_CURRENT": 1,
    "CURRENT_EVENT_SEQUENCE": 0.33,
}  # fmt: skip
"""px4.md section 1: what PX4 sends a companion."""
GROUND_HZ = {
    "ATTITUDE": 50, "ATTITUDE_QUATERNION": 50, "ATTITUDE_TARGET": 50, "LOCAL_POSITION_NED": 50,
    "GLOBAL_POSITION_INT": 50, "SERVO_OUTPUT_RAW": 50, "POSITION_TARGET_LOCAL_NED": 50, "GPS_RAW_INT": 5, "VFR_HUD": 4,
    "SYS_STATUS": 1, "HEARTBEAT": 1, "ALTITUDE": 1, "EXTENDED_SYS_STATE": 1, "PING": 0.1, "VIBRATION": 0.1,
    "ESTIMATOR_STATUS": 0.5, "DISTANCE_SENSOR": 0.5, "HOME_POSITION": 0.5, "MISSION_CURRENT": 1,
}  # fmt: skip
BESIDES = {"EVENT"}
"""What is sent by other rules."""
MOVING = Start((1.0, 2.0, -30.0), (3.0, -1.0, 0.5), quaternion_from_euler(2.0, 0.1, -0.2), (0.1, 0.2, -0.3))


def rate(client: Client, name: str, seconds: float, endpoint: int = 0) -> float:
    start = client.bridge.now
    client.run(seconds)
    return len(client.all(name, endpoint, since=start)) / seconds


def test_what_px4_says_unasked_at_boot() -> None:
    client = Client("sih", landed=True)
    client.run(4.0)
    for endpoint in (0, 1):
        values = client.all("PARAM_VALUE", endpoint)
        assert len(values) == 16
        assert (values[0]["param_id"], values[-1]["param_id"]) == ("CAL_ACC0_ID", "SYS_AUTOSTART")
        grabs = client.all("COMMAND_LONG", endpoint)
        assert [(said["command"], said["target_system"], said["confirmation"]) for said in grabs] == [
            (211, 0, confirmation) for confirmation in range(4)
        ]
    flying = Client("sih")
    flying.run(4.0)
    assert not flying.all("PARAM_VALUE") and not flying.all("COMMAND_LONG")


@pytest.mark.parametrize("vehicle", ["sih", "paper"])
def test_default_rates_are_px4s(vehicle: str) -> None:
    client = Client(vehicle)
    client.run(0.5)
    start = client.bridge.now
    client.run(10.0)
    for endpoint, table in enumerate((ONBOARD_HZ, GROUND_HZ)):
        for name, hz in table.items():
            at = [h.at for h in client.heard if h.name == name and h.endpoint == endpoint and h.at > start]
            assert len(at) == pytest.approx(hz * 10.0, abs=1.01), name
            if len(at) > 2:
                assert (len(at) - 1) / (at[-1] - at[0]) == pytest.approx(hz, rel=0.03), name
    assert {h.name for h in client.heard if h.endpoint == 0 and h.at > start} == {*ONBOARD_HZ, *BESIDES}
    assert not client.all("ACTUATOR_OUTPUT_STATUS")


@pytest.mark.parametrize(
    ("name", "interval_us", "hz"),
    [
        ("ATTITUDE_QUATERNION", 4000, 250),
        ("ATTITUDE_QUATERNION", 1000, 250),
        ("ATTITUDE", 10000, 100),
        ("HIGHRES_IMU", 8000, 125),
        ("ODOMETRY", 4000, 125),
        ("ODOMETRY", 10000, 100),
        ("LOCAL_POSITION_NED", 2000, 125),
        ("ACTUATOR_OUTPUT_STATUS", 20000, 50),
        ("EXTENDED_SYS_STATE", 100000, 10),
        ("CURRENT_MODE", 33333, 2),  # no more often than the status is published
        ("HIL_STATE_QUATERNION", 4000, 250),
    ],
)
def test_intervals_up_to_what_the_source_gives(name: str, interval_us: int, hz: float) -> None:
    client = Client("sih", endpoints=1)
    assert client.command(SET_INTERVAL, message(name).id, interval_us) == ACCEPTED
    client.run(0.1)
    assert rate(client, name, 1.0) == pytest.approx(hz, abs=1.01)


@pytest.mark.parametrize(("vehicle", "hz"), [("x500", 250), ("paper", 1000)])
def test_with_direct_motors_odometry_comes_at_every_step(vehicle: str, hz: int) -> None:
    client = Client(vehicle, direct=True, endpoints=1)
    assert client.bridge.step_s == 1.0 / hz
    client.command(SET_INTERVAL, message("ODOMETRY").id, 1000)
    start = client.bridge.now
    client.run(0.5)
    stamps = [fields["time_usec"] for fields in client.all("ODOMETRY", since=start)]
    assert stamps == [i * 1_000_000 // hz for i in range(1, hz // 2 + 1)]


def test_a_stream_can_be_stopped_and_brought_back() -> None:
    client = Client("sih")
    quaternion = message("ATTITUDE_QUATERNION").id
    assert client.command(SET_INTERVAL, quaternion, -1) == ACCEPTED
    assert rate(client, "ATTITUDE_QUATERNION", 0.5) == 0.0
    assert rate(client, "ATTITUDE_QUATERNION", 0.5, endpoint=1) == 50.0  # the other link has its own
    assert client.command(SET_INTERVAL, quaternion, 0) == ACCEPTED
    assert rate(client, "ATTITUDE_QUATERNION", 1.0) == 50.0


def test_answers_about_intervals() -> None:
    client = Client("sih")
    assert client.command(SET_INTERVAL, message("ATTITUDE").id, 5000) == ACCEPTED
    for asked, by, interval in (
        ("ATTITUDE", GET_INTERVAL, 5000), ("ODOMETRY", REQUEST, 33333), ("GPS_RAW_INT", REQUEST, -1),
    ):  # fmt: skip
        parameters = (message(asked).id,) if by == GET_INTERVAL else (message("MESSAGE_INTERVAL").id, message(asked).id)
        assert client.command(by, *parameters) == ACCEPTED
        assert client.last("MESSAGE_INTERVAL") == {"message_id": message(asked).id, "interval_us": interval}
    for refused in (0, 27, 340, 70000):
        assert client.command(SET_INTERVAL, refused, 10000) == FAILED
    assert client.command(SET_INTERVAL, 31, 10000, 1.0) == FAILED
    assert client.command(SET_INTERVAL, 31, 10000, NAN, NAN, NAN, NAN, NAN) == ACCEPTED
    assert client.command(SET_INTERVAL, NAN, NAN) == FAILED


def test_state_messages_agree_in_stamp_frame_and_value() -> None:
    client = Client("sih", start=MOVING, endpoints=1)
    for name in ("ATTITUDE", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "ODOMETRY", "HIL_STATE_QUATERNION"):
        client.command(SET_INTERVAL, message(name).id, 4000)
    client.run(0.4)
    truth = client.bridge.truth
    odometry = client.last("ODOMETRY")
    assert odometry["time_usec"] == 400_000
    assert (odometry["frame_id"], odometry["child_frame_id"]) == (1, 1)
    assert (odometry["x"], odometry["y"], odometry["z"]) == pytest.approx(truth.p_n, rel=1e-6)
    assert (odometry["vx"], odometry["vy"], odometry["vz"]) == pytest.approx(truth.v_n, rel=1e-6)
    assert odometry["q"] == pytest.approx(truth.q_nb, abs=1e-7)
    rates = tuple(odometry[f"{axis}speed"] for axis in ("roll", "pitch", "yaw"))
    assert rates == pytest.approx(truth.w_b, abs=1e-7)
    assert (odometry["estimator_type"], odometry["quality"]) == (8, 0)
    assert odometry["pose_covariance"][6] > 0.0
    position = client.last("LOCAL_POSITION_NED")
    assert position["time_boot_ms"] == 400
    assert all(position[key] == odometry[key] for key in ("x", "y", "z", "vx", "vy", "vz"))
    quaternion = client.last("ATTITUDE_QUATERNION")
    assert quaternion["time_boot_ms"] == 400
    assert tuple(quaternion[f"q{i}"] for i in range(1, 5)) == odometry["q"]
    euler = client.last("ATTITUDE")
    again = quaternion_from_euler(euler["yaw"], euler["pitch"], euler["roll"])
    assert abs(sum(a * b for a, b in zip(again, truth.q_nb, strict=True))) == pytest.approx(1.0, abs=1e-9)
    values = client.last("HIL_STATE_QUATERNION")
    assert values["time_usec"] == 400_000
    assert values["attitude_quaternion"] == pytest.approx(truth.q_nb, abs=1e-7)


def test_global_position_is_the_local_one_on_the_map() -> None:
    home = Home(47.0, 8.0, 500.0)
    client = Client("sih", World(home=home), start=Start.hover((100.0, -50.0, -20.0), math.radians(-90.0)))
    client.run(0.1)
    fields = client.last("GLOBAL_POSITION_INT")
    per_degree = math.radians(1.0) * 6371000.0
    assert fields["lat"] * 1e-7 == pytest.approx(47.0 + 100.0 / per_degree, abs=2e-7)
    assert fields["lon"] * 1e-7 == pytest.approx(8.0 - 50.0 / per_degree / math.cos(math.radians(47.0)), abs=2e-7)
    assert (fields["alt"], fields["relative_alt"], fields["hdg"]) == (520_000, 20_000, 27_000)
    origin = client.command(REQUEST, message("GPS_GLOBAL_ORIGIN").id), client.last("GPS_GLOBAL_ORIGIN")
    assert origin[0] == ACCEPTED
    assert (origin[1]["latitude"], origin[1]["longitude"], origin[1]["altitude"]) == (470_000_000, 80_000_000, 500_000)


def test_the_imu_feels_the_specific_force() -> None:
    client = Client("sih", start=Start.hover((0.0, 0.0, -10.0)), endpoints=1)
    client.run(0.1)
    imu = client.last("HIGHRES_IMU")
    assert (imu["xacc"], imu["yacc"], imu["zacc"]) == pytest.approx((0.0, 0.0, -9.80665), abs=1e-5)
    client.command(400, 0, 21196)  # motors off: free fall
    client.run(1.0)
    imu = client.last("HIGHRES_IMU")
    assert imu["zacc"] == pytest.approx(-client.bridge.truth.v_n[2], abs=0.1)  # the air at 1 / s is all it feels


def test_identity_shows_direct_motors_and_nothing_else_does() -> None:
    for vehicle, direct, flag in (("x500", False, 0), ("x500", True, 1024), ("paper", False, 1024)):
        client = Client(vehicle, direct=direct)
        assert client.command(REQUEST, message("AUTOPILOT_VERSION").id) == ACCEPTED
        version = client.last("AUTOPILOT_VERSION")
        assert version["capabilities"] == 0xE8FF | flag
        assert version["flight_sw_version"] >> 16 >= 0x0113
        names = [heard.name for heard in client.heard]
        assert names.index("AUTOPILOT_VERSION") < names.index("COMMAND_ACK")


def test_requests_for_what_is_not_there() -> None:
    client = Client("sih")
    for msgid in (24, 77, 12345, -1):
        assert client.command(REQUEST, msgid) == DENIED
    for msgid in (NAN, 1e20, 65536.0):  # PX4 casts: all of these are 0, the heartbeat
        assert client.command(REQUEST, msgid) == ACCEPTED
    for command in (519, 520, 31000, 9999):
        assert client.command(command) == UNSUPPORTED
    assert client.command(246, 1.0) == DENIED
    assert client.command(400, 1.0, 0.0, 0.0, 0.0, 2147483647.0, 2147483647.0) == DENIED  # integers not given, cast


def test_commands_for_others_are_not_answered() -> None:
    client = Client("sih")
    for system, component, answers in ((1, 1, 1), (0, 0, 1), (1, 0, 1), (2, 1, 0), (1, 191, 0)):
        before = len(client.all("COMMAND_ACK"))
        client.send("COMMAND_LONG", command=31000, target_system=system, target_component=component)
        assert len(client.all("COMMAND_ACK")) - before == answers
    ack = client.last("COMMAND_ACK")
    assert (ack["target_system"], ack["target_component"]) == (1, 191)
    assert not client.all("COMMAND_ACK", endpoint=1)


def test_command_int_is_a_command_too() -> None:
    client = Client("sih")
    client.send("COMMAND_INT", command=REQUEST, param1=242.0, frame=5)
    assert client.last("COMMAND_ACK")["result"] == ACCEPTED
    assert client.all("HOME_POSITION")


def test_timesync_and_ping_are_answered_at_once() -> None:
    client = Client("sih")
    client.run(0.4)
    client.send("TIMESYNC", tc1=0, ts1=123_456_789_012)
    answer = client.last("TIMESYNC")
    assert (answer["tc1"], answer["ts1"]) == (400_000_000, 123_456_789_012)
    count = len(client.all("TIMESYNC"))
    client.send("TIMESYNC", tc1=5, ts1=6)  # somebody's answer
    assert len(client.all("TIMESYNC")) == count
    client.send("PING", time_usec=77, seq=5, target_system=0, target_component=0)
    answer = client.last("PING")
    assert (answer["time_usec"], answer["seq"], answer["target_system"], answer["target_component"]) == (77, 5, 1, 191)
    client.send("PING", time_usec=78, seq=6)  # an answer to us
    assert client.last("PING")["seq"] == 5


def test_heartbeats_cross_from_link_to_link() -> None:
    client = Client("sih")
    raw = Encoder(255, 190).message(message("HEARTBEAT"), type=6)
    client.bridge.receive(raw, 1)
    sent = client.bridge.datagrams()
    assert (0, raw) in sent
    assert (1, raw) not in sent
    raw = Encoder(255, 190).message(message("COMMAND_LONG"), command=9999, target_system=1, target_component=1)
    client.bridge.receive(raw, 1)  # for the vehicle alone
    assert [endpoint for endpoint, _ in client.bridge.datagrams()] == [1]
    raw = Encoder(255, 190).message(message("COMMAND_LONG"), command=9999, target_system=1, target_component=191)
    client.bridge.receive(raw, 1)  # for a companion nobody has heard of
    assert client.bridge.datagrams() == []
    client.send("HEARTBEAT", type=18)
    client.bridge.receive(raw, 1)
    assert client.bridge.datagrams() == [(0, raw)]


def test_texts_go_only_where_a_ground_station_was_heard_and_in_pieces() -> None:
    client = Client("sih", landed=True)
    client.command(400, 1)
    client.ground_station()
    client.command(400, 1)
    assert not client.all("STATUSTEXT", 0)
    pieces = client.all("STATUSTEXT", 1)
    assert [(p["severity"], len(p["text"]), p["chunk_seq"]) for p in pieces] == [(2, 50, 0), (2, 2, 1)]
    assert client.texts() == ["Arming denied: Resolve system health failures first\t"]


def test_a_link_with_delay_delivers_late_in_order() -> None:
    client = Client("sih", World(link=Link(Way(0.02), Way(0.012))), endpoints=1)
    client.run(0.1)
    sent = client.bridge.now
    client.send("COMMAND_LONG", command=31000)
    client.run_until(lambda: client.all("COMMAND_ACK"), 1.0)
    assert client.bridge.now - sent == pytest.approx(0.032, abs=1e-9)
    stamps = [fields["time_boot_ms"] for fields in client.all("ATTITUDE")]
    assert stamps == sorted(stamps)
    assert stamps[-1] == pytest.approx(client.bridge.now * 1e3 - 20.0, abs=12.0)


def test_only_what_the_other_end_looks_at() -> None:
    """Less is said, and what is said comes when it came before; answers come as ever."""
    whole, lean = Client(endpoints=1), Client(endpoints=1, only={message("ODOMETRY").id, message("HEARTBEAT").id})
    for client in (whole, lean):
        assert client.command(SET_INTERVAL, message("ATTITUDE").id, 4000.0) == ACCEPTED
        client.run(2.0)
    polled = {"COMMAND_ACK", "MISSION_CURRENT", "CURRENT_EVENT_SEQUENCE"}  # no streams, and told all the same
    assert {heard.name for heard in lean.heard} == {"ODOMETRY", "HEARTBEAT", *polled}
    for name in ("ODOMETRY", "HEARTBEAT"):
        told = [
            [(heard.at, repr(heard.fields)) for heard in client.heard if heard.name == name] for client in (lean, whole)
        ]
        assert told[0] == told[1] and told[0]
