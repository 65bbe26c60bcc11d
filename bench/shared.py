"""What those who look on cost the flight: p99 of state to setpoint: python -m bench.shared [s a round] [rounds]

    alone      the daemon flying circle_r5 on rates, as bench.latency measures it
    watched    the same while `companion watch` serves 4 viewers
    flooded    the same beside a program that floods a socket nobody reads (2000 datagrams/s)
    forwarded  the same with --forward to three endpoints: one reads, one never reads, one floods (2000 datagrams/s)

Rounds take turns, so that what else the machine does falls on all alike. Of each: from the state's send to the
setpoint's arrival at the vehicle, and in brackets the daemon's own part of it by its record, from the state's arrival
to the return of the setpoint's send. Who floods costs the computer something even where nobody hears him: forwarded
is compared with that. Targets: p99 at most 5 % more (watched than alone, forwarded than flooded); `companion watch`
below 10 % of a core. To be run with nothing else on the machine.
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
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bench.latency import BY_RATES, ROOT, WARM_UP, Client, Meter, free_port, running
from bench.watch_page import cpu_seconds
from companion.daemon.realtime import PRIORITY, at_priority
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.record.table import load_table

VIEWERS, FLOOD_RATE = 4, 2000.0
STARTING, HANDING_BACK = 12.0, 6.0
"""s until the path is followed, and until the companion has ended."""
TARGET, CORE_TARGET = 1.05, 0.10
SEE = "http://127.0.0.1:{port}/words"


def stations(*ports: int) -> None:
    """Three endpoints: the first reads, the second does not, the third floods whoever forwards to it."""
    ends = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in ports]
    for end, port in zip(ends, ports, strict=True):
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
    """FLOOD_RATE datagrams a second to ``peer``, a hundredth of them a step."""
    frame = Encoder(255, 190).message(message("COMMAND_LONG"), command=512, param1=148.0, target_system=1)
    due = time.monotonic()
    while True:
        due += 0.01
        for _ in range(round(0.01 * FLOOD_RATE)):
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
def _beside(kind: str, ports: list[int], output: Path) -> Iterator[int | None]:
    """Whoever looks on, while a round is measured; the process number of `companion watch`, where that does."""
    helper = [sys.executable, "-m", "bench.shared", kind, *map(str, ports)]
    watch = None
    with contextlib.ExitStack() as stack:
        if kind == "viewers":
            words = [sys.executable, "-m", "companion", "watch", "--listen", f"127.0.0.1:{ports[0]}"]
            watch = stack.enter_context(running(words, output))
        if kind != "nobody":
            stack.enter_context(running(helper, output))
            time.sleep(1.0)
        yield watch


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


def _own_part(flight: Path) -> list[float]:
    """us from the arrival of each state to the return of its setpoint's send, by the daemon's record."""
    latency = load_table(flight / "flight.npy")["latency"]
    found: list[float] = (1e6 * latency[np.isfinite(latency)][WARM_UP:]).tolist()
    return found


def main() -> None:
    """Measure and print the table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    with tempfile.TemporaryDirectory() as name:
        folder, output = Path(name), Path(name) / "said.txt"
        os.environ["XDG_RUNTIME_DIR"] = name
        ends = [free_port() for _ in range(3)]
        cases = [
            ("alone", "nobody", []), ("watched", "viewers", [free_port()]), ("flooded", "flooder", []),
            ("forwarded", "stations", ends),
        ]  # fmt: skip
        own: list[list[float]] = [[] for _ in cases]
        clients = [_client(case, folder, ports if kind == "stations" else []) for case, kind, ports in cases]
        shares = []
        for _ in range(rounds):
            for client, (_, kind, ports), found in zip(clients, cases, own, strict=True):
                meter = Meter(client, port := free_port())
                with (
                    _beside(kind, ports, output) as watch,
                    running(client.command(port, folder), output) as flown,
                    _punctual(),
                ):
                    spent, begun = 0.0 if watch is None else cpu_seconds(watch), time.monotonic()
                    # the vehicle is there until it was handed back: only then is it said what was forwarded
                    ending = threading.Timer(STARTING + seconds, os.kill, (flown, signal.SIGTERM))
                    ending.start()
                    meter.run(sys.maxsize, STARTING + seconds + HANDING_BACK)
                    if watch is not None:
                        shares.append((cpu_seconds(watch) - spent) / (time.monotonic() - begun))
                found += _own_part(folder / f"flight-{port}")
        told = output.read_text()
    if any(not client.delays for client in clients):
        print(told[-3000:])
    print("\n".join(line for line in told.splitlines() if "forwarded to" in line))
    alone, own_alone = clients[0].percentiles, np.percentile(own[0], [50, 99])
    print(f"{'':10} {'answers':>8} {'p50 us':>8} {'p99':>8} {'max':>8}   of alone: p50   p99   (its own part)")
    for client, found in zip(clients, own, strict=True):
        p50, p99, most = client.percentiles
        ratios = f"{p50 / alone[0]:15.2f} {p99 / alone[1]:5.2f}"
        ours = np.percentile(found, [50, 99]) / own_alone
        print(f"{client.name:10} {len(client.delays):8} {p50:8.0f} {p99:8.0f} {most:8.0f} {ratios}   "
              f"({ours[0]:.2f} {ours[1]:.2f})")  # fmt: skip
    print(f"watch: {100.0 * max(shares):.1f} % of a core with {VIEWERS} viewers")
    _, watched, flooded, forwarded = (client.percentiles[1] for client in clients)
    print(f"p99 of watched {watched / alone[1]:.2f} of alone, of forwarded {forwarded / flooded:.2f} of flooded")
    held = max(shares) < CORE_TARGET and watched <= TARGET * alone[1] and forwarded <= TARGET * flooded
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
