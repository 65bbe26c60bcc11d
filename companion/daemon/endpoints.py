"""The process that has the endpoints of ``--forward``; started by ``forwarding``.

It shares nothing with the daemon but a local socket. Down come the frames of some turns in one datagram, up go the
frames that an endpoint may send to the vehicle, one a datagram, and at the end what became of each endpoint, as text.
Nothing here waits for the daemon, nor the daemon for this; when the daemon is gone, however it ended, this ends too.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import socket
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from companion.daemon.port import DATAGRAM_MAX
from companion.mavlink.codec import MAGIC_V2, Decoder
from companion.mavlink.dialect import message
from companion.mavlink.signing import SIGNATURE_SIZE, SIGNED

PERIOD = 0.01
"""s between two looks (engineering choice: what a ground station does not notice). It does not wait for the daemon's
socket: the control thread would have to wake it."""
LAST_WORDS = 1.0
"""s that the daemon may take to hear what became of the endpoints. Engineering choice."""
UP_RATE, UP_BURST = 4000.0, 4000.0
"""bytes/s, and bytes at once, of one endpoint to the vehicle: most of a 57600 baud line (engineering choice)."""
LOCAL_MAX = 1 << 18
"""bytes of the daemon's datagrams at most: more than a local socket takes."""
DATAGRAMS_A_LOOK = 100
"""Of one endpoint: a flood waits in its socket, or is lost there. Engineering choice."""
THINNED = frozenset(message(name).id for name in (
    "GPS_RAW_INT", "ATTITUDE", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "RC_CHANNELS",
    "VFR_HUD", "ATTITUDE_TARGET", "POSITION_TARGET_LOCAL_NED", "HIGHRES_IMU", "SCALED_IMU2", "ALTITUDE",
    "BATTERY_STATUS", "ESTIMATOR_STATUS", "VIBRATION", "HOME_POSITION", "ODOMETRY", "UTM_GLOBAL_POSITION",
    "DISTANCE_SENSOR", "SERVO_OUTPUT_RAW",
))  # fmt: skip
"""Messages that repeat (attitude, position, sensors, targets, ...) and that ``max_hz`` thins; all others pass."""
SETPOINTS = frozenset(message(name).id for name in (
    "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_ACTUATOR_CONTROL_TARGET", "ACTUATOR_CONTROL_TARGET",
))  # fmt: skip
"""A second source of setpoints is refused; ours are not for endpoints to see."""


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
    """One endpoint's socket, and what became of its frames. ``max_hz``: of each repeating message, None: all.
    ``commands``: whether it may send to the vehicle."""

    name: str
    socket: socket.socket
    max_hz: float | None
    commands: bool
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
        rate = self.max_hz
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
        try:
            for _ in range(DATAGRAMS_A_LOOK):
                data = self.socket.recv(DATAGRAM_MAX)
                if self.commands:
                    self._decoder.datagram(data)
                else:
                    self.refused += 1
        except ConnectionRefusedError:  # nobody heard what was sent last
            self.sent, self.unsent = self.sent - 1, self.unsent + 1
        except OSError:  # that was all
            pass
        passed = []
        for frame in self.frames:
            if message_of(frame) not in SETPOINTS and self.budget.spend(len(frame), now):
                passed.append(frame)
            else:
                self.refused += 1
        self.frames.clear()
        self.taken += len(passed)
        return passed

    @property
    def sentence(self) -> str:
        """What became of it."""
        return (
            f"forwarded to {self.name}: {self.sent} messages, {self.unsent} lost; from it: {self.taken} passed on, "
            f"{self.refused} refused"
        )


def message_of(frame: bytes) -> int:
    """A whole frame's message id."""
    return frame[7] | frame[8] << 8 | frame[9] << 16 if frame[0] == MAGIC_V2 else frame[5]


def split(joined: bytes) -> Iterator[bytes]:
    """Whole frames, one behind another."""
    at = 0
    while at < len(joined):
        end = at + joined[at + 1] + 8
        if joined[at] == MAGIC_V2:
            end += 4 + (SIGNATURE_SIZE if joined[at + 2] & SIGNED else 0)
        yield joined[at:end]
        at = end


class Exchange:
    """The daemon at the other end of ``local``, which never blocks, and the endpoints of ``lines``."""

    def __init__(self, local: socket.socket, lines: Sequence[Line]) -> None:
        self.lines = lines
        self._local = local

    def look(self, now: float) -> bool:
        """Pass on what is there. False: the daemon has nothing more to say, or is gone."""
        there = self._down(now)
        for line in self.lines:
            for frame in line.take(now):
                try:
                    self._local.send(frame)
                except OSError:  # no room; or the daemon is gone, which the next look finds
                    line.taken -= 1
                    line.refused += 1
        return there

    def _down(self, now: float) -> bool:
        try:
            while joined := self._local.recv(LOCAL_MAX):
                for frame in split(joined):
                    if message_of(frame) not in SETPOINTS:
                        for line in self.lines:
                            line.give(frame, now)
        except BlockingIOError:
            return True
        except ConnectionError:
            pass
        return False

    def close(self, words: Sequence[str]) -> None:
        """Tell the daemon ``words`` and what became of each endpoint, if it still listens."""
        self._local.settimeout(LAST_WORDS)
        with contextlib.suppress(OSError):
            self._local.send("\n".join([*words, *(line.sentence for line in self.lines)]).encode())


def be_ordinary() -> None:
    """At ordinary priority on any processor, however the daemon runs. It ends when that does, and not at a signal."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.setpriority(os.PRIO_PROCESS, 0, max(0, os.getpriority(os.PRIO_PROCESS, 0)))
        os.sched_setaffinity(0, range(os.cpu_count() or 1))


def _socket(number: int) -> socket.socket:
    """One that was handed over; it never blocks."""
    handed_over = socket.socket(fileno=number)
    handed_over.setblocking(False)
    return handed_over


def main() -> None:
    """Serve the sockets that were handed over, until the daemon is gone or says that it was all."""
    be_ordinary()
    local, ends = json.loads(sys.argv[1])
    lines = [Line(name, _socket(number), rate, commands) for number, name, rate, commands in ends]
    exchange = Exchange(_socket(local), lines)
    words = []
    try:
        while exchange.look(time.monotonic()):
            select.select((), (), (), PERIOD)
    except Exception as error:  # none of the flight's business
        words.append(f"forwarding failed ({type(error).__name__}: {error}); the flight goes on")
    exchange.close(words)


if __name__ == "__main__":
    main()
