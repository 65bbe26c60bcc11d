"""The bridge in real time: UDP sockets and the clock.

One thread. Between two steps it waits on the sockets, and a datagram is dealt with when it comes, not at the next step.
Steps are due at fixed times. After a late one the next follow more quickly, but never at more than twice the pace, so
that whoever controls the vehicle still has time to answer each; and when the machine cannot keep up, the plant's time
slips behind the wall's. It never runs ahead.
"""

from __future__ import annotations

import gc
import select
import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit

from companion.vehicle import CompanionError
from sim_bridge.bridge import Bridge
from sim_bridge.strangers import FIRST_STRANGER
from sim_bridge.world_events import XRCE

Address = tuple[str, int]

SLIP_BEYOND = 0.1
"""s behind from which the plant's time slips instead of being caught up."""
RECEIVE_BUFFER = 1 << 20
"""bytes the kernel keeps while the plant computes."""
DATAGRAM_MAX = 65535
"""bytes: the most UDP carries."""
LOOPBACK = "127.0.0.1"


class EndpointError(CompanionError):
    """An endpoint that cannot be used: what is wrong, what was expected."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Where the plant listens, and whom it talks to before anybody has been heard. The first one heard is the peer."""

    bind: Address
    peer: Address | None


COMPANION = Endpoint((LOOPBACK, 14580), (LOOPBACK, 14540))
"""As PX4's simulation: from 14580 to 14540."""
GROUND_STATION = Endpoint((LOOPBACK, 18570), (LOOPBACK, 14550))
"""As PX4's simulation: from 18570 to 14550."""
XRCE_AGENT: Address = (LOOPBACK, 8888)
"""Where PX4's XRCE client calls by default (UXRCE_DDS_AG_IP, UXRCE_DDS_PRT)."""


def endpoint_of(url: str) -> Endpoint:
    """The endpoint of ``udpin://HOST:PORT`` or ``udpout://HOST:PORT``. EndpointError: it is neither."""
    expected = "expected udpin://HOST:PORT or udpout://HOST:PORT"
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise EndpointError(f"{url!r} has no port between 1 and 65535; {expected}") from None
    if parts.scheme not in ("udpin", "udpout"):
        raise EndpointError(f"{url!r} is no connection the plant can make; {expected}")
    if not host or not port or parts.path.strip("/") or parts.query:
        raise EndpointError(f"{url!r} names no host and port; {expected}")
    try:
        host = socket.gethostbyname(host)
    except (OSError, ValueError, TypeError):  # what no name can be: a label too long or empty, a null byte
        raise EndpointError(f"{url!r}: the host is not known; {expected}") from None
    if parts.scheme == "udpin":
        return Endpoint((host, port), None)
    return Endpoint((LOOPBACK if host.startswith("127.") else "0.0.0.0", 0), (host, port))


def address_of(text: str) -> Address:
    """The address ``HOST:PORT``. EndpointError: it is none."""
    try:
        peer = endpoint_of(f"udpout://{text}").peer
    except EndpointError:
        peer = None
    if peer is None:
        raise EndpointError(f"{text!r} is no address of an agent; expected HOST:PORT, such as 127.0.0.1:8888")
    return peer


