"""One link for all: what endpoints get of the vehicle, what they may send it, and that none of them costs the others."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import pytest
from mavsdk.plugins.action import Action
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry
from pymavlink import mavutil
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.daemon.forwarding import (
    DOWN_MAX,
    SETPOINTS,
    UP_A_TURN,
    UP_BURST,
    UP_MAX,
    UP_RATE,
    Endpoint,
    Forwarder,
    message_of,
    parse_endpoint,
)
from companion.daemon.port import AddressError
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import message
from companion.services.vehicle import connect_vehicle
from companion.vehicle import OutputLevel
from tests.support.flights import Flown, flight

HEARTBEAT, ATTITUDE = message("HEARTBEAT"), message("ATTITUDE_QUATERNION")
COMMAND, SETPOINT = message("COMMAND_LONG"), message("SET_ATTITUDE_TARGET")


class Station:
    """A ground station's socket, read only when asked."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(5.0)
        self.encoder = Encoder(255, 190)

    def endpoint(self, max_hz: float | None = None, *, commands: bool = True) -> Endpoint:
        return Endpoint("127.0.0.1", self.socket.getsockname()[1], max_hz, commands)

    def heard(self) -> list[bytes]:
        self.socket.settimeout(0.0)
        found = []
        try:
            while True:
                found.append(self.socket.recv(65535))
        except OSError:
            return found

    def says(self, forwarder: Forwarder, end: int, *frames: bytes) -> None:
        """To the forwarder's socket of an endpoint."""
        for frame in frames:
            self.socket.sendto(frame, forwarder.ends[end].socket.getsockname())


@pytest.fixture
def stations() -> Iterator[list[Station]]:
    found = [Station() for _ in range(3)]
    yield found
    for station in found:
        station.socket.close()


def forwarder_to(*endpoints: Endpoint) -> Forwarder:
    return Forwarder(endpoints, deque(), lambda: 0.0)


def test_endpoints_get_the_vehicles_messages_unchanged_and_thinned_as_they_ask(stations: list[Station]) -> None:
    all_of_it, thinned, _ = stations
    forwarder = forwarder_to(all_of_it.endpoint(), thinned.endpoint(10.0))
    vehicle = Encoder(1, 1)
    sent = []
    for tick in range(100):  # 1 s at 100 Hz
        frames = [vehicle.message(ATTITUDE, time_boot_ms=10 * tick, q1=1.0)]
        frames += [vehicle.message(HEARTBEAT, type=2)] if tick % 10 == 0 else []
        for one in frames:
            forwarder.give(one)
        sent += frames
        forwarder.work(0.01 * tick)
    forwarder.give(Encoder(1, 191).message(SETPOINT))  # ours to the vehicle: not theirs to see
    forwarder.work(1.0)
    assert all_of_it.heard() == sent
    kinds = [message_of(one) for one in thinned.heard()]
    assert kinds.count(HEARTBEAT.id) == 10 and kinds.count(ATTITUDE.id) == 10
    assert next(line.split(",")[0] for line in forwarder.close()).endswith(f"{len(sent)} messages")


def test_what_an_endpoint_sends_goes_to_the_vehicle_unchanged_and_no_second_setpoint(stations: list[Station]) -> None:
    station, other, _ = stations
    forwarder = forwarder_to(station.endpoint(), other.endpoint())
    said = [station.encoder.message(COMMAND, command=176, target_system=1), station.encoder.message(HEARTBEAT, type=6)]
    setpoint = station.encoder.message(SETPOINT, target_system=1)
    station.says(forwarder, 0, said[0] + said[1], setpoint, b"rubbish", said[0][:-1])
    stranger = Station()  # at another address than the endpoint's
    stranger.says(forwarder, 0, said[0])
    forwarder.work(0.0)
    assert forwarder.upward() == said and forwarder.upward() == []
    assert forwarder.ends[0].refused == 1 and SETPOINT.id in SETPOINTS
    stranger.socket.close()


