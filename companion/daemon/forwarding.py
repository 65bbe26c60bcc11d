"""The vehicle's link for others: ground stations and programs at UDP endpoints share it through the daemon.

A thread of its own has the endpoints' sockets. The control thread only leaves frames in a bounded queue and takes a few
from another after its setpoint is on its way; it waits for nobody. An endpoint's messages go to the vehicle unchanged
and are never read by our pilot: a mode that one of them asks for is seen as the vehicle's answer to its operator.
"""

from __future__ import annotations

import contextlib
import socket
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from urllib.parse import parse_qs, urlsplit

from companion.daemon.address import DATAGRAM_MAX, address_of
from companion.daemon.port import AddressError
from companion.daemon.scribe import Helper
from companion.mavlink.codec import MAGIC_V2, Decoder
from companion.mavlink.dialect import message

EXPECTED = "expected udpout://HOST:PORT[?max_hz=HZ][&commands=yes|no]"
PERIOD = 0.01
"""s between two looks of the thread (engineering choice: what a ground station does not notice)."""
DOWN_MAX = 2000
"""Frames of the vehicle that wait for the endpoints at most; the oldest is dropped. Engineering choice."""
UP_MAX = 200
"""Frames of the endpoints that wait for the vehicle at most; what comes then is dropped. Engineering choice."""
UP_RATE, UP_BURST = 4000.0, 4000.0
"""bytes/s, and bytes at once, of one endpoint to the vehicle: most of a 57600 baud line (engineering choice)."""
UP_A_TURN = 2
"""Frames that the control thread sends on after a setpoint. Engineering choice."""
DATAGRAMS_A_LOOK = 100
"""Of one endpoint: a flood waits in its socket, or is lost there. Engineering choice."""
THINNED = frozenset(message(name).id for name in (
    "GPS_RAW_INT", "ATTITUDE", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "RC_CHANNELS",
    "VFR_HUD", "ATTITUDE_TARGET", "POSITION_TARGET_LOCAL_NED", "HIGHRES_IMU", "SCALED_IMU2", "ALTITUDE",
    "BATTERY_STATUS", "ESTIMATOR_STATUS", "VIBRATION", "HOME_POSITION", "ODOMETRY", "UTM_GLOBAL_POSITION",
))  # fmt: skip
"""Messages that repeat (attitude, position, sensors, targets, ...) and that ``max_hz`` thins; all others pass."""
SETPOINTS = frozenset(message(name).id for name in (
    "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_ACTUATOR_CONTROL_TARGET", "ACTUATOR_CONTROL_TARGET",
))  # fmt: skip
"""A second source of setpoints is refused."""


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


@dataclass
class Budget:
    """Bytes that may be sent: ``rate`` a second, ``burst`` at once."""

    rate: float = UP_RATE
    burst: float = UP_BURST
    left: float = UP_BURST
    at: float = 0.0

    def spend(self, size: int, now: float) -> bool:
        """Whether ``size`` bytes may go at ``now`` s; then they are spent."""
        self.left = min(self.burst, self.left + self.rate * max(0.0, now - self.at))
        self.at = now
        if size > self.left:
            return False
        self.left -= size
        return True


@dataclass
class Line:
    """One endpoint's socket, and what became of its frames."""

    endpoint: Endpoint
    socket: socket.socket
    frames: list[bytes] = field(default_factory=list)
    budget: Budget = field(default_factory=Budget)
    sent: int = 0
    unsent: int = 0
    taken: int = 0
    refused: int = 0
    _decoder: Decoder = field(init=False)
    _last: dict[bytes, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._decoder = Decoder(wanted=(), tap=self.frames.append)

    def give(self, frame: bytes, now: float) -> None:
        """Send one frame of the vehicle, unless it comes too soon after the one before. Never waits."""
        rate = self.endpoint.max_hz
        if rate is not None and message_of(frame) in THINNED:
            who = frame[5:10] if frame[0] == MAGIC_V2 else frame[3:6]
            if now - self._last.get(who, -1.0) < 0.95 / rate:
                return
            self._last[who] = now
        try:
            self.socket.send(frame)
            self.sent += 1
        except OSError:  # nobody there, or no room
            self.unsent += 1

    def take(self, now: float) -> list[bytes]:
        """The frames that came and may go on to the vehicle."""
        with contextlib.suppress(OSError):
            for _ in range(DATAGRAMS_A_LOOK):
                data = self.socket.recv(DATAGRAM_MAX)
                if self.endpoint.commands:
                    self._decoder.datagram(data)
                else:
                    self.refused += 1
        passed = []
        for frame in self.frames:
            if message_of(frame) not in SETPOINTS and self.budget.spend(len(frame), now):
                passed.append(frame)
            else:
                self.refused += 1
        self.frames.clear()
        self.taken += len(passed)
        return passed


def message_of(frame: bytes) -> int:
    """A whole frame's message id."""
    return frame[7] | frame[8] << 8 | frame[9] << 16 if frame[0] == MAGIC_V2 else frame[5]


class Forwarder(Helper):
    """The thread. ``give`` and ``upward`` are the control thread's; neither waits."""

    period = PERIOD

    def __init__(self, endpoints: Sequence[Endpoint], lines: deque[str], clock: Callable[[], float]) -> None:
        super().__init__("forwarding", lines, clock)
        self.ends = [Line(endpoint, _connect(endpoint)) for endpoint in endpoints]
        self._down: deque[bytes] = deque(maxlen=DOWN_MAX)
        self._up: deque[bytes] = deque()

    def give(self, frame: bytes) -> None:
        """Take one frame, the vehicle's or ours, for the endpoints."""
        self._down.append(frame)

    def upward(self) -> list[bytes]:
        """A few frames of the endpoints for the vehicle."""
        return [self._up.popleft() for _ in range(min(UP_A_TURN, len(self._up)))]

    def work(self, now: float) -> None:
        """See Helper."""
        for _ in range(len(self._down)):
            frame = self._down.popleft()
            if message_of(frame) not in SETPOINTS:  # ours are the vehicle's business
                for end in self.ends:
                    end.give(frame, now)
        for end in self.ends:
            for frame in end.take(now):
                if len(self._up) < UP_MAX:
                    self._up.append(frame)
                else:
                    end.refused += 1

    def close(self) -> list[str]:
        """Close the sockets: in words, what became of each endpoint."""
        for end in self.ends:
            end.socket.close()
        return [
            f"forwarded to {end.endpoint}: {end.sent} messages, {end.unsent} lost; from it: {end.taken} passed on, "
            f"{end.refused} refused"
            for end in self.ends
        ]


def _connect(endpoint: Endpoint) -> socket.socket:
    """A socket that hears this endpoint only."""
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.setblocking(False)
    try:
        made.connect((endpoint.host, endpoint.port))
    except OSError as error:
        made.close()
        raise AddressError(f"{endpoint} cannot be reached: {error.strerror}") from None
    return made
