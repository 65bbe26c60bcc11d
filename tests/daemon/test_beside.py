"""PX4's XRCE client served beside the link: on a UDP socket that closes and opens again, and on a serial line."""

from __future__ import annotations

import os
import pty
import socket
import time
from pathlib import Path

import pytest

from companion.daemon.address import open_port
from companion.daemon.beside import Beside, XrceLink, parse_xrce_address
from companion.daemon.port import AddressError
from companion.mavlink.peer import Received, Source
from companion.vehicle import MotorSetpoint, OutputLevel
from companion.xrce.commands import Commands
from companion.xrce.framing import AGENT, CLIENT, Deframer, framed
from companion.xrce.topics import LAYOUTS
from tests.flights.test_paper_cases import companion
from tests.xrce.small_client import SmallClient

pytestmark = pytest.mark.xdist_group("real time")

IN = ["offboard_control_mode", "actuator_motors", "vehicle_thrust_setpoint"]
MOTORS = MotorSetpoint((0.5, 0.5, 0.5, 0.5))
LIMIT = 5.0
"""s for a client to connect."""


def client() -> SmallClient:
    return SmallClient([f"rt/fmu/in/{name}" for name in IN], ["rt/fmu/out/vehicle_control_mode"])


def in_offboard(small: SmallClient) -> None:
    small.publish(
        "rt/fmu/out/vehicle_control_mode",
        LAYOUTS["vehicle_control_mode", 0].encode(flag_control_offboard_enabled=True),
    )


def test_motors_are_read_again_right_after_its_socket_was_closed_and_opened() -> None:
    """Within 50 ms: the session, its readers and its numbers are the daemon's, and not the socket's."""
    commands, small = Commands(OutputLevel.MOTORS), client()
    port = open_port("udpin://127.0.0.1:0".replace(":0", f":{free_port()}"))
    link = open_port(f"udpin://127.0.0.1:{free_port()}")
    here = XrceLink(port, commands)
    beside = Beside(link, here, time.monotonic)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as px4:
        px4.setblocking(False)
        px4.connect(("127.0.0.1", port.local[1]))  # type: ignore[attr-defined]

        def turn() -> None:
            for data in small.datagrams(time.monotonic()):
                px4.send(data)
            assert beside.receive(0.001) == []
            receive_all(px4, small)

        begun = time.monotonic()
        while not small.ready:
            turn()
            assert time.monotonic() - begun < LIMIT
        in_offboard(small)
        turn()
        assert commands.send(MOTORS, 1.0, time.monotonic(), True)
        port.close()
        here.flush(time.monotonic())  # lost
        closed = time.monotonic()
        here.port = open_port(f"udpin://127.0.0.1:{port.local[1]}")  # type: ignore[attr-defined]
        assert commands.send(MOTORS, 1.1, time.monotonic(), True)
        here.flush(time.monotonic())
        while not small.read:
            turn()
        took = time.monotonic() - closed
        print(f"read again after {1e3 * took:.1f} ms")
        assert took < 0.05
    assert [name for name, _ in small.read] == [f"rt/fmu/in/{name}" for name in IN]
    beside.close()


def test_only_a_client_takes_the_place_of_one_that_fell_silent() -> None:
    """After 3 s of silence a ping or a new client does, whatever else comes does not; within them nobody does."""
    port, commands = Datagrams(), Commands(OutputLevel.MOTORS)
    here = XrceLink(port, commands)
    (ping,) = client().datagrams(0.0)

    def served(data: bytes, source: Source, now: float) -> list[Source]:
        port.arrived, port.sent = [(data, source)], []
        here.serve(now)
        return [to for _, to in port.sent]

    px4, stranger = ("127.0.0.1", 1), ("127.0.0.1", 2)
    assert served(b"hello", stranger, 0.0) == []
    assert served(ping, px4, 0.1) == [px4]
    assert served(ping, stranger, 3.0) == []
    assert served(b"hello", stranger, 4.0) == []
    assert served(ping, px4, 4.1) == [px4]
    assert served(ping, stranger, 8.0) == [stranger]


