"""The plant as a process: command line, sockets, real time, the truth file."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import development as mavlink

from companion.mavlink.modes import Mode
from companion.world import Start, World
from companion.world.events import Operator, Order, PortChange, Stranger, When
from companion.xrce.messages import CreateClient, GetInfo, Info
from companion.xrce.wire import Message, decode, encode
from sim_bridge import __main__ as command_line
from sim_bridge.autopilot.xrce import Release
from sim_bridge.server import Endpoint, EndpointError, Server, endpoint_of
from sim_bridge.truth_file import BLOCK, HEADER_SIZE, TruthFile, header
from tests.support.plant_client import Client

pytestmark = pytest.mark.xdist_group("real time")


class Peer:
    """A client on pymavlink and a socket of its own."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(30.0)
        self.port = self.socket.getsockname()[1]
        self.mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=191)
        self.mav.robust_parsing = True
        self.vehicle: Any = None

    def next(self, kind: str) -> Any:
        """The next message of a kind."""
        while True:
            data, self.vehicle = self.socket.recvfrom(4096)
            for message in self.mav.parse_buffer(bytearray(data)) or []:
                if message.get_type() == kind:
                    return message

    def send(self, message: Any) -> None:
        self.socket.sendto(message.pack(self.mav), self.vehicle)


@pytest.fixture
def peer() -> Iterator[Peer]:
    made = Peer()
    yield made
    made.socket.close()


def started(*arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "sim_bridge", "--ground-station", "none", *arguments]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def test_a_real_client_flies_it_over_udp(peer: Peer, tmp_path: Path) -> None:
    """Rates are taken from the vehicle's stamps, so that a busy machine cannot make it fail."""
    truth = tmp_path / "truth.npy"
    process = started("--connect", f"udpout://127.0.0.1:{peer.port}", "--hover", "--truth", str(truth))
    try:
        heartbeat = peer.next("HEARTBEAT")
        assert (heartbeat.type, heartbeat.autopilot, heartbeat.base_mode) == (2, 12, 0x9D)
        peer.send(mavlink.MAVLink_command_long_message(1, 1, 511, 0, 31, 4000, 0, 0, 0, 0, 0))
        assert peer.next("COMMAND_ACK").result == 0
        peer.next("ATTITUDE_QUATERNION")
        began, first = time.monotonic(), peer.next("ATTITUDE_QUATERNION").time_boot_ms
        stamps = [peer.next("ATTITUDE_QUATERNION").time_boot_ms for _ in range(250)]
        flown, passed = (stamps[-1] - first) / 1e3, time.monotonic() - began
        assert statistics.median(np.diff(stamps)) == 4
        assert flown < passed + 0.3  # never faster than real time, but for what was on its way
        peer.send(mavlink.MAVLink_command_long_message(1, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0))
        assert peer.next("AUTOPILOT_VERSION").capabilities == 0xE8FF
        process.kill()
        process.wait(10)
        rows = np.load(truth)  # readable though the plant was killed
        assert len(rows) % BLOCK == 0
        assert len(rows) >= BLOCK
        assert rows["t_boot"] == pytest.approx(np.arange(1, len(rows) + 1) * 0.004)
        assert rows["p_n"][-1] == pytest.approx((0.0, 0.0, -10.0), abs=1e-3)
        assert rows["rotor_thrusts"].sum(axis=1) == pytest.approx(2.0 * 9.80665, rel=1e-3)
    finally:
        process.kill()
        process.wait(10)
        assert process.stderr is not None
        process.stderr.close()


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_signals_end_it_cleanly(peer: Peer, tmp_path: Path, number: signal.Signals, code: int) -> None:
    truth = tmp_path / "truth.npy"
    start = json.dumps({"position_n": [1, 2, -3], "held": True})
    process = started(
        *("--connect", f"udpout://127.0.0.1:{peer.port}", "--vehicle", "paper", "--start", start),
        *("--truth", str(truth)),
    )
    peer.next("HEARTBEAT")
    process.send_signal(number)
    _, said = process.communicate(timeout=20)
    assert process.returncode == code
    assert "paper in ideal, 1000 steps a second, motor commands taken" in said
    assert "0 messages, 0 damaged, 0 bytes of garbage" in said
    assert len(np.load(truth)) == 1  # held: its clock stood


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--vehicle", "nothing"], "no vehicle of this name"),
        (["--world", "nowhere"], "no world of this name"),
        (["--xrce-agent", "nowhere"], "expected HOST:PORT"),
        (["--connect", "tcp://1.2.3.4:5"], "--connect: 'tcp://1.2.3.4:5' is no connection the plant can make"),
        (["--connect", "udpin://127.0.0.1"], "names no host and port"),
        (["--connect", "udpin://127.0.0.1:99999"], "has no port between 1 and 65535"),
        (["--ground-station", "udpout://:14550"], "--ground-station: 'udpout://:14550' names no host and port"),
        (["--start", '{"position_n": [1, 2]}'], "--start:1: position_n: 2 of them; expected at least 3"),
        (["--start", '{"position_n": [1, 2, 3], "q_nb": [1, 1, 0, 0]}'], "expected a unit quaternion"),
        (["--start", "{"], "--start:1: not valid YAML"),
        (["--truth", "/nowhere/at/all.npy"], "No such file or directory"),
        (["--motors", "magic"], ""),
        (["--speed", "0"], ""),
    ],
)
def test_bad_input_ends_with_2_before_anything_starts(
    arguments: list[str], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["sim-bridge", *arguments])
    with pytest.raises(SystemExit) as ended:
        command_line.main()
    assert ended.value.code == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert "Traceback" not in captured.err


