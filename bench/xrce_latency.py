"""State in to motor datagram out: over XRCE beside over MAVLink; and what PX4's XRCE traffic costs of a core.

    python -m bench.xrce_latency [s a round] [rounds]

One vehicle as in bench.latency, and the daemon flying circle_r5 on motors, in turn over each, at PX4's 125 states a
second. XRCE's answer is known by
its timestamp_sample. The cost: what the daemon's process takes a second beyond what it takes over MAVLink, and, in this
process and without sockets, the stand-in's own traffic taken in.
"""

from __future__ import annotations

import contextlib
import os
import select
import socket
import struct
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from bench.latency import PERIOD, SO_TIMESTAMPNS, WARM_UP, Client, Meter, companion_in, free_port, running
from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.realtime import PRIORITY, at_priority
from companion.law.gains import Level
from companion.library.simulation import start_of
from companion.vehicle import OutputLevel
from companion.world import World
from companion.xrce.commands import Commands
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.world_events import XRCE

TARGET_RATIO, TARGET_SHARE = 1.1, 0.05
MESSAGES = 370.0
"""a second, as PX4 publishes them (measured on main of March 2026)."""
PX4_STATES = 125.0
"""a second: PX4 sends ODOMETRY as often as its estimator predicts, whatever is asked for, and a tick at every other
state costs more than at each. So the vehicle on MAVLink is asked for as many."""
COST_OVER = 20.0
"""s of traffic that is taken in for its cost."""


def vehicle(*, xrce: bool) -> Bridge:
    """The plant in a hover on the path. Its client connects without waiting for the clock."""
    start = start_of(load_mission("circle_r5", Level.MOTORS))
    bridge = Bridge(
        load_vehicle("x500"), World(), direct=not xrce, start=start, endpoints=1, xrce=Release.MAIN if xrce else None
    )
    if xrce:
        bridge.autopilot.parameters["UXRCE_DDS_SYNCT"] = 0
    return bridge


