"""The commands that only look: preflight, status, watch."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from companion.cli.options import Connect, Json, SigningKey, VehicleName
from companion.cli.output import Output


def preflight(
    connect: Connect,
    mission: Annotated[
        str | None, typer.Argument(metavar="[MISSION]", help="Say where this mission would run, too.")
    ] = None,
    vehicle: VehicleName = None,
    upload: Annotated[
        bool,
        typer.Option("--upload", help="Upload the path as the vehicle's mission, and the fence as its geofence."),
    ] = False,
    signing_key: SigningKey = None,
    json: Json = False,
) -> None:
    """Look at a vehicle before a flight: what its parameters do when something goes wrong, what we advise, and why."""
    from companion.cli.preflight import preflight as look
    from companion.cli.terminal import say
    from companion.config.syntax.faults import Fault
    from companion.daemon.address import is_exposed, parse_address
    from companion.library.faults import Faults
    from companion.library.orders import read_sortie

    faults = Faults()
    faults.collect(lambda: parse_address(connect))
    if signing_key is not None:
        faults.add(
            Fault(
                "--signing-key",
                0,
                "",
                "preflight goes through MAVSDK, which cannot sign, and stops here; "
                "expected none: fly --dry-run looks at a vehicle that signs",
            )
        )
    sortie = None if mission is None else faults.collect(lambda: read_sortie(mission, vehicle, Output.AUTO))
    faults.raise_any()
    if is_exposed(connect):
        say(
            f"warning: {connect} can be reached over the network and nothing is signed: who answers may not be the "
            "vehicle; use a serial line, USB or loopback"
        )
    raise typer.Exit(look(connect, sortie, upload=upload, as_json=json))


def status(json: Json = False) -> None:
    """What the companions on this computer are doing: asked from another terminal."""
    from companion.cli.status import status as tell

    raise typer.Exit(tell(json))


def watch(
    listen: Annotated[
        str, typer.Option("--listen", metavar="HOST:PORT", help="Where the page is served.")
    ] = "127.0.0.1:8765",
    token_file: Annotated[
        Path | None,
        typer.Option(
            "--token-file",
            metavar="FILE",
            help="A token that viewers must have.",
            show_default="a new one beyond loopback, else none",
        ),
    ] = None,
) -> None:
    """Show the companions on this computer on a live page, for phone and laptop. Ctrl-C ends it."""
    from companion.cli.watch import watch as serve

    serve(listen, token_file)


def register(app: typer.Typer) -> None:
    """Add the commands."""
    for command in (preflight, status, watch):
        app.command()(command)
