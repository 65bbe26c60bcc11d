"""``companion vehicle``: what is done with a vehicle itself, beside flying it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.options import Connect, Json, complete_vehicle

vehicle = typer.Typer(
    no_args_is_help=True, help="A vehicle itself: its file from what is known, its signing key, its log."
)

Force = Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")]
Mass = Annotated[
    float | None,
    typer.Option(
        "--mass",
        metavar="KG",
        min=0.01,
        max=500.0,
        help="The take-off mass as weighed.",
        show_default="a guess, marked",
    ),
]
Arm = Annotated[
    float | None,
    typer.Option(
        "--arm", metavar="M", min=0.02, max=5.0, help="From the middle to a motor's axis, the longest.",
        show_default="as PX4 has it",
    ),
]  # fmt: skip


@vehicle.command("from")
def from_px4(
    connect: Connect,
    file: Annotated[Path, typer.Argument(metavar="[FILE]", help="The vehicle file to write.")] = Path("vehicle.yaml"),
    mass: Mass = None,
    arm: Arm = None,
    force: Force = False,
) -> None:
    """Write a commented vehicle file of what PX4 knows of itself, and what is left to measure. Nothing is flown."""
    from companion.cli.vehicle_making import from_px4 as make

    raise typer.Exit(make(connect, file, mass, arm, force))


@vehicle.command("from-log")
def from_log(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A log of PX4: a .ulg file.")],
    file: Annotated[Path, typer.Argument(metavar="[FILE]", help="The vehicle file to write.")] = Path("vehicle.yaml"),
    vehicle: Annotated[
        str | None,
        typer.Option(
            "--vehicle",
            metavar="NAME",
            help="The vehicle file whose other values are kept.",
            show_default="FILE where it is there, else what the log says of PX4's parameters",
            autocompletion=complete_vehicle,
        ),
    ] = None,
    mass: Mass = None,
    arm: Arm = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the fit into a .png, .svg or .pdf.")
    ] = None,
    force: Force = False,
) -> None:
    """Fit hover thrust, drag, lags and authority to a log, say how well each is known, and write the vehicle file."""
    from companion.cli.vehicle_making import from_log as make

    raise typer.Exit(make(log, file, vehicle, mass, arm, plot, force))


@vehicle.command()
def show(
    name: Annotated[
        str,
        typer.Argument(
            metavar="VEHICLE", help="A name from configs/vehicles, or a vehicle file.", autocompletion=complete_vehicle
        ),
    ],
    json: Json = False,
) -> None:
    """Show what a vehicle file says beside what flights have learned, how well and how long ago."""
    from companion.cli.vehicle_showing import show as print_it

    raise typer.Exit(print_it(name, json))


@vehicle.command()
def sign(
    connect: Connect,
    signing_key: Annotated[Path, typer.Option("--signing-key", help="The key: 64 hexadecimal digits, mode 0600.")],
    trust_link: Annotated[
        bool, typer.Option("--trust-link", help="The key goes in plain text over a network; nobody else listens there.")
    ] = False,
) -> None:
    """Give a vehicle its signing key, while it is disarmed: from then on it takes orders only from who has the key."""
    from companion.cli.finish import COMPLETED, NO_VEHICLE, refuse
    from companion.cli.terminal import say, tell
    from companion.config.signing_key import read_key
    from companion.config.syntax.faults import Fault
    from companion.daemon.address import parse_address
    from companion.daemon.key_giving import give_key
    from companion.daemon.loop import NoVehicleError, clock
    from companion.daemon.signing_files import signing_with
    from companion.library.faults import Faults
    from companion.mavlink.key_setup import KeySetup

    faults = Faults()
    open_port = faults.collect(lambda: parse_address(connect))
    key = faults.collect(lambda: read_key(signing_key))
    faults.raise_any()
    assert open_port is not None and key is not None
    port = open_port()
    try:
        if port.exposed and not trust_link:
            faults.add(
                Fault(
                    "--connect",
                    0,
                    "",
                    f"{port.describe()}: the key would go in plain text over a network; "
                    "use a serial line, USB or loopback, or give --trust-link where nobody else listens",
                )
            )
            faults.raise_any()
        with signing_with(key, time.time() - clock()) as signing:
            setup = KeySetup(signing, stream=port.stream)
            say(f"listening to {port.describe()} for a vehicle that is to sign")
            give_key(setup, port)
    except NoVehicleError as error:
        say(str(error))
        raise typer.Exit(NO_VEHICLE) from None
    finally:
        port.close()
    if setup.refusal is not None:
        raise typer.Exit(refuse(setup.refusal, as_json=False, what="no key was taken"))
    took = "signs with this key already" if setup.already else "has taken the key and signs"
    tell(f"the vehicle {took}; every command needs it from now on: --signing-key {signing_key}")
    raise typer.Exit(COMPLETED)


@vehicle.command()
def log(
    connect: Connect,
    to: Annotated[Path, typer.Option("--to", metavar="FOLDER", help="Where to put it.")] = Path(),
) -> None:
    """Fetch the vehicle's own log (ULog) of its last flight, once it is disarmed."""
    from companion.cli.finish import FAILED, NO_VEHICLE
    from companion.cli.terminal import say, tell
    from companion.cli.vehicle_log import fetch_newest_log
    from companion.config.syntax.faults import Fault
    from companion.daemon.address import parse_address
    from companion.library.faults import Faults
    from companion.services.vehicle import NoVehicleHeardError, ServiceError

    faults = Faults()
    faults.collect(lambda: parse_address(connect))
    if not to.is_dir():
        faults.add(Fault("--to", 0, "", f"{to}: no such folder"))
    faults.raise_any()
    try:
        file = fetch_newest_log(connect, to)
    except ServiceError as error:
        say(str(error))
        raise typer.Exit(NO_VEHICLE if isinstance(error, NoVehicleHeardError) else FAILED) from None
    tell(f"{file}\nbeside a flight of ours: companion export-flight DIR --ulog-join {file}")


def register(app: typer.Typer) -> None:
    """Add the group."""
    app.add_typer(vehicle, name="vehicle")
