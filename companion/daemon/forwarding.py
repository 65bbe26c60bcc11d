"""The vehicle's link for others: ground stations and programs at UDP endpoints share it through the daemon.

A process of its own has the endpoints' sockets, see ``endpoints``: no thread of the daemon ever hears an endpoint. The
control thread hands over the frames of some turns in one datagram, and takes a few frames from there; it waits for
nobody. An endpoint's messages go to the vehicle unchanged and are never read by our pilot: a mode that one of them asks
for is seen as the vehicle's answer to its operator.
"""

from __future__ import annotations

import contextlib
import json
import math
import socket
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

from companion.daemon.address import address_of
from companion.daemon.port import AddressError
from companion.mavlink.codec import MAGIC_V1, MAGIC_V2

EXPECTED = "expected udpout://HOST:PORT[?max_hz=HZ][&commands=yes|no]"
PERIOD = 0.0075
"""s between two exchanges, right after a setpoint: after each one where PX4 is asked for states at 125 Hz. Engineering
choice: few calls, and no ground station notices."""
PERIOD_WITHOUT_STATES = 0.03
"""s between two where no setpoint was sent. Engineering choice: longer than states are apart in a flight."""
BUFFER = 1 << 20
"""bytes that wait for the endpoints' process at most, if the system permits; what comes then is dropped. Seconds of a
busy link. Engineering choice."""
UP_AT_ONCE = 4
"""Frames that the control thread sends on in one exchange. Engineering choice: 500 a second."""
WORDS_MAX = 8192
"""bytes of what the endpoints' process sends at once: a frame, or its last words of 120 bytes an endpoint."""
MODULE = "companion.daemon.endpoints"


@dataclass(frozen=True)
class Endpoint:
    """Where to. ``max_hz``: of each repeating message, None: all. ``commands``: whether it may send to the vehicle."""

    host: str
    port: int
    max_hz: float | None
    commands: bool

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def parse_endpoint(url: str) -> Endpoint:
    """The endpoint of an address. AddressError: it is none."""
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
        asked = parse_qs(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query))
    except ValueError:
        raise AddressError(f"{url!r} is no endpoint; {EXPECTED}") from None
    unknown = set(asked) - {"max_hz", "commands"}
    more = parts.path.strip("/") or parts.fragment or unknown
    if parts.scheme != "udpout" or not host or not port or more:
        raise AddressError(f"{url!r} is no endpoint; {EXPECTED}")
    address = address_of(host, url)
    commands = asked.get("commands", ["yes" if address.startswith("127.") else "no"])[-1]
    if commands not in ("yes", "no"):
        raise AddressError(f"{url!r}: commands={commands}; expected yes or no")
    try:
        rate = float(asked["max_hz"][-1]) if "max_hz" in asked else None
    except ValueError:
        rate = 0.0
    if rate is not None and not 0.1 <= rate <= 1000.0:
        raise AddressError(f"{url!r}: max_hz; expected a number between 0.1 and 1000")
    return Endpoint(address, port, rate, commands == "yes")


class Forwarder:
    """The control thread's end of the endpoints' process. ``give`` takes frames, the vehicle's and ours; ``note`` a
    line for people. Nothing here waits, except ``close``."""

    def __init__(self, endpoints: Sequence[Endpoint], note: Callable[[str], None]) -> None:
        self._frames: list[bytes] = []
        self.give = self._frames.extend
        self._note = note
        self._exchanged_at = -math.inf
        self._dropped = 0
        self._words: list[str] | None = None
        with contextlib.ExitStack() as handed_over:
            ends = [handed_over.enter_context(_connect(endpoint)) for endpoint in endpoints]
            self._local, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            handed_over.enter_context(theirs)
            self._local.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
            self._local.setblocking(False)
            about = [[end.fileno(), str(to), to.max_hz, to.commands] for end, to in zip(ends, endpoints, strict=True)]
            # a session of its own: what is typed at our terminal is not for it
            self._process = subprocess.Popen(
                [sys.executable, "-m", MODULE, json.dumps([theirs.fileno(), about])],
                pass_fds=[theirs.fileno(), *(end.fileno() for end in ends)],
                start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip

    @property
    def pid(self) -> int:
        """Of the endpoints' process."""
        return self._process.pid

    def exchange(self, now: float, *, answered: bool) -> list[bytes]:
        """Hand over what was given, where that is due at ``now`` s; a few frames of the endpoints for the vehicle.
        ``answered``: a state was, just now, and the next one is a period away."""
        if now - self._exchanged_at < (PERIOD if answered else PERIOD_WITHOUT_STATES):
            return []
        self._exchanged_at = now
        frames = self._frames
        if frames and self._words is None:
            try:
                self._local.send(b"".join(frames))
            except ConnectionError:  # nobody there, which is found below
                pass
            except OSError:  # no room
                self._dropped += len(frames)
        frames.clear()
        return self._upward() if self._words is None else []

    def _upward(self) -> list[bytes]:
        found: list[bytes] = []
        try:
            while len(found) < UP_AT_ONCE:
                said = self._local.recv(WORDS_MAX)
                if said[:1] not in FRAMES:
                    self._end(said)
                    break
                found.append(said)
        except BlockingIOError:
            pass
        except OSError:
            self._end(b"")
        return found

    def _end(self, said: bytes) -> None:
        """The process is gone, or says why it goes: once, and the flight goes on."""
        first, *self._words = said.decode(errors="replace").split("\n")
        self._note(
            first or "forwarding has ended: its process is gone; endpoints hear nothing more, the flight goes on"
        )

    def close(self, patience: float) -> list[str]:
        """End the process, within ``patience`` s: in words, what became of each endpoint."""
        with contextlib.suppress(OSError):
            self._local.shutdown(socket.SHUT_WR)
            self._local.settimeout(patience)
            while self._words is None:
                said = self._local.recv(WORDS_MAX)
                if said[:1] not in FRAMES:
                    self._words = said.decode(errors="replace").split("\n") if said else []
        self._local.close()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        words = ["forwarding did not say what became of its endpoints"] if self._words is None else self._words
        if self._dropped:
            words.append(f"forwarding was held up: {self._dropped} messages reached no endpoint")
        return words


FRAMES = (bytes([MAGIC_V1]), bytes([MAGIC_V2]))
"""How a frame begins; all else that comes from the endpoints' process is text."""


def _connect(endpoint: Endpoint) -> socket.socket:
    """A socket that hears this endpoint only."""
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        made.connect((endpoint.host, endpoint.port))
    except OSError as error:
        made.close()
        raise AddressError(f"{endpoint} cannot be reached: {error.strerror}") from None
    return made
