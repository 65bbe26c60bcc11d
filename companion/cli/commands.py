"""The command line: names, options, exit codes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli import file_commands, look_commands, record_commands, study_commands, vehicle_commands
from companion.cli.options import (
    AcceptDirectMotors,
    AcceptInfeasible,
    Bench,
    Ceiling,
    Connect,
    Draw,
    DryRun,
    Duration,
    FetchLog,
    Finishes,
    Floor,
    Forward,
    HomePlace,
    Json,
    MissionName,
    ModeName,
    OutputName,
    Quiet,
    Record,
    Report,
    SetParameters,
    Settle,
    SigningKey,
    SimulatedDuration,
    Starts,
    Tube,
    VehicleName,
    Verbose,
    WorldName,
    Xrce,
    complete_world,
)
from companion.cli.output import Output
from companion.cli.terminal import be_normal, detail, open_standard_streams, warn
from companion.geodesy import NO_HOME_GIVEN
from companion.library.faults import Faults
from companion.vehicle import CompanionError
from companion.version import __version__

if TYPE_CHECKING:
    from companion.feasibility.report import Report as FeasibilityReport
    from companion.library.orders import Sortie

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Fly a path, not a timetable: path following for PX4 quadrotors.",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"companion {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option("--version", "-V", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """What every command takes."""
    be_normal()


@app.command()
def check(
    mission: MissionName,
    vehicle: VehicleName = None,
    output: OutputName = Output.AUTO,
    world: Annotated[
        str | None,
        typer.Option(
            "--world",
            metavar="NAME",
            help="Look at it in the wind of this world, with twice its gusts, and with its true machine.",
            show_default="still air, as the vehicle file says",
            autocompletion=complete_world,
        ),
    ] = None,
    json: Json = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the path into a .png, .svg or .pdf.")
    ] = None,
    home: HomePlace = None,
) -> None:
    """Say whether a vehicle can fly a mission, how fast at most, and where it is tight. Nothing is flown."""
    from companion.cli.check import check as look

    raise typer.Exit(look(mission, vehicle, output, world, as_json=json, plot=plot, home=home))


@app.command()
def sim(
    mission: MissionName,
    vehicle: VehicleName = None,
    output: OutputName = Output.AUTO,
    world: WorldName = "ideal",
    seed: Annotated[int, typer.Option(metavar="N", help="Random seed for wind, noise and link loss.")] = 0,
    from_ground: Annotated[
        bool, typer.Option("--from-ground", help="Begin on the ground: arm, take off, and land at the end.")
    ] = False,
    home: HomePlace = None,
    duration: SimulatedDuration = None,
    settle: Settle = 10.0,
    udp: Annotated[
        bool, typer.Option("--udp", help="Run vehicle and companion as two processes over UDP, in real time.")
    ] = False,
    xrce: Annotated[
        bool, typer.Option("--xrce", help="The vehicle is a stock PX4: motors and torques go to its XRCE client.")
    ] = False,
    record: Record = None,
    report: Report = True,
    json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Fly a mission in simulation."""
    from companion.cli.check import check_sortie
    from companion.cli.finish import Ending
    from companion.cli.simulate import Simulation, in_lockstep, over_udp
    from companion.feasibility.words import headline
    from companion.library.orders import check_record, given_home, read_sortie, read_world
    from companion.record.place import new_directory

    faults = Faults()
    simulated = faults.collect(lambda: read_world(world, seed, home))
    given = given_home(home, simulated.world) if simulated is not None else NO_HOME_GIVEN
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, output, direct=True, given=given))
    faults.collect(lambda: check_record(record))
    faults.raise_any()
    assert sortie is not None and simulated is not None
    sortie, found = check_sortie(sortie)
    if not found.feasible:
        warn(f"warning: {headline(found)}")
    detail(f"mission {sortie.mission_source.name}, vehicle {sortie.vehicle_source.name}, world {simulated.file}")
    simulation = Simulation(
        sortie=sortie,
        simulated=simulated,
        from_ground=from_ground,
        duration=duration,
        directory=record or new_directory(sortie.mission.name),
        ending=Ending(json, settle, report),
        xrce=xrce,
    )
    raise typer.Exit((over_udp if udp else in_lockstep)(simulation))


