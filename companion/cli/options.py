"""Arguments and options that several commands take."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from companion.cli.output import Output

MissionName = Annotated[str, typer.Argument(metavar="MISSION", help="A mission file, or a name in configs/missions.")]
VehicleName = Annotated[
    str | None, typer.Option("--vehicle", help="A name in configs/vehicles, or a vehicle file. [default: x500]")
]
OutputName = Annotated[Output, typer.Option("--output", help="The level at which setpoints go out.")]
Json = Annotated[bool, typer.Option("--json", help="stdout is one JSON document; words go to stderr.")]
SigningKey = Annotated[
    Path | None, typer.Option("--signing-key", help="Sign, and believe only who signs: 64 hex digits, mode 0600.")
]
Record = Annotated[Path | None, typer.Option("--record", help="The flight folder. [default: flights/DATE-TIME-NAME]")]
Report = Annotated[
    bool,
    typer.Option("--report/--no-report", envvar="COMPANION_REPORT", help="Write report.html into the flight folder."),
]
Settle = Annotated[float, typer.Option("--settle", min=0.0, help="s of following after which the flight is settled.")]
Duration = Annotated[float | None, typer.Option("--duration", min=0.1, help="s of following.")]
Connect = Annotated[str, typer.Option(help="udpin://HOST:PORT, udpout://HOST:PORT or serial:///dev/NAME:BAUD.")]