class Datagrams:
    """A Port of lists."""

    stream = False
    called: Source | None = None
    exposed = False

    def __init__(self) -> None:
        self.arrived: list[Received] = []
        self.sent: list[Received] = []

    def receive(self, timeout: float) -> list[Received]:
        return self.arrived

    def send(self, data: bytes, to: Source) -> None:
        self.sent.append((data, to))

    def fileno(self) -> int:
        return -1

    def describe(self) -> str:
        return "lists"

    def close(self) -> None:
        pass


def test_a_serial_line_carries_the_same() -> None:
    ours, theirs = pty.openpty()
    commands, small = Commands(OutputLevel.MOTORS), client()
    here = XrceLink(open_port(f"serial://{os.ttyname(theirs)}:921600"), commands)
    os.set_blocking(ours, False)
    deframer = Deframer(CLIENT)
    begun = time.monotonic()
    while not (small.ready and small.read):
        assert time.monotonic() - begun < LIMIT
        for data in small.datagrams(time.monotonic()):
            os.write(ours, framed(data, CLIENT, AGENT))
        here.serve(time.monotonic())
        if small.ready:
            in_offboard(small)
            commands.send(MOTORS, 1.0, time.monotonic(), True)
            here.flush(time.monotonic())
        try:
            received = deframer.receive(os.read(ours, 65536))
        except BlockingIOError:
            continue
        for data in received:
            small.receive(data)
    here.port.close()
    os.close(ours)
    os.close(theirs)


def test_a_state_goes_first_and_a_link_that_never_rests_does_not_keep_px4_waiting() -> None:
    commands = Commands(OutputLevel.MOTORS)
    link, port = open_port(f"udpin://127.0.0.1:{free_port()}"), open_port(f"udpin://127.0.0.1:{free_port()}")
    beside = Beside(link, XrceLink(port, commands), time.monotonic)
    (ping,) = client().datagrams(0.0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as px4:
        for served in (0, 2, 2):  # what is owed is done first, with what has come meanwhile
            px4.sendto(ping, port.local)  # type: ignore[attr-defined]
            px4.sendto(b"state", link.local)  # type: ignore[attr-defined]
            assert [data for data, _ in beside.receive(1.0)] == [b"state"]
            assert commands.agent.counters.messages == served
        assert beside.receive(0.0) == []
        assert commands.agent.counters.messages == 3
    beside.close()


def test_an_agent_that_has_the_port_is_named_with_what_to_do() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        url = f"udp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(AddressError, match="in use; where MicroXRCEAgent has it, end that"):
            parse_xrce_address(url)()
    with pytest.raises(AddressError, match="expected udp://HOST:PORT or serial:///dev/NAME:BAUD"):
        parse_xrce_address("udpin://127.0.0.1:8888")
    with pytest.raises(AddressError, match=r"^'udp://:88' names no host and port; expected udp://HOST:PORT or serial"):
        parse_xrce_address("udp://:88")


def test_motors_over_xrce_are_refused_until_their_price_is_accepted(tmp_path: Path) -> None:
    options = ("--connect", f"udpin://127.0.0.1:{free_port()}", "--xrce", f"udp://127.0.0.1:{free_port()}")
    done = companion("fly", "circle_r5", "--vehicle", "sih", *options, "--output", "torques", cwd=tmp_path)
    assert done.returncode == 2
    assert "PX4 does not stabilise the vehicle" in done.stderr
    assert "--accept-direct-motors" in done.stderr
    done = companion("fly", "circle_r5", *options, "--output", "rates", "--start", "mode", cwd=tmp_path)
    assert done.returncode == 2
    assert "--start mode flies attitude alone, not rates" in done.stderr
    done = companion("fly", "circle_r5", *options, "--mode-name", "Path", cwd=tmp_path)
    assert done.returncode == 2
    assert "--mode-name goes with --start mode" in done.stderr


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def receive_all(sock: socket.socket, small: SmallClient) -> None:
    while True:
        try:
            small.receive(sock.recv(65535))
        except (BlockingIOError, ConnectionRefusedError):
            return
