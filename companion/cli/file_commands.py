"""The commands about files: export, schema, new."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from companion.cli.options import MissionName, VehicleName

Force = Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")]


def export(
    mission: MissionName,
    plan: Annotated[
        Path | None, typer.Option("--plan", metavar="FILE", help="Write a .plan that QGroundControl draws.")
    ] = None,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write a table of the path.")] = None,
    vehicle: VehicleName = None,
    home: Annotated[
        str | None,
        typer.Option("--home", metavar="LAT,LON,M", help="The home position, for missions that name no place."),
    ] = None,
    tolerance: Annotated[
        float,
        typer.Option(metavar="M", min=0.001, max=100.0, help="Metres that the plan's legs may be from the path."),
    ] = 0.1,
    spacing: Annotated[
        float, typer.Option(metavar="M", min=0.001, max=1000.0, help="Metres between the rows of the table.")
    ] = 0.5,
    force: Force = False,
) -> None:
    """Write a mission as a plan that QGroundControl draws, or as a table. Nothing is flown."""
    from companion.cli.export import export as write

    write(mission, vehicle, plan, csv, home, tolerance, spacing, force)


def new(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND",
            help="A kind of path (circle, ellipse, lissajous, line, polyline, spline, expression, helix, implicit, "
            "plan), vehicle, world or study.",
        ),
    ],
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="The file to write.", show_default="KIND.yaml")
    ] = None,
    force: Force = False,
) -> None:
    """Write a commented example of a mission, a vehicle, a world or a study, to begin from."""
    from companion.cli.new import new as write

    write(kind, file, force)


def schema(kind: Annotated[str, typer.Argument(metavar="KIND", help="mission, vehicle, world or study.")]) -> None:
    """Print the JSON Schema of a kind of file: every key, what it means, its unit. Editors complete and check by it."""
    from companion.cli.new import schema as print_schema

    print_schema(kind)


def register(app: typer.Typer) -> None:
    """Add the commands."""
    for command in (export, new, schema):
        app.command()(command)
