"""The commands about files: export, schema, new."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Force = Annotated[bool, typer.Option("--force", help="Write over a file that is there.")]


def export(
    mission: Annotated[
        str, typer.Argument(metavar="MISSION", help="A mission file, a plan, or a name in configs/missions.")
    ],
    plan: Annotated[Path | None, typer.Option("--plan", help="A .plan for QGroundControl to draw the path.")] = None,
    csv: Annotated[Path | None, typer.Option("--csv", help="A table of the path, place by place.")] = None,
    vehicle: Annotated[str | None, typer.Option("--vehicle", help="Whose speeds, where they are auto.")] = None,
    home: Annotated[
        str | None, typer.Option("--home", metavar="LAT,LON,M", help="Home, for missions that name no place.")
    ] = None,
    tolerance: Annotated[
        float, typer.Option(min=0.001, max=100.0, help="m, how far the plan's legs may stray from the path.")
    ] = 0.1,
    spacing: Annotated[float, typer.Option(min=0.001, max=1000.0, help="m between the rows of the table.")] = 0.5,
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
            "plan), vehicle or world.",
        ),
    ],
    file: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="Where to. [default: KIND.yaml]")] = None,
    force: Force = False,
) -> None:
    """Write a commented example of a mission, a vehicle or a world, to begin from."""
    from companion.cli.new import new as write

    write(kind, file, force)


def schema(kind: Annotated[str, typer.Argument(metavar="KIND", help="mission, vehicle or world.")]) -> None:
    """Print the JSON Schema of a kind of file: every key, what it means, its unit. Editors complete and check by it."""
    from companion.cli.new import schema as print_schema

    print_schema(kind)


def register(app: typer.Typer) -> None:
    """Add the commands."""
    for command in (export, new, schema):
        app.command()(command)