def _check_to_fly(sortie: Sortie, accept: bool, json: bool) -> tuple[Sortie, FeasibilityReport]:
    """What ``check`` finds. Refuses where the vehicle cannot fly it; warns where it is flown all the same."""
    from companion.cli.check import check_sortie
    from companion.cli.finish import refuse
    from companion.feasibility.words import headline

    sortie, found = check_sortie(sortie)
    if not found.feasible:
        if not accept and not found.may_be_flown:
            # who knows that the ground falls away may say so; it is not held out to who does not
            offer = " (--accept-infeasible flies it all the same)" if found.only_capability_lacks else ""
            raise typer.Exit(refuse(headline(found) + offer, json))
        warn(f"warning: {headline(found)}")
    return sortie, found


@app.command()
def fly(
    mission: MissionName,
    connect: Connect,
    vehicle: VehicleName = None,
    output: OutputName = Output.AUTO,
    set_parameters: SetParameters = False,
    start: Starts = None,
    mode_name: ModeName = None,
    finish: Finishes = None,
    dry_run: DryRun = False,
    bench: Bench = False,
    tube: Tube = 5.0,
    floor: Floor = None,
    ceiling: Ceiling = None,
    home: HomePlace = None,
    draw: Draw = False,
    duration: Duration = None,
    settle: Settle = 10.0,
    record: Record = None,
    report: Report = True,
    accept_infeasible: AcceptInfeasible = False,
    signing_key: SigningKey = None,
    forward: Forward = None,
    xrce: Xrce = None,
    accept_direct_motors: AcceptDirectMotors = False,
    fetch_log: FetchLog = False,
    json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Fly a mission on a vehicle. Ctrl-C hands it back."""
    from companion.cli import flying
    from companion.cli.finish import Ending
    from companion.config.signing_key import read_key
    from companion.daemon.address import parse_address
    from companion.daemon.forwarding import parse_endpoint
    from companion.flight.conduct import Conduct, Finish, Limits
    from companion.library.orders import check_record, given_home, read_sortie
    from companion.record.place import new_directory

    faults = Faults()
    open_port = faults.collect(lambda: parse_address(connect))
    open_xrce = faults.collect(lambda: flying.xrce_port(xrce), "--xrce")
    given = faults.collect(lambda: given_home(home)) or NO_HOME_GIVEN
    sortie = faults.collect(lambda: read_sortie(mission, vehicle, flying.output_in(start, output, xrce), given=given))
    faults.collect(lambda: check_record(record))
    key = None if signing_key is None else faults.collect(lambda: read_key(signing_key))
    shared = faults.collect(lambda: tuple(map(parse_endpoint, forward or ())), "--forward") or ()
    log = faults.collect(lambda: flying.log_address(connect, signed=signing_key is not None)) if fetch_log else None
    faults.raise_any()
    assert sortie is not None and open_port is not None and open_xrce is not None
    sortie, found = _check_to_fly(sortie, accept_infeasible, json)
    conduct = Conduct(flying.authority_of(start, dry_run=dry_run, bench=bench, serial=connect.startswith("serial:")),
        Finish.AS_BEGUN if finish is None else Finish(finish.value), Limits(tube=tube, floor=floor, ceiling=ceiling),
        speed_scale_max=flying.most_speed_scale(found.speed_scale_max), own_mode=flying.mode_name(start, mode_name),
    )  # fmt: skip
    raise typer.Exit(flying.fly(flying.Flight(
        sortie, record or new_directory(sortie.mission.name), duration, Ending(json, settle, report), set_parameters,
        conduct, draw, accept_infeasible, key, shared, log,
    ), open_port(), open_xrce(sortie, accept_direct_motors)))  # fmt: skip


@app.command()
def demo(
    fast: Annotated[
        bool, typer.Option("--fast", help="As fast as the computer allows (lockstep), not in real time.")
    ] = False,
    plain: Annotated[
        bool, typer.Option("--plain", help="The undisturbed circle: begin on the path, in still air.")
    ] = False,
    output: OutputName = Output.MOTORS,
    record: Record = None,
    json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Fly the paper's circle: begun off the path, held still once and let go; and write the report.

    On an x500, r 10 m, 3 m/s; plant and daemon are two processes on this computer."""
    from companion.cli.demo import demo as show

    raise typer.Exit(show(fast=fast, plain=plain, output=output, record=record, as_json=json))


look_commands.register(app)
file_commands.register(app)
record_commands.register(app)
vehicle_commands.register(app)
study_commands.register(app)


def main() -> None:
    """The console entry point."""
    open_standard_streams()
    try:
        app()
    except CompanionError as error:
        warn(str(error))
        sys.exit(2)
    except BrokenPipeError:
        sys.exit(1)
    except KeyboardInterrupt:  # before or after a flight: while one goes on, the flight itself is asked to end
        sys.exit(130)
