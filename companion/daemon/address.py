"""Addresses in MAVSDK's spelling -> a port to read and write.

udpin://HOST:PORT      listen; answer whoever is heard first
udpout://HOST:PORT     call
serial:///dev/NAME:BAUD
"""

from __future__ import annotations

import os
import select
import socket
import termios
import tty
from collections.abc import Callable
from typing import Protocol
from urllib.parse import urlsplit

from companion.vehicle import CompanionError

RECEIVE_BUFFER = 1 << 20
"""bytes. The default holds 256 small datagrams: a quarter of a second of a busy link."""
DATAGRAM_MAX = 65535
BATCH_MAX = 4096
"""Datagrams that are drained before the newest state is acted on: more than the buffer holds after any stall."""


class AddressError(CompanionError):
    """An address that is not one, or that cannot be opened (exit code 2)."""


class Port(Protocol):
    """An open link. ``stream``: bytes come in pieces rather than datagrams."""

    stream: bool

    def receive(self, timeout: float) -> list[bytes]:
        """What has arrived: waits at most ``timeout`` s for the first piece, then takes all there is."""

    def send(self, data: bytes) -> None:
        """Send one frame. A peer that is away is no error."""

    def close(self) -> None:
        """Close the link."""

    def describe(self) -> str:
        """What is listened to, for a person."""


class UdpPort:
    """A UDP socket that talks to one peer: the one it calls, or the first it hears."""

    stream = False

    def __init__(self, host: str, port: int, *, listen: bool) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._peer: tuple[str, int] | None = None if listen else (host, port)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        self._socket.setblocking(False)
        try:
            self._socket.bind((host, port) if listen else ("127.0.0.1" if host.startswith("127.") else "0.0.0.0", 0))
        except OSError as error:
            self._socket.close()
            raise AddressError(f"UDP {host}:{port} cannot be opened: {error.strerror}") from None
        self.local: tuple[str, int] = self._socket.getsockname()

    def receive(self, timeout: float) -> list[bytes]:
        """See Port."""
        batch: list[bytes] = []
        receive = self._socket.recvfrom
        try:
            # select waits to the microsecond, a socket's own time-out to the next millisecond
            if timeout > 0.0 and not select.select([self._socket], (), (), timeout)[0]:
                return batch
            while len(batch) < BATCH_MAX:
                data, address = receive(DATAGRAM_MAX)
                if self._peer is None:
                    self._peer = address
                batch.append(data)
        except OSError:  # nothing more, or what an unreachable peer leaves behind
            pass
        return batch

    def send(self, data: bytes) -> None:
        """See Port."""
        if self._peer is not None:
            try:
                self._socket.sendto(data, self._peer)
            except OSError:  # nobody there: UDP may lose it, and the guards see the silence
                return

    def close(self) -> None:
        """See Port."""
        self._socket.close()

    def describe(self) -> str:
        """See Port."""
        return f"UDP {self.local[0]}:{self.local[1]}" + (f" to {self._peer[0]}:{self._peer[1]}" if self._peer else "")


class SerialPort:
    """A serial line, raw, 8N1, without flow control."""

    stream = True

    def __init__(self, device: str, baud: int) -> None:
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise AddressError(f"{baud} is no baud rate of this system; expected 57600, 115200, 460800, 921600, ...")
        try:
            self._file = os.open(device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            hint = "; is the device plugged in?" if isinstance(error, FileNotFoundError) else ""
            hint = "; is the user in the group dialout?" if isinstance(error, PermissionError) else hint
            raise AddressError(f"{device} cannot be opened: {error.strerror}{hint}") from None
        try:
            tty.setraw(self._file)
            attributes = termios.tcgetattr(self._file)
            attributes[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
            attributes[4] = attributes[5] = speed
            termios.tcsetattr(self._file, termios.TCSANOW, attributes)
        except termios.error:
            os.close(self._file)
            raise AddressError(f"{device} is not a serial line") from None
        self._name = f"{device} at {baud} baud"

    def receive(self, timeout: float) -> list[bytes]:
        """See Port."""
        ready, _, _ = select.select([self._file], [], [], max(timeout, 0.0))
        if not ready:
            return []
        try:
            data = os.read(self._file, DATAGRAM_MAX)
        except OSError:  # unplugged: silence, which the guards see
            return []
        return [data] if data else []

    def send(self, data: bytes) -> None:
        """See Port."""
        try:
            os.write(self._file, data)
        except OSError:  # full or unplugged: an old frame is never queued behind a new one
            return

    def close(self) -> None:
        """See Port."""
        os.close(self._file)

    def describe(self) -> str:
        """See Port."""
        return self._name


def opened(url: str) -> Port:
    """The open port of an address. AddressError: it is not one, or cannot be opened."""
    return parsed(url)()


def parsed(url: str) -> Callable[[], Port]:
    """How to open an address. AddressError: it is not one."""
    expected = "expected udpin://HOST:PORT, udpout://HOST:PORT or serial:///dev/NAME:BAUD"
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise AddressError(f"{url!r} has no port between 1 and 65535; {expected}") from None
    if parts.scheme == "serial":
        device, _, baud = (parts.netloc + parts.path).rpartition(":")
        if not device.startswith("/dev/") or not baud.isdigit():
            raise AddressError(f"{url!r} names no device and baud rate; {expected}")
        return lambda: SerialPort(device, int(baud))
    if parts.scheme not in ("udpin", "udpout") or parts.path.strip("/"):
        raise AddressError(f"{url!r} is no address; {expected}")
    if not host or port is None:
        raise AddressError(f"{url!r} names no host and port; {expected}")
    try:
        found = socket.gethostbyname(host)
    except OSError:
        raise AddressError(f"{url!r}: the host {host} is not known") from None
    return lambda: UdpPort(found, port, listen=parts.scheme == "udpin")
