"""The command line: names, options, exit codes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from companion.cli import file_commands, look_commands, vehicle_commands
from companion.cli.options import (
    Connect,
    Duration,
    Json,
    MissionName,
    OutputName,
    Record,
    Report,
    Settle,
    SigningKey,
    VehicleName,
)
from companion.cli.output import Ends, LawOutput, Output, WhoStarts
from companion.cli.terminal import open_standard_streams, say
from companion.plain_text import printable
from companion.vehicle import CompanionError

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Fly a path, not a timetable: path following for PX4 quadrotors.",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"companion {version('companion')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", "-V", callback=_print_version, is_eager=True, help="Print it and exit.")
    ] = False,
) -> None:
    """What every command takes."""


@app.command()
def check(
    mission: MissionName,
    vehicle: VehicleName = None,
    json: Json = False,
    plot: Annotated[Path | None, typer.Option("--plot", help="A picture of the path: .png, .svg or .pdf.")] = None,
) -> None:
    """Say whether a vehicle can fly a mission, how fast at most, and where it is tight. Nothing is flown."""
    from companion.cli.check import check as look

    raise typer.Exit(look(mission, vehicle, as_json=json, plot=plot))


@app.command()
def sim(
    mission: MissionName,
    vehicle: VehicleName = None,
    output: OutputName = Output.AUTO,
    world: Annotated[str, typer.Option(help="A name in configs/worlds, or a world file.")] = "ideal",
    seed: Annotated[int, typer.Option(help="Of every chance in the world.")] = 0,
    from_ground: Annotated[bool, typer.Option("--from-ground", help="Arm and take off first; land after.")] = False,
    duration: Duration = None,
    settle: Settle = 10.0,
    udp: Annotated[bool, typer.Option("--udp", help="Two processes over UDP in real time, not lockstep.")] = False,
    record: Record = None,
    report: Report = True,
    json: Json = False,
) -> None:
    """Fly a mission in simulation."""
    from companion.cli.check import looked_at
    from companion.cli.finish import Ending
    from companion.cli.orders import Faults, check_record, read_sortie, read_world
    from companion.cli.simulate import Simulation, in_lockstep, over_udp
    from companion.cli.terminal import say
    from companion.feasibility.words import headline
    from companion.record.folder import new_directory

    faults = Faults()
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, output, direct=True))
    simulated = faults.collect(lambda: read_world(world, seed))
    faults.collect(lambda: check_record(record))
    faults.raise_any()
    assert sortie is not None and simulated is not None
    sortie, found = looked_at(sortie)
    if not found.feasible:
        say(f"warning: {headline(found)}")
    simulation = Simulation(
        sortie=sortie,
        simulated=simulated,
        from_ground=from_ground,
        duration=duration,
        directory=record or new_directory(sortie.mission.name),
        ending=Ending(json, settle, report),
    )
    raise typer.Exit((over_udp if udp else in_lockstep)(simulation))


@app.command()
def fly(
    mission: MissionName,
    connect: Connect,
    vehicle: VehicleName = None,
    output: OutputName = Output.AUTO,
    set_parameters: Annotated[
        bool, typer.Option("--set-parameters", help="Set what rates need (COM_OF_LOSS_T) and set it back afterwards.")
    ] = False,
    start: Annotated[
        WhoStarts | None,
        typer.Option(
            "--start", help="Who arms and selects OFFBOARD. [default: pilot on a serial line, else companion]"
        ),
    ] = None,
    finish: Annotated[
        Ends | None, typer.Option("--finish", help="What follows the path. [default: land if it began on the ground]")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Do everything but arm and command.")] = False,
    bench: Annotated[
        bool, typer.Option("--bench", help="Propellers off: tilt it by hand, and see the commands point back.")
    ] = False,
    tube: Annotated[float, typer.Option(min=0.5, help="m from the path at which the vehicle is handed back.")] = 5.0,
    floor: Annotated[
        float | None, typer.Option(help="m above home that are kept. [default: 1, or less for a low path]")
    ] = None,
    ceiling: Annotated[float | None, typer.Option(help="m above home that are not exceeded.")] = None,
    draw: Annotated[
        bool, typer.Option("--draw", help="Upload the curve as mission items: it shows on the ground station's map.")
    ] = False,
    duration: Duration = None,
    settle: Settle = 10.0,
    record: Record = None,
    report: Report = True,
    accept_infeasible: Annotated[
        bool, typer.Option("--accept-infeasible", help="Fly even what `check` says this vehicle cannot.")
    ] = False,
    signing_key: SigningKey = None,
    json: Json = False,
) -> None:
    """Fly a mission on a vehicle. Ctrl-C hands it back."""
    from companion.cli.check import looked_at
    from companion.cli.finish import Ending, refuse
    from companion.cli.flying import Flight, authority_of, most_speed_scale
    from companion.cli.flying import fly as fly_now
    from companion.cli.orders import Faults, check_record, read_sortie
    from companion.cli.terminal import say
    from companion.config.signing_key import read_key
    from companion.daemon.address import parsed
    from companion.feasibility.words import headline
    from companion.flight.conduct import Conduct, Finish, Limits
    from companion.record.folder import new_directory

    faults = Faults()
    open_port = faults.collect(lambda: parsed(connect))
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, output))
    faults.collect(lambda: check_record(record))
    key = None if signing_key is None else faults.collect(lambda: read_key(signing_key))
    faults.raise_any()
    assert sortie is not None and open_port is not None
    sortie, found = looked_at(sortie)
    if not found.feasible:
        if not accept_infeasible and not found.may_be_flown:
            raise typer.Exit(refuse(f"{headline(found)} (--accept-infeasible flies it all the same)", json))
        say(f"warning: {headline(found)}")
    if dry_run and bench:
        raise CompanionError("--dry-run and --bench exclude each other; expected one of them")
    conduct = Conduct(
        authority=authority_of(start, dry_run=dry_run, bench=bench, serial=connect.startswith("serial:")),
        finish=Finish.AS_BEGUN if finish is None else Finish(finish.value),
        limits=Limits(tube=tube, floor=floor, ceiling=ceiling),
        speed_scale_max=most_speed_scale(found.speed_scale_max),
    )
    directory = record or new_directory(sortie.mission.name)
    ending = Ending(json, settle, report)
    flight = Flight(sortie, directory, duration, ending, set_parameters, conduct, draw, accept_infeasible, key)
    raise typer.Exit(fly_now(flight, open_port()))


@app.command()
def demo(
    fast: Annotated[bool, typer.Option("--fast", help="In lockstep: as fast as the machine computes.")] = False,
    plain: Annotated[bool, typer.Option("--plain", help="The undisturbed circle, begun on the path.")] = False,
    output: OutputName = Output.MOTORS,
    record: Record = None,
    json: Json = False,
) -> None:
    """Fly the paper's circle (r 10 m, 3 m/s) on an x500: begun off the path, held still once and let go; and write the
    report. Plant and daemon are two processes on this computer."""
    from companion.cli.demo import demo as show

    raise typer.Exit(show(fast=fast, plain=plain, output=output, record=record, as_json=json))


@app.command()
def law(
    mission: MissionName,
    vehicle: VehicleName = None,
    output: Annotated[LawOutput, typer.Option("--output", help="The level of the law.")] = LawOutput.MOTORS,
) -> None:
    """The law without a vehicle: states as JSON lines on stdin, xi, b, D and the inputs as JSON lines on stdout."""
    from companion.cli.bare import answers
    from companion.cli.orders import read_bare
    from companion.law.gains import Level

    level = Level.MOTORS if output is LawOutput.MOTORS else Level.RATES
    read = read_bare(mission, vehicle, level)
    answers(*read, level, sys.stdin, sys.stdout)


@app.command("report")
def report_command(directory: Annotated[Path, typer.Argument(metavar="DIR", help="A flight folder.")]) -> None:
    """Write the figures and tables of a recorded flight again."""
    from companion.record.report import write_report

    print(printable(str(write_report(directory))))


@app.command()
def replay(directory: Annotated[Path, typer.Argument(metavar="DIR", help="A flight folder.")]) -> None:
    """Feed a flight's recorded inputs through the pilot again: the same setpoints, bit for bit."""
    from companion.record.replay import load_flight
    from companion.record.replay import replay as again

    flight = load_flight(directory)
    for cut in flight.cuts:
        say(f"note: {cut}")
    replayed = again(flight)
    if replayed.difference is not None:
        print(f"differs at {replayed.difference}")
        raise typer.Exit(1)
    print(f"{replayed.ticks} ticks, {replayed.setpoints} setpoints: the same, bit for bit")


look_commands.register(app)
file_commands.register(app)
vehicle_commands.register(app)


def main() -> None:
    """The console entry point."""
    open_standard_streams()
    try:
        app()
    except CompanionError as error:
        say(str(error))
        sys.exit(2)
    except BrokenPipeError:
        sys.exit(1)
    except KeyboardInterrupt:  # before or after a flight: while one goes on, the flight itself is asked to end
        sys.exit(130)