class Server:
    """Runs a bridge on sockets, one an endpoint. EndpointError: a port is taken; ValueError: not as many as it has.

    ``agent``: where the bridge's XRCE client calls, if it has one. ``speed``: plant seconds a second. ``after_step`` is
    called after each step. ``log`` takes lines for a person.
    """

    def __init__(
        self,
        bridge: Bridge,
        endpoints: Sequence[Endpoint],
        *,
        agent: Address = XRCE_AGENT,
        speed: float = 1.0,
        log: Callable[[str], None],
        after_step: Callable[[], None] | None = None,
    ) -> None:
        if len(endpoints) != len(bridge.links):
            raise ValueError(f"{len(endpoints)} endpoints for a bridge with {len(bridge.links)}")
        self._bridge = bridge
        self._period = bridge.step_s / speed
        self._log = log
        self._after_step = after_step
        self._sockets: list[socket.socket] = []
        self._strangers: dict[int, socket.socket] = {}
        self._dialled = 0
        self._peers = [endpoint.peer for endpoint in endpoints]
        self._heard = [False] * len(endpoints)
        self._speed = speed
        self._said_slow = 0.0
        self._agent = agent
        self._xrce: list[socket.socket] = []  # none or one
        for endpoint in endpoints:
            try:
                self._sockets.append(_bind(endpoint.bind))
            except OSError as error:
                self.close()
                host, port = endpoint.bind
                raise EndpointError(f"UDP port {port} on {host} cannot be opened: {error.strerror}") from None
        for name, bound, endpoint in zip(("companion", "ground station"), self._sockets, endpoints, strict=False):
            to = "whoever calls" if endpoint.peer is None else "{}:{}".format(*endpoint.peer)
            log(f"{name}: from {':'.join(map(str, bound.getsockname()))} to {to}")
        if bridge.xrce is not None:
            self._xrce.append(_bind((LOOPBACK if agent[0].startswith("127.") else "0.0.0.0", 0)))
            log("XRCE client: to {}:{}".format(*agent))

    @property
    def local(self) -> Address:
        """From where the vehicle speaks to the companion now."""
        host, port = self._sockets[0].getsockname()
        return host, port

    def run(self, stopped: Callable[[], bool]) -> None:
        """Step until ``stopped()`` says so."""
        gc.collect()
        gc.freeze()  # what has been imported need never be looked at again, in the middle of a step
        begun, begun_at = time.monotonic(), self._bridge.now
        due = earliest = begun
        while not stopped():
            due += self._period
            self._wait(max(due, earliest))
            now = time.monotonic()
            if now - due > SLIP_BEYOND:
                due = now
                if now - self._said_slow > 5.0:
                    self._said_slow = now
                    self._log(f"{self._timing(begun, begun_at)}; the machine is busy")
            earliest = now + 0.5 * self._period
            self._bridge.step()
            if self._bridge.ports_dialled != self._dialled:
                self._dial()
            self._send()
            if self._after_step is not None:
                self._after_step()
            if self._bridge.log:
                self._report()
        self._log(self._timing(begun, begun_at))

    def close(self) -> None:
        """Close the sockets."""
        for each in (*self._sockets, *self._xrce, *self._strangers.values()):
            each.close()

    def _wait(self, due: float) -> None:
        """Receive until ``due``, at least once."""
        left = due - time.monotonic()
        while True:
            ready, _, _ = select.select((*self._sockets, *self._xrce), (), (), max(0.0, left))
            for each in ready:
                self._receive(XRCE if each in self._xrce else self._sockets.index(each))
            left = due - time.monotonic()
            if left <= 0.0:
                return

    def _receive(self, endpoint: int) -> None:
        try:
            datagram, address = self._socket(endpoint).recvfrom(DATAGRAM_MAX)
        except OSError:  # what an unreachable peer leaves behind
            return
        if (
            endpoint != XRCE and not self._heard[endpoint]
        ):  # as in PX4, the first one to call is the partner from then on
            self._heard[endpoint] = True
            if self._peers[endpoint] != address:
                self._peers[endpoint] = address
            self._log(f"{self._bridge.now:.2f} s: heard from {address[0]}:{address[1]}")
        self._bridge.receive(datagram, endpoint)
        self._send()

    def _send(self) -> None:
        for endpoint, datagram in self._bridge.datagrams():
            is_stranger = endpoint >= FIRST_STRANGER
            peer = self._agent if endpoint == XRCE else self._peers[0 if is_stranger else endpoint]
            if peer is not None:
                try:
                    (self._stranger(endpoint) if is_stranger else self._socket(endpoint)).sendto(datagram, peer)
                except OSError:  # nobody there, or the buffer is full: UDP may lose it
                    continue

    def _socket(self, endpoint: int) -> socket.socket:
        return self._xrce[0] if endpoint == XRCE else self._sockets[endpoint]

    def _stranger(self, endpoint: int) -> socket.socket:
        """The socket of a stranger with a port of his own."""
        if endpoint not in self._strangers:
            self._strangers[endpoint] = _bind((self._sockets[0].getsockname()[0], 0))
        return self._strangers[endpoint]

    def _dial(self) -> None:
        """Another port to the companion."""
        self._dialled = self._bridge.ports_dialled
        host = self._sockets[0].getsockname()[0]
        self._sockets[0].close()
        self._sockets[0] = _bind((host, 0))
        self._log(f"{self._bridge.now:.2f} s: companion: from {host}:{self._sockets[0].getsockname()[1]} now")

    def _timing(self, begun: float, begun_at: float) -> str:
        """How fast the plant has really run since the clock was ``begun`` and the bridge's time ``begun_at``, s."""
        passed, took = self._bridge.now - begun_at, max(1e-6, time.monotonic() - begun)
        line = f"{self._bridge.now:.2f} s: {passed:.2f} s of plant time in {took:.2f} s, {passed / took:.3g} times"
        return f"{line} real time of {self._speed:g} asked for"

    def _report(self) -> None:
        for line in self._bridge.log:
            self._log(f"{self._bridge.now:.2f} s: {line}")
        self._bridge.log.clear()


def _bind(address: Address) -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        made.setblocking(False)
        made.bind(address)
    except OSError:
        made.close()
        raise
    return made
