"""Addresses and links: what a typo or a missing device says, who is talked to, a serial line that stutters."""

from __future__ import annotations

import os
import pty
import socket
import time
from pathlib import Path

import pytest

from companion.daemon.address import UdpPort, is_exposed, open_port, parse_address
from companion.daemon.port import AddressError
from companion.daemon.serial import SerialPort
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import message
from companion.mavlink.peer import LINE, Received
from tests.flights.test_paper_cases import companion

pytestmark = pytest.mark.xdist_group("real time")

HEARTBEAT, ATTITUDE, ODOMETRY = message("HEARTBEAT"), message("ATTITUDE"), message("ODOMETRY")


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("seriel:///dev/ttyAMA0:921600", "did you mean serial://?"),
        ("udpinn://127.0.0.1:14540", "did you mean udpin://?"),
        ("udp://127.0.0.1:14540", "is no address"),
        ("tcp://127.0.0.1:5760", "expected udpin://HOST:PORT, udpout://HOST:PORT or serial:///dev/NAME:BAUD"),
        ("127.0.0.1:14540", "is no address"),
        ("udpin://127.0.0.1", "names no host and port"),
        ("udpin://127.0.0.1:0", "names no host and port"),
        ("udpin://127.0.0.1:145400", "no port between 1 and 65535"),
        ("udpin://127.0.0.1:14540/x", "is no address"),
        ("udpout://no-such-host.invalid:14540", "the host 'no-such-host.invalid' is not known"),
        ("udpout://a..b:14540", "the host 'a..b' is not known"),
        (f"udpout://{'x' * 70}:14540", "is not known"),
        ("udpin://a\0b:14540", "is not known"),
        ("serial:///dev/ttyAMA0", "names no device and baud rate"),
        ("serial://ttyAMA0:57600", "names no device and baud rate"),
        ("serial:///dev/ttyAMA0:57601", "57601 is no baud rate of this system; expected 57600, 115200"),
        ("", "is no address"),
    ],
)
def test_what_is_no_address_is_said_in_one_sentence(url: str, said: str) -> None:
    with pytest.raises(AddressError) as caught:
        parse_address(url)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_port_that_is_taken_and_a_device_that_is_none() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        with pytest.raises(AddressError, match="already in use; does another companion or a ground station listen"):
            open_port(f"udpin://127.0.0.1:{taken.getsockname()[1]}")
    with pytest.raises(AddressError, match="cannot be opened: No such file or directory; "):
        open_port("serial:///dev/no-such-line:57600")
    with pytest.raises(AddressError, match="/dev/null is not a serial line"):
        open_port("serial:///dev/null:57600")


def test_a_serial_line_in_use_says_by_whom_and_the_command_ends_with_2(tmp_path: Path) -> None:
    _, slave = pty.openpty()
    device = os.ttyname(slave)
    first = SerialPort(device, 57600)
    done = companion("fly", "circle_r5", "--connect", f"serial://{device}:57600", cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert f"{device} is in use" in done.stderr
    assert f"({os.getpid()})" in done.stderr
    assert "end what uses it, or take another port" in done.stderr
    assert "Traceback" not in done.stderr
    first.close()


def test_a_serial_line_finds_its_way_back_after_garbage_and_half_frames() -> None:
    master, slave = pty.openpty()
    port = SerialPort(os.ttyname(slave), 57600)
    os.set_blocking(master, False)
    encoder, decoder = Encoder(1, 1), Decoder()
    frames = [encoder.message(ODOMETRY, time_usec=i, q=(1.0, 0.0, 0.0, 0.0)) for i in range(20)]
    # joined in the middle of a frame, a start byte that is none, a frame cut short, a burst of noise
    spoilt = [frames[0][7:], b"\xfd\xff", *frames[1:5], frames[5][:9], *frames[6:9], bytes(range(256)) * 2, *frames[9:]]
    found = []
    for piece in spoilt:
        os.write(master, piece)
        for data, _ in port.receive(0.2):
            found += [frame.raw for frame in decoder.stream(data)]
    kept = [*frames[1:5], *frames[6:9], *frames[9:]]
    assert found == kept
    port.send(frames[0], LINE)
    assert os.read(master, 4096) == frames[0]
    port.close()


def test_a_line_that_is_unplugged_is_silent_and_comes_back(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    master, slave = pty.openpty()
    link = tmp_path / "line"
    link.symlink_to(os.ttyname(slave))
    port = SerialPort(str(link), 57600)
    os.close(slave)
    os.close(master)
    begun = time.monotonic()
    for _ in range(4):
        assert port.receive(0.05) == []  # it waits: no loop at full speed
    assert time.monotonic() - begun > 0.1
    port.send(b"lost", LINE)
    master, slave = pty.openpty()
    link.unlink()
    link.symlink_to(os.ttyname(slave))
    until = time.monotonic() + 5.0
    data: list[Received] = []
    while not data and time.monotonic() < until:
        os.write(master, b"\xfd")
        data = port.receive(0.1)
    assert data
    port.close()


def test_each_datagram_comes_with_its_source_and_goes_where_it_is_sent() -> None:
    port = UdpPort("127.0.0.1", 0, listen=True)
    first, second = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    sources = []
    for each, data in ((first, b"a"), (second, b"b")):
        each.settimeout(2.0)
        each.sendto(data, port.local)
        ((got, source),) = port.receive(1.0)
        assert got == data
        sources.append(source)
    assert sources == [("127.0.0.1", first.getsockname()[1]), ("127.0.0.1", second.getsockname()[1])]
    port.send(b"for the second", sources[1])
    assert second.recv(100) == b"for the second"
    first.setblocking(False)
    with pytest.raises(BlockingIOError):
        first.recv(100)
    for link in (first, second, port):
        link.close()
    assert port.called is None
    calling = UdpPort("127.0.0.1", 14999, listen=False)
    assert calling.called == ("127.0.0.1", 14999)
    assert calling.describe().endswith(" to 127.0.0.1:14999")
    calling.close()


def test_only_a_line_and_this_computer_are_closed_to_others() -> None:
    for host, exposed in (("127.0.0.1", False), ("127.1.2.3", False), ("0.0.0.0", True)):
        port = UdpPort(host, 0, listen=True)
        assert port.exposed is exposed
        port.close()
    assert not SerialPort.exposed
    assert is_exposed("udpin://0.0.0.0:14540") and is_exposed("udpout://10.0.0.7:14540")
    assert not is_exposed("udpin://127.0.0.1:14540") and not is_exposed("serial:///dev/ttyAMA0:57600")


def test_all_that_waits_is_taken_at_once() -> None:
    port = UdpPort("127.0.0.1", 0, listen=True)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for i in range(900):
            sender.sendto(b"%d" % i, port.local)
        assert len(port.receive(1.0)) == 900
        assert port.receive(0.0) == []
    port.close()
