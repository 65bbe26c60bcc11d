"""The commands about what was flown, and about the law alone: report, replay, law."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.options import MissionName, VehicleName
from companion.cli.output import LawOutput
from companion.cli.terminal import busy, say
from companion.plain_text import printable


def law(
    mission: MissionName,
    vehicle: VehicleName = None,
    output: Annotated[
        LawOutput, typer.Option("--output", help="The level of the law: motor torques or body rates.")
    ] = LawOutput.MOTORS,
) -> None:
    """The law without a vehicle: states as JSON lines on stdin, xi, b, D and the inputs as JSON lines on stdout.

    A line without an answer is told on stderr, and the run goes on. Exit code: 0 all were answered, 1 the law is not
    defined at a state, 2 a line was no state."""
    from companion.cli.bare import answers
    from companion.law.gains import Level
    from companion.library.orders import read_bare

    level = Level.MOTORS if output is LawOutput.MOTORS else Level.RATES
    read = read_bare(mission, vehicle, level)
    raise typer.Exit(answers(*read, level, sys.stdin, sys.stdout).exit_code)


def report_command(directory: Annotated[Path, typer.Argument(metavar="DIR", help="A flight folder.")]) -> None:
    """Write the figures and tables of a recorded flight again."""
    from companion.record.report import write_report

    with busy("drawing the report"):
        page = write_report(directory)
    print(printable(str(page)))


def replay(directory: Annotated[Path, typer.Argument(metavar="DIR", help="A flight folder.")]) -> None:
    """Feed a flight's recorded inputs through the pilot again: the same setpoints, bit for bit."""
    from companion.record.replay import load_flight
    from companion.record.replay import replay as again
    from companion.record.xrce_log import latency_words, read_latency

    flight = load_flight(directory)
    for cut in flight.cuts:
        say(f"note: {cut}")
    with busy("replaying"):
        replayed = again(flight)
    if replayed.difference is not None:
        print(f"differs at {replayed.difference}")
        raise typer.Exit(1)
    print(f"{replayed.ticks} ticks, {replayed.setpoints} setpoints: the same, bit for bit")
    sent = read_latency(directory, flight.table)
    if sent is not None and sent.differing is not None:
        print(f"link.xrce differs at {sent.differing}: it is not the setpoint of that tick")
        raise typer.Exit(1)
    if sent is not None:
        print(latency_words(sent))


def export_flight(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="A flight folder.")],
    csv: Annotated[
        bool, typer.Option("--csv", help="Write tables that a spreadsheet opens, and their legend.")
    ] = False,
    mcap: Annotated[bool, typer.Option("--mcap", help="Write flight.mcap, for Foxglove and PlotJuggler.")] = False,
    ulog_join: Annotated[
        Path | None,
        typer.Option("--ulog-join", metavar="FILE.ulg", help="Lay the vehicle's own log beside ours, by time."),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option("--to", metavar="FOLDER", help="Where to write.", show_default="the flight folder"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
) -> None:
    """Write a recorded flight as files that other programs open."""
    from companion.cli.export_flight import export_flight as write

    write(directory, to, csv=csv, mcap=mcap, force=force, ulog=ulog_join)


def register(app: typer.Typer) -> None:
    """Add the commands."""
    commands = (("law", law), ("report", report_command), ("replay", replay), ("export-flight", export_flight))
    for name, command in commands:
        app.command(name)(command)
