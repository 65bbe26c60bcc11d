"""Damaged datagrams while it flies: python -m bench.fuzz_link [datagrams] [s a round]

The vehicle of bench/latency.py, flown at motors and at rates, in rounds that take turns: a calm link, and one that
brings RATE damaged datagrams a second beside the vehicle's messages. One half comes from its own address (what
was said last, damaged: bits turned, bytes lost, start bytes put in, the end cut off), the other from a stranger's (the
same, intact now and then, and bytes made to cost time). DATAGRAMS in all for each output; seeded.
Target: the 99th percentile of state to setpoint at most doubled, and every round flown to its end.
"""

from __future__ import annotations

import random
import socket
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

from bench.latency import (
    OURS,
    PERIOD,
    WARM_UP,
    Client,
    Meter,
    at_priority,
    clients,
    free_port,
    running,
)
from companion.daemon.realtime import PRIORITY
from trials.damaged_datagrams import mutated

DATAGRAMS = 100_000
RATE = 1400.0
"""Hz."""
TARGET = 2.0
INTACT = 0.1
"""The share of a stranger's datagrams that are whole messages."""
FLOODS = (b"\xfe" * 1400, b"\xfd\xff\x00\x01\x00" * 280, b"\xfe\x09\xfe\xfe\xfe" * 280)
FLOOD = 0.05
"""The share of a stranger's datagrams that are one of FLOODS."""


class Disturbed(Meter):
    """The vehicle, with damaged datagrams between its own."""

    def __init__(self, client: Client, port: int, rng: random.Random) -> None:
        super().__init__(client, port)
        self.damaged = 0
        self._rng = rng
        self._said: deque[bytes] = deque(maxlen=50)
        self._to = ("127.0.0.1", port)
        self._stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._due = time.monotonic()

    def _send(self, datagram: bytes) -> None:
        self._said.append(datagram)
        super()._send(datagram)

    def disturb(self) -> float:
        """See Meter."""
        now = time.monotonic()
        rng = self._rng
        while self._due <= now and self._said and self.found:
            self._due = max(self._due, now - PERIOD) + rng.expovariate(RATE)
            frame = rng.choice(self._said)
            self.damaged += 1
            if rng.random() < 0.5:
                self._socket.sendto(mutated(frame, rng), self._to)
            else:
                kind = rng.random()
                strange = frame if kind < INTACT else rng.choice(FLOODS) if kind > 1.0 - FLOOD else mutated(frame, rng)
                self._stranger.sendto(strange, self._to)
        return max(self._due - now, 1e-4)


def measure(client: Client, directory: Path, meter: Callable[[int], Meter], seconds: float) -> Meter:
    """One round."""
    made = meter(port := free_port())
    with running(client.command(port, directory), directory / "said.txt"):
        made.run(WARM_UP + round(seconds / PERIOD), 2.0 * seconds + 20.0)
    return made


def main() -> None:
    """Measure and print the table."""
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else DATAGRAMS
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
    at_priority(PRIORITY + 5)
    rng = random.Random(2026)
    missed = []
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        for client in clients(directory):
            if not client.name.startswith(OURS):
                continue
            calm = Client(client.name, client.command, client.pair, client.direct)
            dirty = Client(client.name, client.command, client.pair, client.direct)
            damaged, rounds = 0, 0
            while damaged < wanted and rounds < 3 * wanted / (RATE * seconds) + 3:
                measure(calm, directory, lambda port, to=calm: Meter(to, port), seconds)  # type: ignore[misc]
                made = measure(
                    dirty,
                    directory,
                    lambda port, to=dirty: Disturbed(to, port, rng),
                    seconds,  # type: ignore[misc]
                )
                assert isinstance(made, Disturbed)
                damaged += made.damaged
                rounds += 1
            a, b = calm.percentiles, dirty.percentiles
            print(
                f"{client.name:18} {damaged} damaged datagrams in {rounds} rounds; state to setpoint p50 {a[0]:.0f} -> "
                f"{b[0]:.0f} us, p99 {a[1]:.0f} -> {b[1]:.0f} us ({b[1] / a[1]:.2f}), max {a[2]:.0f} -> {b[2]:.0f} us"
            )
            if not b[1] <= TARGET * a[1] or damaged < wanted:
                missed.append(client.name)
        if missed:
            print((directory / "said.txt").read_text()[-3000:])
    print(f"target {TARGET:g}: {'MISSED by ' + '; '.join(missed) if missed else 'held'}")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