class PairedMeter(Meter):
    """A meter whose vehicle has an XRCE client that speaks to ``agent``'s port, where one is given; the answers come
    there then. ``busy``: shares of a core that the daemon's process took while it was measured."""

    def __init__(self, client: Client, port: int, agent: int | None) -> None:
        super().__init__(client, port)
        self.bridge = vehicle(xrce=agent is not None)
        self.busy = 0.0
        self._agent = ("127.0.0.1", agent or 0)
        self._client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._client.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self._client.setblocking(False)
        self._client.bind(("127.0.0.1", 0))

    def measure(self, process: int, seconds: float) -> None:
        """Until the daemon has answered for so long."""
        enough, time_out = WARM_UP + round(seconds / PERIOD), 2.0 * seconds + 20.0
        begun = due = time.monotonic()
        warm: tuple[float, float] | None = None
        while len(self.found) < enough and due - begun < time_out:
            if warm is None and len(self.found) >= WARM_UP:
                warm = time.monotonic(), cpu_of(process)
            due = max(due + PERIOD, time.monotonic() - 0.1)
            while (left := due - time.monotonic()) > 0.0:
                ready, _, _ = select.select([self._client, self._socket], (), (), left)
                if self._client in ready:
                    self._take()
                if self._socket in ready:
                    self._receive()
            self.bridge.step()
            self._say()
        if warm is not None:
            self.busy = (cpu_of(process) - warm[1]) / (time.monotonic() - warm[0])
        self._socket.close()
        self._client.close()

    def _say(self) -> None:
        for endpoint, datagram in self.bridge.datagrams():
            if endpoint != XRCE:
                self._send(datagram)
                continue
            with contextlib.suppress(OSError):
                self._client.sendto(datagram, self._agent)

    def _take(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                data, ((_, _, stamp),), _, _ = self._client.recvmsg(2048, 64)
                seconds, nanoseconds = struct.unpack("@qq", stamp)
                sample = state_of(data)
                sent = None if sample is None else self.sent.pop(sample, None)
                if sent is not None:
                    self.found.append((seconds * 1_000_000_000 + nanoseconds - sent) * 1e-3)
                self.bridge.receive(data, XRCE)
                self._say()


def state_of(data: bytes) -> int | None:
    """us, the stamp of the state that a command was made of: mode and motors in one message (xrce.md, section 4)."""
    is_command = len(data) > 100 and data[1] == 1 and data[4] == data[28] == 9 and data[30] == 0x48
    return int.from_bytes(data[44:52], "little") if is_command else None


def cpu_of(process: int) -> float:
    """s of a core that a process has taken so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def cost() -> tuple[float, float]:
    """us a message to take the stand-in's traffic in, and its messages a second."""
    bridge, commands = vehicle(xrce=True), Commands(OutputLevel.MOTORS)
    bridge.autopilot.offboard_flown = True  # time passes
    messages, spent = 0, 0.0
    while bridge.now < COST_OVER:
        bridge.step()
        said = [data for endpoint, data in bridge.datagrams() if endpoint == XRCE]
        while said:
            begun = time.perf_counter()
            for data in said:
                commands.receive(data, bridge.now)
            answers = commands.datagrams(bridge.now)
            spent += time.perf_counter() - begun
            messages += len(said)
            for data in answers:
                bridge.receive(data, XRCE)
            said = [data for endpoint, data in bridge.datagrams() if endpoint == XRCE]
    return 1e6 * spent / messages, messages / COST_OVER


def clients(directory: Path) -> tuple[Client, Callable[[int], Client]]:
    """The daemon over MAVLink, and over XRCE at a port."""
    companion, direct = companion_in(directory, f"motors: direct\nstate_rate_hz: {PX4_STATES:g}")

    def over_xrce(agent: int) -> Client:
        url = f"udp://127.0.0.1:{agent}"
        options = ("motors", "--xrce", url, "--accept-direct-motors", "--no-report")
        return Client("XRCE", companion("x500", *options), direct=False)

    return Client("MAVLink", companion(direct, "motors", "--no-report")), over_xrce


def main() -> None:
    """Measure and print."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    at_priority(PRIORITY + 5)
    delays: dict[str, list[float]] = {"MAVLink": [], "XRCE": []}
    busy: dict[str, list[float]] = {which: [] for which in delays}
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        mavlink, over_xrce = clients(directory)
        for _ in range(rounds):
            for which in delays:
                port, agent = free_port(), free_port() if which == "XRCE" else None
                client = mavlink if agent is None else over_xrce(agent)
                meter = PairedMeter(client, port, agent)
                with running(client.command(port, directory), directory / "said.txt") as process:
                    meter.measure(process, seconds)
                busy[which].append(meter.busy)
                delays[which] += meter.found[WARM_UP:]
        if not all(delays.values()):
            sys.exit((directory / "said.txt").read_text()[-3000:])
    p50 = {which: float(np.median(found)) for which, found in delays.items()}
    for which, found in delays.items():
        print(f"{which:8} {len(found):6} answers, p50 {p50[which]:.0f} us, p99 {np.percentile(found, 99):.0f} us")
    ratio = p50["XRCE"] / p50["MAVLink"]
    each, rate = cost()
    share = 1e-6 * each * MESSAGES
    more = float(np.mean(busy["XRCE"]) - np.mean(busy["MAVLink"]))
    print(f"p50 over XRCE {ratio:.2f} times that over MAVLink (target {TARGET_RATIO:g})")
    print(
        f"{each:.1f} us a message ({rate:.0f} a second here): {100 * share:.2f} % of a core at {MESSAGES:.0f} a second"
    )
    print(f"the daemon took {100 * more:.1f} % of a core more over XRCE, sockets and commands included")
    held = ratio <= TARGET_RATIO and max(share, more) <= TARGET_SHARE
    print("targets held" if held else "targets MISSED")
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
