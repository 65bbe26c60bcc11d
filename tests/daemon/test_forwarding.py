"""One link for all: what endpoints get of the vehicle, what they may send it, and that none of them costs the others."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from mavsdk.plugins.action import Action
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry
from pymavlink import mavutil
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.daemon.endpoints import (
    SETPOINTS,
    UP_BURST,
    UP_RATE,
    Exchange,
    Line,
    message_of,
    split,
)
from companion.daemon.forwarding import (
    UP_AT_ONCE,
    Endpoint,
    Forwarder,
    parse_endpoint,
)
from companion.daemon.loop import _Flight
from companion.daemon.port import AddressError
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import message
from companion.mavlink.signing import Signing
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

    def says(self, shared: Shared, end: int, *frames: bytes) -> None:
        """To the socket of an endpoint."""
        for frame in frames:
            self.socket.sendto(frame, shared.lines[end].socket.getsockname())


class Shared(Exchange):
    """The endpoints' side of the local socket, and here the daemon's as well."""

    def __init__(self, *endpoints: Endpoint) -> None:
        self.daemon, local = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        lines = []
        for to in endpoints:
            end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            end.connect((to.host, to.port))
            lines.append(Line(str(to), end, to.max_hz, to.commands))
        for each in (self.daemon, local, *(line.socket for line in lines)):
            each.setblocking(False)
        super().__init__(local, lines)

    def give(self, *frames: bytes) -> None:
        self.daemon.send(b"".join(frames))

    def upward(self) -> list[bytes]:
        found = []
        with contextlib.suppress(BlockingIOError):
            while True:
                found.append(self.daemon.recv(1024))
        return found


@pytest.fixture
def stations() -> Iterator[list[Station]]:
    found = [Station() for _ in range(3)]
    yield found
    for station in found:
        station.socket.close()


def test_endpoints_get_the_vehicles_messages_unchanged_and_thinned_as_they_ask(stations: list[Station]) -> None:
    all_of_it, thinned, _ = stations
    shared = Shared(all_of_it.endpoint(), thinned.endpoint(10.0))
    vehicle = Encoder(1, 1)
    sent = []
    for tick in range(100):  # 1 s at 100 Hz
        frames = [vehicle.message(ATTITUDE, time_boot_ms=10 * tick, q1=1.0)]
        frames += [vehicle.message(HEARTBEAT, type=2)] if tick % 10 == 0 else []
        shared.give(*frames)
        sent += frames
        assert shared.look(0.01 * tick)
    shared.give(Encoder(1, 191).message(SETPOINT))  # ours to the vehicle: not theirs to see
    shared.look(1.0)
    assert all_of_it.heard() == sent
    kinds = [message_of(one) for one in thinned.heard()]
    assert kinds.count(HEARTBEAT.id) == 10 and kinds.count(ATTITUDE.id) == 10
    shared.close(())
    first, second = shared.upward()[0].decode().split("\n")
    assert first.split(",")[0].endswith(f"{len(sent)} messages") and ": 20 messages, 0 lost" in second


def test_what_an_endpoint_sends_goes_to_the_vehicle_unchanged_and_no_second_setpoint(stations: list[Station]) -> None:
    station, other, _ = stations
    shared = Shared(station.endpoint(), other.endpoint())
    said = [station.encoder.message(COMMAND, command=176, target_system=1), station.encoder.message(HEARTBEAT, type=6)]
    setpoint = station.encoder.message(SETPOINT, target_system=1)
    station.says(shared, 0, said[0] + said[1], setpoint, b"rubbish", said[0][:-1])
    stranger = Station()  # at another address than the endpoint's
    stranger.says(shared, 0, said[0])
    shared.look(0.0)
    assert shared.upward() == said and shared.upward() == []
    assert shared.lines[0].refused == 1 and SETPOINT.id in SETPOINTS
    stranger.socket.close()


def test_one_that_may_only_look_sends_nothing_on(stations: list[Station]) -> None:
    shared = Shared(stations[0].endpoint(commands=False))
    stations[0].says(shared, 0, stations[0].encoder.message(COMMAND, command=400, param1=1.0))
    shared.look(0.0)
    assert shared.upward() == [] and shared.lines[0].refused == 1


def test_one_that_floods_and_one_that_is_gone_cost_the_others_nothing(stations: list[Station]) -> None:
    good, flood, gone = stations
    shared = Shared(good.endpoint(), flood.endpoint(), gone.endpoint())
    gone.socket.close()
    long = message("COMMAND_LONG")
    vehicle, count = Encoder(1, 1), 0
    heartbeat = vehicle.message(HEARTBEAT, type=2)
    mine = [good.encoder.message(long, command=512, param1=float(i)) for i in range(10)]
    passed: list[bytes] = []
    for tick in range(100):
        flood.says(shared, 1, *[flood.encoder.message(long, command=1, param7=1.0)] * 30)
        if tick % 10 == 0:
            good.says(shared, 0, mine[tick // 10])
        shared.give(heartbeat)
        shared.look(0.01 * tick)
        passed += shared.upward()
        count += 1
    assert [one for one in passed if one in mine] == mine
    assert sum(map(len, passed)) - sum(map(len, mine)) <= UP_BURST + UP_RATE * 1.0
    assert good.heard() == [heartbeat] * count
    assert shared.lines[1].refused > 1000
    assert shared.lines[2].unsent == count and shared.lines[2].sent == 0


def test_a_daemon_that_takes_nothing_keeps_nobody_waiting(stations: list[Station]) -> None:
    """What finds no room is refused; the vehicle's messages still go to the endpoints."""
    shared = Shared(stations[0].endpoint())
    one = stations[0].encoder.message(HEARTBEAT)
    for tick in range(200):
        stations[0].says(shared, 0, *[one] * 20)
        shared.look(float(tick))
    line = shared.lines[0]
    shared.give(one)
    shared.look(200.0)
    assert stations[0].heard() == [one]
    assert line.taken == len(shared.upward()) and line.taken + line.refused == 4000 and line.refused > 0


