"""What those who look on cost the flight: p99 of state to setpoint: python -m bench.shared [s] [rounds]

    watched    the daemon flying circle_r5 on rates, while `companion watch` serves 4 viewers
    flooded    the same beside a program that floods a socket nobody reads (2000 datagrams/s)
    forwarded  the same with --forward to three endpoints: one reads, one never reads, one floods (2000 datagrams/s)

In turns of half a second they do it, and are stopped: `watch` and the viewers, whoever floods, the process that has
the endpoints. So both halves are of one flight, whatever else the machine does. Measured at the vehicle, from the
state's send to the setpoint's arrival; `without` is the half in which they are stopped. Targets: p99 at most 5 % more
with them, `companion watch` below 10 % of a core, every message of the vehicle at the endpoint that reads.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from bench.latency import BY_RATES, ROOT, Client, Meter, free_port, running
from bench.soak import children
from bench.watch_page import cpu_seconds
from companion.daemon.address import RECEIVE_BUFFER
from companion.daemon.realtime import PRIORITY, at_priority
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message

VIEWERS, FLOOD_RATE = 4, 2000.0
TURN, SETTLED = 0.5, 0.1
"""s of each half, and of it that do not count: what was held up meanwhile is caught up with."""
STARTING, HANDING_BACK = 12.0, 6.0
"""s until the path is followed, and until the companion has ended."""
TARGET, CORE_TARGET = 1.05, 0.10
SEE = "http://127.0.0.1:{port}/words"


def is_on(now: float) -> bool:
    """Whether they do it at a time (s) of the computer's monotonic clock."""
    return int(now / TURN) % 2 == 0


class PairedMeter(Meter):
    """The vehicle; ``beside`` are the processes that are stopped in every other turn, once the path is followed."""

    def __init__(self, client: Client, port: int, beside: Callable[[], list[int]], seconds: float) -> None:
        super().__init__(client, port)
        self.found_with: list[float] = []
        self.found_without: list[float] = []
        self._beside, self._stopped = beside, list[int]()
        self._from = time.monotonic() + STARTING
        self._until = self._from + seconds

    @property
    def _counts(self) -> bool:
        return self._from < time.monotonic() < self._until

    def disturb(self) -> float:
        """See Meter."""
        now = time.monotonic()
        stop = self._counts and not is_on(now)
        if stop and not self._stopped:
            self._stopped = self._beside()
            _signal(self._stopped, signal.SIGSTOP)
        elif not stop and self._stopped:
            _signal(self._stopped, signal.SIGCONT)
            self._stopped = []
        return TURN - now % TURN + 1e-3

    def _answered(self, data: bytes, arrived: int) -> None:
        before = len(self.found)
        super()._answered(data, arrived)
        now = time.monotonic()
        if len(self.found) > before and self._counts and now % TURN > SETTLED:
            (self.found_with if is_on(now) else self.found_without).append(self.found[-1])


def _signal(processes: list[int], number: signal.Signals) -> None:
    for pid in processes:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)


def stations(*ports: int) -> None:
    """Three endpoints: the first reads, the second does not, the third floods whoever forwards to it."""
    ends = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in ports]
    for end, port in zip(ends, ports, strict=True):
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        end.bind(("127.0.0.1", port))
    reads, _, floods = ends
    reads.setblocking(False)
    _, peer = floods.recvfrom(65535)
    heard = 0

    def tell(*_: object) -> None:
        print(f"forwarded to 127.0.0.1:{ports[0]}, as it counts: {heard} messages")
        sys.exit()

    signal.signal(signal.SIGTERM, tell)
    for _ in flood(floods, peer):
        with contextlib.suppress(OSError):
            while True:
                reads.recv(65535)
                heard += 1


def flood(end: socket.socket, peer: tuple[str, int]) -> Iterator[None]:
    """FLOOD_RATE datagrams a second to ``peer`` in every other turn, a hundredth of them a step."""
    frame = Encoder(255, 190).message(message("COMMAND_LONG"), command=512, param1=148.0, target_system=1)
    due = time.monotonic()
    while True:
        due += 0.01
        for _ in range(round(0.01 * FLOOD_RATE) if is_on(time.monotonic()) else 0):
            with contextlib.suppress(OSError):
                end.sendto(frame, peer)
        yield
        time.sleep(max(0.0, due - time.monotonic()))