def test_one_that_may_only_look_sends_nothing_on(stations: list[Station]) -> None:
    forwarder = forwarder_to(stations[0].endpoint(commands=False))
    stations[0].says(forwarder, 0, stations[0].encoder.message(COMMAND, command=400, param1=1.0))
    forwarder.work(0.0)
    assert forwarder.upward() == [] and forwarder.ends[0].refused == 1


def test_one_that_floods_and_one_that_is_gone_cost_the_others_nothing(stations: list[Station]) -> None:
    good, flood, gone = stations
    forwarder = forwarder_to(good.endpoint(), flood.endpoint(), gone.endpoint())
    gone.socket.close()
    long = message("COMMAND_LONG")
    vehicle, count = Encoder(1, 1), 0
    heartbeat = vehicle.message(HEARTBEAT, type=2)
    mine = [good.encoder.message(long, command=512, param1=float(i)) for i in range(10)]
    passed: list[bytes] = []
    for tick in range(100):
        flood.says(forwarder, 1, *[flood.encoder.message(long, command=1, param7=1.0)] * 30)
        if tick % 10 == 0:
            good.says(forwarder, 0, mine[tick // 10])
        forwarder.give(heartbeat)
        forwarder.work(0.01 * tick)
        passed += forwarder.upward()
        count += 1
    while more := forwarder.upward():
        passed += more
    assert [one for one in passed if one in mine] == mine
    assert sum(map(len, passed)) - sum(map(len, mine)) <= UP_BURST + UP_RATE * 1.0
    assert good.heard() == [heartbeat] * count
    assert forwarder.ends[1].refused > 1000


def test_a_stopped_thread_keeps_a_bounded_number_and_the_control_thread_takes_few(stations: list[Station]) -> None:
    forwarder = forwarder_to(stations[0].endpoint())
    for i in range(DOWN_MAX + 50):
        forwarder.give(Encoder(1, 1, i & 255).message(HEARTBEAT, type=2))
    assert len(forwarder._down) == DOWN_MAX
    one = stations[0].encoder.message(HEARTBEAT)
    stations[0].says(forwarder, 0, *[one] * 50)
    forwarder.work(0.0)
    assert len(forwarder.upward()) == UP_A_TURN and len(forwarder._up) <= UP_MAX


def test_a_conductor_relays_what_comes_and_what_goes() -> None:
    relayed: list[bytes] = []

    def prepare(flown: Flown) -> None:
        flown.conductor.relay(relayed.append)

    flown = flight(level=OutputLevel.RATES, duration=1.0, prepare=prepare)
    names = {(one.component, one.format.name) for raw in relayed for one in Decoder().datagram(raw)}
    assert {(1, "HEARTBEAT"), (1, "ODOMETRY"), (191, "HEARTBEAT"), (191, "SET_ATTITUDE_TARGET")} <= names
    assert sum(message_of(raw) == message("ODOMETRY").id for raw in relayed) >= flown.conductor.states


@pytest.mark.parametrize(
    ("url", "endpoint"),
    [
        ("udpout://127.0.0.1:14550", Endpoint("127.0.0.1", 14550, None, True)),
        ("udpout://127.0.0.1:14550?max_hz=5&commands=no", Endpoint("127.0.0.1", 14550, 5.0, False)),
        ("udpout://192.168.1.4:14550", Endpoint("192.168.1.4", 14550, None, False)),
        ("udpout://192.168.1.4:14550?commands=yes", Endpoint("192.168.1.4", 14550, None, True)),
    ],
)
def test_endpoints_beyond_this_computer_only_look_unless_told(url: str, endpoint: Endpoint) -> None:
    assert parse_endpoint(url) == endpoint


@pytest.mark.parametrize(
    "url",
    ["", "14550", "udpin://127.0.0.1:1", "udpout://127.0.0.1", "udpout://h:99999", "udpout://127.0.0.1:1?max_hz=x",
     "udpout://127.0.0.1:1?max_hz=0", "udpout://127.0.0.1:1?max_hz=nan", "udpout://127.0.0.1:1?commands=maybe",
     "udpout://127.0.0.1:1?rate=5", "udpout://127.0.0.1:1/path", "udpout://127.0.0.1:1?x", "udpout://[::1:5", "udpout://127.0.0.1:1#x"],
)  # fmt: skip
def test_what_is_no_endpoint_is_answered_in_one_line(url: str) -> None:
    with pytest.raises(AddressError) as error:
        parse_endpoint(url)
    assert "expected" in str(error.value) and "\n" not in str(error.value)


def test_the_fault_is_the_option_s_own() -> None:
    result = CliRunner().invoke(app, ["fly", "circle_r5", "--connect", "udpin://127.0.0.1:1", "--forward", "14550"])
    assert str(result.exception).startswith("--forward: '14550' is no endpoint")


@pytest.mark.parametrize("host", ["a..b", "x" * 70, "a\0b"])
def test_a_host_that_none_can_be_called_is_not_known(host: str) -> None:
    with pytest.raises(AddressError, match="is not known"):
        parse_endpoint(f"udpout://{host}:1")


@pytest.mark.xdist_group("real time")
def test_a_ground_station_and_mavsdk_work_through_it(tmp_path: Path) -> None:
    """pymavlink at one endpoint hears the vehicle, reads a parameter of it, commands it and hears the answer; MAVSDK at
    another reads the same parameter, arms the vehicle and sees it armed."""
    ports = []
    for _ in range(3):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            ports.append(free.getsockname()[1])
    quiet = {"stderr": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
    plant = [
        sys.executable,
        "-m",
        "sim_bridge",
        "--ground-station",
        "none",
        "--connect",
        f"udpout://127.0.0.1:{ports[0]}",
    ]
    fly = [sys.executable, "-m", "companion", "fly", "circle_r5", "--connect", f"udpin://127.0.0.1:{ports[0]}"]
    fly += ["--start", "pilot", "--record", "flight", "--no-report"]
    fly += [word for port in ports[1:] for word in ("--forward", f"udpout://127.0.0.1:{port}")]
    environment = os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)}
    processes = [subprocess.Popen(command, cwd=tmp_path, env=environment, **quiet) for command in (plant, fly)]  # type: ignore[call-overload]
    try:
        station = mavutil.mavlink_connection(f"udpin:127.0.0.1:{ports[1]}", source_system=255)
        while (heard := station.recv_match(type="HEARTBEAT", blocking=True, timeout=40.0)) is not None:
            if heard.get_srcComponent() == 1:
                break
        assert heard is not None
        station.mav.param_request_read_send(1, 1, b"COM_OF_LOSS_T", -1)
        answer = station.recv_match(
            type="PARAM_VALUE", condition="PARAM_VALUE.param_id=='COM_OF_LOSS_T'", blocking=True, timeout=20.0
        )
        assert answer is not None and answer.param_value == 1.0
        station.mav.command_long_send(1, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0)  # REQUEST_MESSAGE AUTOPILOT_VERSION
        answer = station.recv_match(
            type="COMMAND_ACK", condition="COMMAND_ACK.command==512", blocking=True, timeout=20.0
        )
        assert answer is not None and answer.result == 0
        station.close()
        with connect_vehicle(f"udpin://127.0.0.1:{ports[2]}") as vehicle:
            assert vehicle is not None
            assert Param(vehicle.system).get_param_float("COM_OF_LOSS_T") == 1.0
            telemetry, ends = Telemetry(vehicle.system), time.monotonic() + 20.0
            while not telemetry.health_all_ok() and time.monotonic() < ends:
                time.sleep(0.1)
            Action(vehicle.system).arm()
            while not telemetry.armed() and time.monotonic() < ends:
                time.sleep(0.1)
            assert telemetry.armed()
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait(30.0)