def test_frames_one_behind_another_are_told_apart() -> None:
    key = Signing(bytes(32))
    frames = [
        Encoder(1, 1).message(ATTITUDE, q1=1.0),
        Encoder(1, 1, signing=key).message(HEARTBEAT, type=2),
        b"\xfe\x09\x00\x01\x01\x00" + bytes(9) + b"\x00\x00",  # MAVLink 1
        Encoder(1, 191).message(COMMAND, command=1),
    ]
    assert list(split(b"".join(frames))) == frames and list(split(b"")) == []


def started(*endpoints: Endpoint) -> tuple[Forwarder, list[str]]:
    notes: list[str] = []
    return Forwarder(endpoints, notes.append), notes


def test_the_control_thread_takes_few_and_never_waits(stations: list[Station]) -> None:
    """Whatever comes up, and with a process that is stopped: what finds no room is counted."""
    forwarder, notes = started(stations[0].endpoint())
    beat = Encoder(1, 1).message(HEARTBEAT, type=2)
    forwarder.give([beat])
    assert forwarder.exchange(0.0, answered=True) == []
    stations[0].socket.settimeout(10.0)
    data, it = stations[0].socket.recvfrom(1024)
    assert data == beat
    one = stations[0].encoder.message(HEARTBEAT)
    for _ in range(20):
        stations[0].socket.sendto(one, it)
    found: list[bytes] = []
    now, until = 1.0, time.monotonic() + 10.0
    while len(found) < 20 and time.monotonic() < until:
        some = forwarder.exchange(now, answered=True)
        assert len(some) <= UP_AT_ONCE and forwarder.exchange(now, answered=True) == []  # not due again
        found += some
        now += 0.01
    assert found == [one] * 20
    stations[0].socket.sendto(one, it)
    time.sleep(0.1)
    assert forwarder.exchange(now + 0.01, answered=False) == []  # a state may come at any time: only later
    assert forwarder.exchange(now + 0.04, answered=False) == [one]
    os.kill(forwarder.pid, signal.SIGSTOP)
    for _ in range(3000):
        forwarder.give([beat] * 6)
        forwarder.exchange(now, answered=True)
        now += 0.01
    os.kill(forwarder.pid, signal.SIGCONT)
    told = forwarder.close(10.0)
    assert notes == [] and f"forwarded to {stations[0].endpoint()}: " in told[0] and "21 passed on" in told[0]
    sent, dropped = (int(words.split(": ")[1].split()[0]) for words in told)
    assert sent + dropped == 18001 and dropped > 0 and "held up" in told[1]


def test_a_process_that_ends_in_flight_is_told_once_and_the_flight_goes_on(stations: list[Station]) -> None:
    forwarder, notes = started(stations[0].endpoint())
    os.kill(forwarder.pid, signal.SIGKILL)
    forwarder._process.wait(10.0)
    for tick in range(5):
        forwarder.give([Encoder(1, 1).message(HEARTBEAT)])
        assert forwarder.exchange(float(tick), answered=True) == []
    assert forwarder.close(5.0) == [] and forwarder._frames == []
    (note,) = notes
    assert "forwarding has ended" in note and "the flight goes on" in note