def test_all_faults_are_shown_at_once(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["sim-bridge", "--vehicle", "a", "--world", "b", "--connect", "c"])
    with pytest.raises(SystemExit):
        command_line.main()
    assert len(capsys.readouterr().err.splitlines()) == 3


def test_a_port_in_use_is_one_clear_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        options = ["--connect", f"udpin://127.0.0.1:{port}", "--ground-station", "none"]
        monkeypatch.setattr(sys, "argv", ["sim-bridge", *options])
        with pytest.raises(SystemExit) as ended:
            command_line.main()
    assert ended.value.code == 2
    wrong = [line for line in capsys.readouterr().err.splitlines() if "cannot be opened" in line]
    assert wrong == [f"UDP port {port} on 127.0.0.1 cannot be opened: Address already in use"]


def test_endpoints_of_urls() -> None:
    assert endpoint_of("udpin://0.0.0.0:14540") == Endpoint(("0.0.0.0", 14540), None)
    assert endpoint_of("udpout://127.0.0.1:14540") == Endpoint(("127.0.0.1", 0), ("127.0.0.1", 14540))
    assert endpoint_of("udpout://192.0.2.7:14540").bind[0] == "0.0.0.0"
    with pytest.raises(EndpointError, match="the host is not known"):
        endpoint_of("udpout://a..b:14540")
    with pytest.raises(EndpointError, match="expected udpin"):
        endpoint_of("serial:///dev/ttyAMA0:921600")


def test_its_xrce_client_calls_the_agent() -> None:
    client = Client("sih", endpoints=1, xrce=Release.MAIN)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as agent:
        agent.bind(("127.0.0.1", 0))
        agent.settimeout(10.0)
        server = Server(client.bridge, [Endpoint(("127.0.0.1", 0), None)], agent=agent.getsockname(), log=len)
        steps = iter(range(40))
        try:
            server.run(lambda: next(steps) == 10)
            data, of_client = agent.recvfrom(512)
            (ping,) = decode(data).submessages
            assert isinstance(ping, GetInfo)
            agent.sendto(encode(Message(0x80, 0, 0, (Info(ping.request, ping.object, True),))), of_client)
            server.run(lambda: next(steps) == 30)
            (asked,) = decode(agent.recvfrom(512)[0]).submessages
            assert isinstance(asked, CreateClient)
        finally:
            server.close()


def test_the_first_to_call_is_the_partner_from_then_on(peer: Peer) -> None:
    client = Client("sih", endpoints=1)
    lines: list[str] = []
    server = Server(client.bridge, [Endpoint(("127.0.0.1", 0), None)], log=lines.append)
    address = server._sockets[0].getsockname()
    stranger = Peer()
    try:
        deadline = [40]

        def stopped() -> bool:
            deadline[0] -= 1
            if deadline[0] == 39:
                peer.socket.sendto(b"hello", address)
            if deadline[0] == 20:
                stranger.socket.sendto(b"me too", address)
            return deadline[0] == 0

        server.run(stopped)
        assert peer.next("HEARTBEAT").type == 2
        stranger.socket.setblocking(False)
        with pytest.raises(BlockingIOError):
            stranger.socket.recvfrom(100)
        assert client.bridge.counters[0].garbage_bytes == len(b"hello") + len(b"me too")
        assert sum("heard from" in line for line in lines) == 1
    finally:
        server.close()
        stranger.socket.close()