def flooder() -> None:
    """Floods a socket that nobody reads."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as at,
    ):
        at.bind(("127.0.0.1", 0))
        for _ in flood(end, at.getsockname()):
            pass


async def _view(port: int) -> None:
    from aiohttp import ClientError, ClientSession

    async with ClientSession() as session:
        while True:
            with contextlib.suppress(ClientError, OSError):
                async with session.get(SEE.format(port=port), timeout=None) as answer:
                    async for _ in answer.content:
                        pass
            await asyncio.sleep(0.2)


async def _views(port: int) -> None:
    await asyncio.gather(*(_view(port) for _ in range(VIEWERS)))


@contextlib.contextmanager
def _beside(kind: str, ports: list[int], output: Path) -> Iterator[list[int]]:
    """Whoever looks on, while a round is measured; those of them that can be stopped, `companion watch` first."""
    helper = [sys.executable, "-m", "bench.shared", kind, *map(str, ports)]
    stoppable = []
    with contextlib.ExitStack() as stack:
        if kind == "viewers":
            words = [sys.executable, "-m", "companion", "watch", "--listen", f"127.0.0.1:{ports[0]}"]
            stoppable.append(stack.enter_context(running(words, output)))
        pid = stack.enter_context(running(helper, output))
        if kind == "viewers":
            stoppable.append(pid)
        time.sleep(1.0)
        yield stoppable


@contextlib.contextmanager
def _punctual() -> Iterator[None]:
    """The vehicle before everybody; whoever was started before this runs as it would anywhere."""
    at_priority(PRIORITY + 5)
    try:
        yield
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _client(name: str, folder: Path, ports: list[int]) -> Client:
    mission = folder / "mission.yaml"
    mission.write_text((ROOT / "configs/missions/circle_r5.yaml").read_text() + "origin: local\n")
    shared = [word for port in ports for word in ("--forward", f"udpout://127.0.0.1:{port}")]
    return Client(name, lambda port, where: [
        sys.executable, "-m", "companion", "fly", str(mission), "--vehicle", "x500", "--output", "rates",
        "--set-parameters", "--no-report", "--connect", f"udpin://127.0.0.1:{port}",
        "--record", str(where / f"flight-{port}"), *shared,
    ], BY_RATES, direct=False)  # fmt: skip


def _round(client: Client, kind: str, ports: list[int], folder: Path, seconds: float) -> tuple[PairedMeter, float]:
    """One flight; the share of a core that `companion watch` took, where it ran."""
    output, port = folder / "said.txt", free_port()
    with (
        _beside(kind, ports, output) as stoppable,
        running(client.command(port, folder), output) as flown,
        _punctual(),
    ):
        meter = PairedMeter(client, port, lambda: stoppable or children(flown), seconds)
        spent = cpu_seconds(stoppable[0]) if stoppable else 0.0
        # the vehicle is there until it was handed back: only then is it said what was forwarded
        ending = threading.Timer(STARTING + seconds, os.kill, (flown, signal.SIGTERM))
        ending.start()
        meter.run(sys.maxsize, STARTING + seconds + HANDING_BACK)
        taken = cpu_seconds(stoppable[0]) - spent if stoppable else 0.0
    return meter, taken / (STARTING + 0.5 * seconds + HANDING_BACK)  # it was stopped half of the time


def main() -> None:
    """Measure and print the table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 40.0
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    cases = {"watched": "viewers", "flooded": "flooder", "forwarded": "stations"}
    found: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in cases}
    share = 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["XDG_RUNTIME_DIR"] = name
        for _ in range(rounds):
            for case, kind in cases.items():
                ports = [free_port() for _ in range({"viewers": 1, "flooder": 0, "stations": 3}[kind])]
                client = _client(case, folder, ports if kind == "stations" else [])
                meter, taken = _round(client, kind, ports, folder, seconds)
                share = max(share, taken)
                for to, some in zip(found[case], (meter.found_without, meter.found_with), strict=True):
                    to.extend(some)
        told = (folder / "said.txt").read_text()
    if any(not some for pair in found.values() for some in pair):
        print(told[-3000:])
    print("\n".join(line for line in told.splitlines() if "forwarded to" in line))
    print(f"{'':10} {'answers':>8}   without: p50 us      p99   with: p50      p99   ratio: p50   p99")
    held = share < CORE_TARGET
    for case, (without, with_them) in found.items():
        a, b = np.percentile(without, [50, 99]), np.percentile(with_them, [50, 99])
        ratio = b / a
        held = held and bool(ratio[1] <= TARGET)
        row = f"{case:10} {len(without):8} {a[0]:16.0f} {a[1]:8.0f} {b[0]:11.0f} {b[1]:8.0f}"
        print(f"{row} {ratio[0]:12.2f} {ratio[1]:5.2f}")
    print(f"watch: {100.0 * share:.1f} % of a core with {VIEWERS} viewers")
    print(f"targets {TARGET:g} and {100.0 * CORE_TARGET:g} % of a core: {'held' if held else 'MISSED'}")
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    what = sys.argv[1:2]
    if what == ["stations"]:
        stations(*map(int, sys.argv[2:]))
    elif what == ["flooder"]:
        flooder()
    elif what == ["viewers"]:
        asyncio.run(_views(int(sys.argv[2])))
    else:
        main()
