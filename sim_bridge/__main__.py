"""The command ``sim-bridge``: a vehicle on UDP, in real time."""

from __future__ import annotations

import contextlib
import enum
import signal
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Annotated, NamedTuple

import typer

from companion.config.signing_key import read_key
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.vehicle import load_vehicle
from companion.config.world.world import home_from, load_world, start_from
from companion.plain_text import printable, printable_lines
from companion.vehicle import CompanionError, Vehicle
from companion.world import Start, World
from sim_bridge.autopilot.logger.logger import Logger
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.server import (
    COMPANION,
    GROUND_STATION,
    XRCE_AGENT,
    Address,
    Endpoint,
    EndpointError,
    Server,
    address_of,
    endpoint_of,
)
from sim_bridge.truth_file import TruthFile


class Motors(enum.Enum):
    """Who mixes."""

    DIRECT = "direct"


def say(line: str) -> None:
    """A line for the person at the terminal."""
    with contextlib.suppress(OSError, ValueError):  # a terminal that is gone does not take the vehicle out of the air
        print(printable(f"sim-bridge: {line}"), file=sys.stderr, flush=True)


def fly(
    vehicle: Annotated[str, typer.Option(help="A name in configs/vehicles, or a vehicle file.")] = "x500",
    world: Annotated[str, typer.Option(help="A name in configs/worlds, or a world file.")] = "ideal",
    connect: Annotated[
        str | None,
        typer.Option(help="The companion: udpin://HOST:PORT or udpout://HOST:PORT; default as PX4, 14580 to 14540."),
    ] = None,
    ground_station: Annotated[
        str | None, typer.Option(help="The ground station likewise, or none; default as PX4, 18570 to 14550.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of every chance in the world.")] = 0,
    speed: Annotated[float, typer.Option(min=0.01, max=100.0, help="Plant seconds a second.")] = 1.0,
    motors: Annotated[
        Motors | None, typer.Option(help="direct: SET_ACTUATOR_CONTROL_TARGET carries motor commands.")
    ] = None,
    landed: Annotated[
        bool, typer.Option("--landed/--hover", help="Start on the ground at the origin, or in a hover 10 m above it.")
    ] = True,
    start: Annotated[
        str | None,
        typer.Option(help='Start in the air: JSON {"position_n": [..], "velocity_n", "q_nb", "rates_b", "held"}.'),
    ] = None,
    home: Annotated[
        str | None,
        typer.Option(help="Where the local frame's origin lies: LATITUDE,LONGITUDE,METRES above sea level."),
    ] = None,
    signing_key: Annotated[
        Path | None, typer.Option(help="It has this key from the start and signs; else a companion may give it one.")
    ] = None,
    xrce: Annotated[bool, typer.Option("--xrce", help="It has PX4's XRCE client too (uxrce_dds_client).")] = False,
    xrce_agent: Annotated[
        str | None, typer.Option(help="Where that calls, HOST:PORT; default as PX4, 127.0.0.1:8888. Implies --xrce.")
    ] = None,
    xrce_release: Annotated[
        Release, typer.Option(help="Whose topics it takes and gives, in which versions of their messages.")
    ] = Release.MAIN,
    truth: Annotated[Path | None, typer.Option(help="Write the true state of every step to this .npy file.")] = None,
) -> None:
    """A quadrotor made of software that speaks MAVLink as PX4 does. Ctrl-C ends it."""
    with contextlib.ExitStack() as stack:
        try:
            inputs = _inputs(vehicle, world, connect, ground_station, start, home, signing_key, xrce_agent)
            release = xrce_release if xrce or xrce_agent is not None else None
            bridge, server = _prepare(stack, inputs, seed, speed, motors, landed, release, truth)
        except (CompanionError, ValueError, OSError) as error:
            print(printable_lines(str(error)), file=sys.stderr)
            raise typer.Exit(2) from None
        number = _run_until_a_signal(server)
    for name, counters in zip(("companion", "ground station"), bridge.counters, strict=False):
        say(
            f"{name}: {counters.frames} messages, {counters.bad_crc} damaged, {counters.garbage_bytes} bytes of garbage"
        )
    raise typer.Exit(130 if number == signal.SIGINT else 0)


