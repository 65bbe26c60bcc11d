"""State in to setpoint out, on loopback, with PX4's usual traffic: python bench/latency.py [s a round] [rounds]

One vehicle, the plant with its full onboard streams and the state at 250 Hz, and in turn the clients that answer it:

    C echo         receive, CRC, send, in 50 lines of C (bench/echo.c; compiled now, if there is a compiler)
    Python echo    the same in Python: the measure of what the interpreter and the system cost
    companion      the daemon, as ``companion fly`` runs it, flying circle_r5 on motors; and on rates, which is what PX4
                   flies: there the observer and the prediction come before the law
    MAVSDK asyncio its telemetry -> its offboard setpoint

Measured at the vehicle: from before the send of the state to the kernel's stamp on the arrival of the setpoint that
carries this state's time back. Rounds take turns, so that what else the machine does falls on all alike.
Targets: companion, on motors and on rates, at most 2.5 times (p50) and 2 times (p99) the Python echo.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.daemon.realtime import PRIORITY, at_priority
from companion.law.gains import Level
from companion.library.simulation import start_of
from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import message
from companion.world import World
from sim_bridge.bridge import Bridge

ROOT = Path(__file__).resolve().parent.parent
PERIOD = 0.004
SO_TIMESTAMPNS = 35
WARM_UP = 500
"""answers of each round that do not count: imports, caches, the handshake"""
ODOMETRY, QUATERNION = message("ODOMETRY"), message("ATTITUDE_QUATERNION")
MOTORS, ATTITUDE = message("SET_ACTUATOR_CONTROL_TARGET"), message("SET_ATTITUDE_TARGET")
TARGET_P50, TARGET_P99 = 2.5, 2.0
OURS = "companion"


class Pair(NamedTuple):
    """A message of the state and the setpoint that answers it, each with what tells which state it is of: a function of
    its payload, filled up with zeros."""

    state: int
    key_of: Callable[[bytes], int]
    setpoint: int
    answered: Callable[[bytes], int]


def _microseconds(payload: bytes) -> int:
    (stamp,) = struct.unpack_from("<Q", payload)
    return int(stamp)


def _milliseconds(payload: bytes) -> int:
    (stamp,) = struct.unpack_from("<I", payload)
    return int(stamp)


def _degrees(payload: bytes) -> int:
    (rate,) = struct.unpack_from("<f", payload, 20)
    return round(math.degrees(rate))


BY_MOTORS = Pair(ODOMETRY.id, _microseconds, MOTORS.id, _microseconds)
BY_RATES = Pair(ODOMETRY.id, lambda payload: round(1e-3 * _microseconds(payload)), ATTITUDE.id, _milliseconds)
BY_ROLL_RATE = Pair(QUATERNION.id, lambda payload: _milliseconds(payload) // 4 % 1000, ATTITUDE.id, _degrees)
"""MAVSDK stamps its setpoints by its own clock: see latency_clients."""


@dataclass
class Client:
    """``command``: how it is started, for a port. ``pair``: the message it answers and how. ``direct``: the vehicle
    takes motor commands."""

    name: str
    command: Callable[[int, Path], list[str]]
    pair: Pair = BY_MOTORS
    direct: bool = True
    delays: list[float] = field(default_factory=list)
    states: int = 0

    @property
    def percentiles(self) -> tuple[float, float, float]:
        """us: p50, p99, largest."""
        a, b, c = np.percentile(self.delays, [50, 99, 100]) if self.delays else (float("nan"),) * 3
        return float(a), float(b), float(c)


def vehicle_on_its_way(direct: bool) -> Bridge:
    """The plant in a hover on the path, its state streaming at 250 Hz beside PX4's usual traffic."""
    start = start_of(load_mission("circle_r5", Level.MOTORS))
    bridge = Bridge(load_vehicle("x500"), World(), direct=direct, start=start, endpoints=1)
    ask = Encoder(1, 191)
    for msgid in (ODOMETRY.id, QUATERNION.id):
        bridge.receive(
            ask.message(
                message("COMMAND_LONG"),
                command=511,
                param1=float(msgid),
                param2=1e6 * PERIOD,
                target_system=1,
                target_component=1,
            )
        )
    return bridge