@pytest.mark.parametrize("gently", [True, False])
def test_the_process_is_ordinary_and_ends_with_the_daemon_only(gently: bool, stations: list[Station]) -> None:
    """Not at a signal to it. With a daemon that is killed, it ends as well."""
    to = stations[0].endpoint()
    beat = Encoder(1, 1).message(HEARTBEAT, type=2)
    daemon = f"""
from companion.daemon.forwarding import Endpoint, Forwarder
from companion.daemon.realtime import at_priority
at_priority(1)
forwarder = Forwarder([Endpoint({to.host!r}, {to.port}, None, True)], print)
forwarder.give([{beat!r}])
forwarder.exchange(0.0, answered=True)
print(forwarder.pid, flush=True)
input()
print(forwarder.close(10.0), flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", daemon], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None and process.stdout is not None
    pid = int(process.stdout.readline())
    stations[0].socket.settimeout(10.0)
    stations[0].socket.recv(1024)  # it serves
    assert os.sched_getscheduler(pid) == os.SCHED_OTHER and os.getpriority(os.PRIO_PROCESS, pid) >= 0
    assert os.getsid(pid) == pid
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        os.kill(pid, number)
    if gently:
        told, _ = process.communicate("\n", 20.0)
        assert "1 messages, 0 lost" in told
    else:
        process.kill()
        process.communicate()
    until = time.monotonic() + 10.0
    while Path(f"/proc/{pid}/cmdline").exists() and b"endpoints" in Path(f"/proc/{pid}/cmdline").read_bytes():
        assert time.monotonic() < until
        time.sleep(0.01)


def test_a_conductor_relays_what_comes_and_what_goes() -> None:
    relayed: list[bytes] = []

    def prepare(flown: Flown) -> None:
        flown.conductor.relay(relayed.extend)

    flown = flight(level=OutputLevel.RATES, duration=1.0, prepare=prepare)
    names = {(one.component, one.format.name) for raw in relayed for one in Decoder().datagram(raw)}
    assert {(1, "HEARTBEAT"), (1, "ODOMETRY"), (191, "HEARTBEAT"), (191, "SET_ATTITUDE_TARGET")} <= names
    assert sum(message_of(raw) == message("ODOMETRY").id for raw in relayed) >= flown.conductor.states


def test_an_endpoint_sees_and_sets_our_own_parameters_and_a_signed_link_wants_it_signed() -> None:
    flown = flight(level=OutputLevel.RATES, duration=1.0)
    conductor, passed = flown.conductor, list[bytes]()
    wanted = {"target_system": 1, "target_component": 191, "param_id": "PF_SPEED_SCALE", "param_type": 9}

    def sends(*frames: bytes) -> None:
        port = SimpleNamespace(send=lambda frame, to: passed.append(frame))
        loop = _Flight(conductor, port, None, None, None, None)  # type: ignore[arg-type]
        loop._send_on(list(frames), 100.0)

    key = Signing(bytes(range(32)))
    plain = [Encoder(255, 190, i).message(message("PARAM_SET"), param_value=0.5 + 0.1 * i, **wanted) for i in range(2)]
    signed = Encoder(255, 190, signing=key).message(message("PARAM_SET"), param_value=0.9, **wanted)
    other = Encoder(255, 190).message(message("PARAM_SET"), param_value=0.1, **{**wanted, "target_component": 1})
    sends(plain[0], other)
    assert conductor.ground.speed_scale == pytest.approx(0.5) and passed == [plain[0], other]
    conductor.decoder.signing = Signing(bytes(range(32)))
    sends(plain[1])
    assert conductor.ground.speed_scale == pytest.approx(0.5) and passed[-1] == plain[1]
    sends(signed)
    assert conductor.ground.speed_scale == pytest.approx(0.9)


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
        station.mav.param_set_send(1, 191, b"PF_SPEED_SCALE", 0.8, 9)
        answer = station.recv_match(
            type="PARAM_VALUE", condition="PARAM_VALUE.param_id=='PF_SPEED_SCALE'", blocking=True, timeout=20.0
        )
        assert answer is not None and answer.get_srcComponent() == 191 and answer.param_value == pytest.approx(0.8)
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
