"""Addresses in MAVSDK's spelling -> a port to read and write.

udpin://HOST:PORT      listen; answer whoever is heard first
udpout://HOST:PORT     call
serial:///dev/NAME:BAUD
"""

from __future__ import annotations

import difflib
import errno
import select
import socket
import time
from collections.abc import Callable
from urllib.parse import urlsplit

from companion.daemon.port import AddressError, Port
from companion.daemon.serial import SerialPort, known_rate

RECEIVE_BUFFER = 1 << 20
"""bytes. The default holds 256 small datagrams: a quarter of a second of a busy link."""
DATAGRAM_MAX = 65535
BATCH_MAX = 4096
"""Datagrams that are drained before the newest state is acted on: more than the buffer holds after any stall."""


PEER_SILENT = 2.0
"""s."""
AUTOPILOT_COMPONENT = 1


def is_autopilots_heartbeat(data: bytes) -> bool:
    """Whether a datagram begins with an autopilot's HEARTBEAT, as far as its header says."""
    if len(data) >= 12 and data[0] == 0xFD:
        return data[6] == AUTOPILOT_COMPONENT and data[7:10] == b"\0\0\0"
    return len(data) >= 8 and data[0] == 0xFE and data[4] == AUTOPILOT_COMPONENT and data[5] == 0


class UdpPort:
    """A UDP socket that talks to one peer: the one it calls, or the first autopilot it hears. An autopilot that comes
    from another address is the peer when the first one has been silent for a while: it was started again."""

    stream = False

    def __init__(self, host: str, port: int, *, listen: bool) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._listens = listen
        self._peer: tuple[str, int] | None = None if listen else (host, port)
        self._peer_at = 0.0
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        self._socket.setblocking(False)
        try:
            self._socket.bind((host, port) if listen else ("127.0.0.1" if host.startswith("127.") else "0.0.0.0", 0))
        except OSError as error:
            self._socket.close()
            hint = (
                "; does another companion or a ground station listen there?" if error.errno == errno.EADDRINUSE else ""
            )
            raise AddressError(f"UDP {host}:{port} cannot be opened: {error.strerror}{hint}") from None
        self.local: tuple[str, int] = self._socket.getsockname()

    def receive(self, timeout: float) -> list[bytes]:
        """See Port."""
        batch: list[bytes] = []
        heard = False
        receive = self._socket.recvfrom
        try:
            # select waits to the microsecond, a socket's own time-out to the next millisecond
            if timeout > 0.0 and not select.select([self._socket], (), (), timeout)[0]:
                return batch
            while len(batch) < BATCH_MAX:
                data, address = receive(DATAGRAM_MAX)
                if address == self._peer:
                    heard = True
                elif self._listens:
                    self._met(data, address)
                batch.append(data)
        except OSError:  # nothing more, or what an unreachable peer leaves behind
            pass
        if heard:
            self._peer_at = time.monotonic()
        return batch

    def _met(self, data: bytes, address: tuple[str, int]) -> None:
        """A datagram from somebody who is not the peer. Garbage and ground stations do not become it."""
        now = time.monotonic()
        if is_autopilots_heartbeat(data) and (self._peer is None or now - self._peer_at > PEER_SILENT):
            self._peer, self._peer_at = address, now

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
        known_rate(int(baud))
        return lambda: SerialPort(device, int(baud))
    if parts.scheme not in ("udpin", "udpout") or parts.path.strip("/") or parts.query or parts.fragment:
        near = difflib.get_close_matches(url.split(":")[0], ("udpin", "udpout", "serial"), 1)
        meant = f" (did you mean {near[0]}://?)" if near and near[0] != parts.scheme else ""
        raise AddressError(f"{url!r} is no address{meant}; {expected}")
    if not host or not port:
        raise AddressError(f"{url!r} names no host and port; {expected}")
    try:
        found = socket.gethostbyname(host)
    except OSError:
        raise AddressError(f"{url!r}: the host {host} is not known") from None
    return lambda: UdpPort(found, port, listen=parts.scheme == "udpin")