class Inputs(NamedTuple):
    """What the files and options say."""

    vehicle: Vehicle
    world: World
    start: Start | None
    endpoints: list[Endpoint]
    key: bytes | None
    agent: Address


def _inputs(
    vehicle: str, world: str, connect: str | None, ground_station: str | None, start: str | None, home: str | None,
    signing_key: Path | None, xrce_agent: str | None,
) -> Inputs:  # fmt: skip
    """Read everything. ConfigError with the faults of all of it."""
    faults: list[Fault] = []
    machine = surroundings = begins = key = None
    endpoints = [COMPANION, GROUND_STATION]
    with _collecting(faults):
        machine = load_vehicle(vehicle)
    with _collecting(faults):
        surroundings = load_world(world)
    with _collecting(faults):
        begins = None if start is None else start_from(parse(start, "--start"))
        if surroundings is not None and home is not None:
            surroundings = replace(surroundings, home=home_from(home, "--home"))
    with _collecting(faults):
        key = None if signing_key is None else read_key(signing_key)
    with _collecting(faults, "--connect"):
        if connect is not None:
            endpoints[0] = endpoint_of(connect)
    with _collecting(faults, "--ground-station"):
        if ground_station == "none":
            endpoints.pop()
        elif ground_station is not None:
            endpoints[1] = endpoint_of(ground_station)
    agent = XRCE_AGENT
    with _collecting(faults, "--xrce-agent"):
        if xrce_agent is not None:
            agent = address_of(xrce_agent)
    if machine is None or surroundings is None or faults:
        raise ConfigError(faults)
    return Inputs(machine, surroundings, begins, endpoints, key, agent)


def _prepare(
    stack: contextlib.ExitStack, inputs: Inputs, seed: int, speed: float, motors: Motors | None, landed: bool,
    release: Release | None, truth: Path | None,
) -> tuple[Bridge, Server]:  # fmt: skip
    """The bridge and its server, the sockets and the truth file open until ``stack`` is left."""
    vehicle, world, start, endpoints, key, agent = inputs
    bridge = Bridge(
        vehicle, world, seed=seed, direct=motors is Motors.DIRECT, start=start, landed=landed and start is None,
        endpoints=len(endpoints), key=key, xrce=release,
    )  # fmt: skip
    if speed > 1.0:
        bridge.autopilot.parameters.hurry(speed)
    record = None if truth is None else stack.enter_context(TruthFile(truth))
    log = Logger(bridge.autopilot)

    def after_step() -> None:
        log.step()
        if record is not None:
            record.append(bridge.truth, bridge.autopilot.commands)

    mixing = "motor commands taken" if bridge.direct else "motors mixed as in PX4"
    say(f"{vehicle.name} in {world.name}, {round(1.0 / bridge.step_s)} steps a second, {mixing}")
    server = Server(bridge, endpoints, agent=agent, speed=speed, log=say, after_step=after_step)
    stack.callback(server.close)
    return bridge, server


def _run_until_a_signal(server: Server) -> int:
    """Run the server; the signal that ended it."""
    received: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    server.run(lambda: bool(received))
    return received[0]


@contextlib.contextmanager
def _collecting(faults: list[Fault], option: str = "") -> Iterator[None]:
    """Keep the faults of one input, so that those of all are shown at once."""
    try:
        yield
    except ConfigError as error:
        faults.extend(error.faults)
    except EndpointError as error:
        faults.append(Fault(option, 0, "", str(error)))


def main() -> None:
    """The console entry point."""
    typer.run(fly)


if __name__ == "__main__":
    main()
