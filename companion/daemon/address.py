"""Addresses in MAVSDK's spelling -> a port to read and write.

udpin://HOST:PORT      listen; answer whoever is heard first
udpout://HOST:PORT     call
serial:///dev/NAME:BAUD
"""

from __future__ import annotations

import contextlib
import difflib
import errno
import select
import socket
from collections.abc import Callable
from urllib.parse import urlsplit

from companion.daemon.port import DATAGRAM_MAX, AddressError, Port
from companion.daemon.serial import SerialPort, known_rate
from companion.mavlink.peer import Received, Source, source_words

RECEIVE_BUFFER = 1 << 20
"""bytes. The default holds 256 small datagrams: a quarter of a second of a busy link. Engineering choice."""
BATCH_MAX = 4096
"""Datagrams that are drained before the newest state is acted on: more than the buffer holds after any stall.
Engineering choice."""

EXPECTED = "expected udpin://HOST:PORT, udpout://HOST:PORT or serial:///dev/NAME:BAUD"
"""What an address looks like."""


class UdpPort:
    """A UDP socket. Whom it hears and talks to is decided by ``mavlink.peer``."""

    stream = False

    def __init__(self, host: str, port: int, *, listen: bool) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.called: Source | None = None if listen else (host, port)
        self.exposed = _is_exposed(host)
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

    def fileno(self) -> int:
        """See Port."""
        return self._socket.fileno()

    def receive(self, timeout: float) -> list[Received]:
        """See Port."""
        batch: list[Received] = []
        receive = self._socket.recvfrom
        try:
            # select waits to the microsecond, a socket's own time-out to the next millisecond
            if timeout > 0.0 and not select.select([self._socket], (), (), timeout)[0]:
                return batch
            while len(batch) < BATCH_MAX:
                batch.append(receive(DATAGRAM_MAX))
        except OSError:  # nothing more, or what an unreachable peer leaves behind
            pass
        return batch

    def send(self, data: bytes, to: Source) -> None:
        """See Port."""
        assert isinstance(to, tuple)  # an address that ``receive`` has given
        with contextlib.suppress(OSError):  # nobody there: UDP may lose it, and the guards see the silence
            self._socket.sendto(data, to)

    def close(self) -> None:
        """See Port."""
        self._socket.close()

    def describe(self) -> str:
        """See Port."""
        local = f"UDP {self.local[0]}:{self.local[1]}"
        return local if self.called is None else f"{local} to {source_words(self.called)}"


def _is_exposed(host: str) -> bool:
    return not host.startswith("127.")


def is_exposed(url: str) -> bool:
    """Whether others than this computer and what is wired to it can send to an address. AddressError: it is none."""
    parse_address(url)
    parts = urlsplit(url)
    return parts.scheme != "serial" and _is_exposed(socket.gethostbyname(parts.hostname or ""))


def open_port(url: str) -> Port:
    """The open port of an address. AddressError: it is not one, or cannot be opened."""
    return parse_address(url)()


def parse_address(url: str) -> Callable[[], Port]:
    """How to open an address. AddressError: it is not one."""
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise AddressError(f"{url!r} has no port between 1 and 65535; {EXPECTED}") from None
    if parts.scheme == "serial":
        device, _, baud = (parts.netloc + parts.path).rpartition(":")
        if not device.startswith("/dev/") or not baud.isdigit():
            raise AddressError(f"{url!r} names no device and baud rate; {EXPECTED}")
        known_rate(int(baud))
        return lambda: SerialPort(device, int(baud))
    if parts.scheme not in ("udpin", "udpout") or parts.path.strip("/") or parts.query or parts.fragment:
        near = difflib.get_close_matches(url.split(":")[0], ("udpin", "udpout", "serial"), 1)
        meant = f" (did you mean {near[0]}://?)" if near and near[0] != parts.scheme else ""
        raise AddressError(f"{url!r} is no address{meant}; {EXPECTED}")
    if not host or not port:
        raise AddressError(f"{url!r} names no host and port; {EXPECTED}")
    found = address_of(host, url)
    return lambda: UdpPort(found, port, listen=parts.scheme == "udpin")


def address_of(host: str, url: str) -> str:
    """The IPv4 address of a host that ``url`` names. AddressError: nobody knows it, or it is no name."""
    try:
        return socket.gethostbyname(host)
    except (OSError, ValueError, TypeError):  # what no name can be: a label too long or empty, a null byte
        raise AddressError(f"{url!r}: the host {host!a} is not known") from None