class Meter:
    """The vehicle on its socket, in real time, with a stamp at every state sent and every setpoint that comes."""

    def __init__(self, client: Client, port: int) -> None:
        self.client = client
        self.bridge = vehicle_on_its_way(client.direct)
        self.sent: dict[int, int] = {}
        self.found: list[float] = []
        self.messages = 0
        self._peer = ("127.0.0.1", port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self._socket.setblocking(False)
        self._socket.bind(("127.0.0.1", 0))

    def run(self, enough: int, time_out: float) -> None:
        """Until ``enough`` setpoints were answered, ``time_out`` s at most."""
        begun = due = time.monotonic()
        while len(self.found) < enough and due - begun < time_out:
            due = max(due + PERIOD, time.monotonic() - 0.1)
            while (left := due - time.monotonic()) > 0.0:
                if select.select([self._socket], (), (), min(left, self.disturb()))[0]:
                    self._receive()
            self.bridge.step()
            for _, datagram in self.bridge.datagrams():
                self._send(datagram)
        self._socket.close()
        self.client.delays += self.found[WARM_UP:]
        self.client.states += max(0, len(self.sent) - WARM_UP)

    def disturb(self) -> float:
        """Send what is no part of the flight, where it is due; s until this is to be called again."""
        return math.inf

    def _send(self, datagram: bytes) -> None:
        msgid = datagram[7] | datagram[8] << 8 | datagram[9] << 16
        pair = self.client.pair
        if msgid == pair.state:
            self.sent[pair.key_of(_payload(datagram))] = time.clock_gettime_ns(time.CLOCK_REALTIME)
        self.messages += 1
        with contextlib.suppress(OSError):
            self._socket.sendto(datagram, self._peer)

    def _receive(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                data, ancillary, _, _ = self._socket.recvmsg(512, 64)
                ((_, _, stamp),) = ancillary
                seconds, nanoseconds = struct.unpack("@qq", stamp)
                self._answered(data, seconds * 1_000_000_000 + nanoseconds)
                self.bridge.receive(data)

    def _answered(self, data: bytes, arrived: int) -> None:
        pair = self.client.pair
        if data[7] != pair.setpoint:
            return
        sent = self.sent.pop(pair.answered(_payload(data)), None)
        if sent is not None:
            self.found.append((arrived - sent) * 1e-3)


def _payload(frame: bytes) -> bytes:
    """Of a frame whose trailing zeros were cut off."""
    return frame[10 : 10 + frame[1]].ljust(64, b"\0")


@contextlib.contextmanager
def running(command: list[str], output: Path) -> Iterator[int]:
    """A client while it is measured; its process's id."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))}
    with output.open("ab") as said:
        process = subprocess.Popen(command, stdout=said, stderr=said, env=environment, cwd=output.parent)
    try:
        yield process.pid
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(8.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def free_port() -> int:
    """A UDP port nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def companion_in(
    directory: Path, direct: str = "motors: direct"
) -> tuple[Callable[..., Callable[[int, Path], list[str]]], str]:
    """The daemon on circle_r5 by vehicle, output and further options, as a client's command; and the x500 that takes
    motors over MAVLink, as a file. ``direct``: what its file says in the place of ``motors: px4``."""
    mission, machine = directory / "mission.yaml", directory / "direct.yaml"
    shipped = ROOT / "configs"
    mission.write_text((shipped / "missions" / "circle_r5.yaml").read_text() + "origin: local\n")
    machine.write_text((shipped / "vehicles" / "x500.yaml").read_text().replace("motors: px4", direct))

    def companion(vehicle: str, *output: str) -> Callable[[int, Path], list[str]]:
        return lambda port, folder: [
            sys.executable, "-m", "companion", "fly", str(mission), "--vehicle", vehicle, "--output", *output,
            "--set-parameters", "--connect", f"udpin://127.0.0.1:{port}", "--record", str(folder / f"flight-{port}"),
        ]  # fmt: skip

    return companion, str(machine)


def clients(directory: Path) -> list[Client]:
    """Those this machine can run."""
    python, script = sys.executable, str(ROOT / "bench" / "latency_clients.py")
    companion, direct = companion_in(directory)
    found = [
        Client("Python echo", lambda port, _: [python, script, "echo", str(port)]),
        Client(OURS, companion(direct, "motors")),
        Client(f"{OURS}, rates", companion("x500", "rates"), BY_RATES, direct=False),
        Client("MAVSDK asyncio", lambda port, _: [python, script, "mavsdk", str(port)], BY_ROLL_RATE),
    ]
    compiler = shutil.which("cc")
    if compiler is None:
        print("no C compiler here: the C echo is left out")
        return found
    program = directory / "echo"
    subprocess.run([compiler, "-O2", "-o", str(program), str(ROOT / "bench" / "echo.c")], check=True)
    priority = PRIORITY if _fifo_permitted() else 0
    words = [str(priority), str(ODOMETRY.crc_extra), str(MOTORS.crc_extra)]
    return [Client("C echo", lambda port, _: [str(program), str(port), *words]), *found]


def _fifo_permitted() -> bool:
    return subprocess.run(
        [sys.executable, "-c", "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(50))"],
        capture_output=True, check=False,
    ).returncode == 0  # fmt: skip


def main() -> None:
    """Measure and print the table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    fifo = at_priority(PRIORITY + 5)  # the vehicle is punctual, whoever answers it
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        contenders = clients(directory)
        traffic = 0.0
        for _ in range(rounds):
            for client in contenders:
                meter = Meter(client, port := free_port())
                with running(client.command(port, directory), directory / "said.txt"):
                    meter.run(WARM_UP + round(seconds / PERIOD), 2.0 * seconds + 20.0)
                traffic = max(traffic, meter.messages / meter.bridge.now)
        if any(not client.delays for client in contenders):
            print((directory / "said.txt").read_text()[-3000:])
    priority = "every client under SCHED_FIFO" if fifo else "SCHED_FIFO is not permitted here: normal priority"
    print(f"{rounds} rounds of {seconds:g} s; {traffic:.0f} messages a second; {priority}")
    base = next(client.percentiles for client in contenders if client.name == "Python echo")
    print(f"{'client':16} {'answers':>8} {'p50 us':>8} {'p99':>8} {'max':>8}   of the Python echo: p50   p99")
    for client in contenders:
        p50, p99, largest = client.percentiles
        print(
            f"{client.name:16} {len(client.delays):8} {p50:8.0f} {p99:8.0f} {largest:8.0f} "
            f"{p50 / base[0]:25.2f} {p99 / base[1]:5.2f}"
        )
    missed = [
        client.name
        for client in contenders
        if client.name.startswith(OURS)
        and not (client.percentiles[0] <= TARGET_P50 * base[0] and client.percentiles[1] <= TARGET_P99 * base[1])
    ]
    print(f"targets {TARGET_P50:g} and {TARGET_P99:g}: {'MISSED by ' + '; '.join(missed) if missed else 'held'}")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