def test_a_plant_that_is_late_slips_and_says_so() -> None:
    client = Client("sih", endpoints=1)
    lines: list[str] = []
    calls = [0]

    def slow() -> None:
        calls[0] += 1
        if calls[0] == 10:
            time.sleep(0.3)

    server = Server(
        client.bridge, [Endpoint(("127.0.0.1", 0), ("127.0.0.1", 9))], log=lines.append, after_step=slow
    )  # fmt: skip
    began = time.monotonic()
    server.run(lambda: calls[0] >= 50)
    server.close()
    assert time.monotonic() - began > 0.3 + 40 * 0.004  # what was lost is not made up for in a burst
    busy = [line for line in lines if "times real time of 1 asked for; the machine is busy" in line]
    assert len(busy) == 1
    assert 0.0 < float(busy[0].split(" s, ")[1].split()[0]) < 0.5  # 40 ms of plant time in 340


def test_late_steps_follow_at_twice_the_pace_and_not_in_a_burst() -> None:
    client = Client("sih", endpoints=1)
    times: list[float] = []

    def late_once() -> None:
        if len(times) == 10:
            time.sleep(0.08)
        times.append(time.monotonic())

    server = Server(
        client.bridge, [Endpoint(("127.0.0.1", 0), ("127.0.0.1", 9))], log=lambda line: None, after_step=late_once
    )
    server.run(lambda: len(times) >= 30)
    server.close()
    assert 0.0015 < statistics.median(np.diff(times[11:25])) < 0.0035 or times[-1] - times[0] > 0.3  # a busy machine


def test_speed_is_kept_and_never_exceeded() -> None:
    found: list[tuple[float, float, float]] = []
    for _ in range(3):
        client = Client("sih", endpoints=1)
        said: list[str] = []
        server = Server(client.bridge, [Endpoint(("127.0.0.1", 0), None)], speed=8.0, log=said.append)
        began = time.monotonic()
        server.run(lambda bridge=client.bridge: bridge.now >= 0.4)
        took = time.monotonic() - began
        server.close()
        timing = re.search(r"0.40 s: 0.40 s of plant time in (.*) s, (.*) times real time of 8 asked for", said[-1])
        assert timing is not None, said
        found.append((took, float(timing[1]), float(timing[2])))
    took, seconds, times = min(found)  # the least of a busy machine
    assert seconds == pytest.approx(took, abs=0.02)
    assert times == pytest.approx(0.4 / took, rel=0.2)  # what it was, not what was asked for
    assert 0.4 / 8.0 - 0.001 < took < 0.4 / 2.0


def test_a_truth_file_says_what_was(tmp_path: Path) -> None:
    client = Client("x500", start=Start((0.0, 0.0, -5.0), (1.0, 2.0, 3.0)))
    path = tmp_path / "truth.npy"
    assert len(header(0)) == len(header(10**12)) == HEADER_SIZE
    with TruthFile(path) as record:
        assert len(np.load(path)) == 0
        for _ in range(3):
            client.bridge.step()
            record.append(client.bridge.truth, client.bridge.autopilot.commands)
            record.append(client.bridge.truth, client.bridge.autopilot.commands)
    rows = np.load(path)
    truth = client.bridge.truth
    assert len(rows) == 3
    for name in ("t_boot", "p_n", "v_n", "q_nb", "w_b", "rotor_thrusts"):
        assert np.array_equal(rows[name][-1], getattr(truth, name))
    assert np.array_equal(rows["commands"][-1], client.bridge.autopilot.commands)
    assert os.path.getsize(path) == HEADER_SIZE + 3 * 22 * 8


def test_strangers_and_a_changed_port_have_sockets_of_their_own(peer: Peer) -> None:
    events = (Stranger(When(0.1), 2), PortChange(When(0.5, 0.5)), Operator(When(0.7, 0.7), Order.LAND))
    client = Client("x500", World(events=events), endpoints=1)
    server = Server(client.bridge, [Endpoint(("127.0.0.1", 0), ("127.0.0.1", peer.port))], log=lambda line: None)
    try:
        server.run(lambda: client.bridge.now > 1.0)
    finally:
        server.close()
    peer.socket.setblocking(False)
    sources: dict[tuple[str, int], set[int]] = {}
    while True:
        try:
            data, address = peer.socket.recvfrom(4096)
        except BlockingIOError:
            break
        sources.setdefault(address, set()).add(data[5])
    assert sorted(sources.values(), key=str) == [{1}, {1}, {2}]
    assert client.flown is Mode.LAND
