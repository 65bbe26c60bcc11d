"""The options that several commands take, in plain English, with their defaults and their tab completion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from companion.cli.output import Ends, Output, WhoStarts
from companion.cli.terminal import be_quiet, be_verbose


def _names_in(kind: str, incomplete: str) -> list[str]:
    from companion.config.syntax.file_lookup import names

    return [name for name in names(kind) if name.startswith(incomplete)]


def complete_mission(incomplete: str) -> list[str]:
    """The shipped missions; a shell completes files by itself where none of them begins so."""
    return _names_in("missions", incomplete)


def complete_vehicle(incomplete: str) -> list[str]:
    """The shipped vehicles."""
    return _names_in("vehicles", incomplete)


def complete_world(incomplete: str) -> list[str]:
    """The shipped worlds."""
    return _names_in("worlds", incomplete)


MISSION_HELP = "A mission file, a plan (.plan, .waypoints), or a name from configs/missions."
CONNECT_HELP = "Where the vehicle is: udpin://HOST:PORT, udpout://HOST:PORT or serial:///dev/NAME:BAUD."

MissionName = Annotated[str, typer.Argument(metavar="MISSION", help=MISSION_HELP, autocompletion=complete_mission)]
VehicleName = Annotated[
    str | None,
    typer.Option(
        "--vehicle",
        metavar="NAME",
        help="The vehicle: a name from configs/vehicles, or a vehicle file.",
        show_default="the mission's own, else x500",
        autocompletion=complete_vehicle,
    ),
]
WorldName = Annotated[
    str,
    typer.Option(
        "--world",
        metavar="NAME",
        help="The simulated world: a name from configs/worlds, or a world file.",
        autocompletion=complete_world,
    ),
]
OutputName = Annotated[
    Output,
    typer.Option(
        "--output",
        help="What is sent to the vehicle. auto: motor commands only where MAVLink brings them, else body rates.",
    ),
]
Connect = Annotated[str, typer.Option(metavar="URL", help=CONNECT_HELP)]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout; words go to stderr.")]
Record = Annotated[
    Path | None,
    typer.Option(
        "--record", metavar="DIR", help="The folder for the flight's record.", show_default="flights/DATE-TIME-NAME"
    ),
]
Report = Annotated[
    bool,
    typer.Option("--report/--no-report", envvar="COMPANION_REPORT", help="Write report.html into the flight folder."),
]
Settle = Annotated[
    float,
    typer.Option("--settle", metavar="S", min=0.0, help="Seconds after which the flight counts as settled."),
]
HomePlace = Annotated[
    str | None,
    typer.Option(
        "--home",
        metavar="LAT,LON,M",
        help="Where home is: degrees, and metres above sea level.",
        show_default="as the plan or the world says",
    ),
]


def _duration(without_laps: str) -> Any:
    return typer.Option(
        "--duration",
        metavar="S",
        min=0.1,
        help="Seconds to follow the path.",
        show_default=f"the mission's laps; without laps, an open path to its end and a closed one {without_laps}",
    )


Duration = Annotated[float | None, _duration("until stopped")]
SimulatedDuration = Annotated[float | None, _duration("for 60 s")]
SigningKey = Annotated[
    Path | None,
    typer.Option(
        "--signing-key",
        metavar="FILE",
        help="Sign what is sent and believe only what is signed: a file of 64 hex digits, mode 0600.",
        show_default="unsigned",
    ),
]
Forward = Annotated[
    list[str] | None,
    typer.Option(
        "--forward",
        metavar="URL",
        help="Share the vehicle's link with udpout://HOST:PORT (?max_hz=HZ and &commands=yes may follow); repeat it.",
        show_default="nobody",
    ),
]
FetchLog = Annotated[
    bool,
    typer.Option("--fetch-log", help="After landing, fetch the vehicle's own log (ULog) into the flight folder."),
]
Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", callback=be_quiet, help="Say only warnings, faults and the result."),
]
Verbose = Annotated[
    bool,
    typer.Option("--verbose", "-v", callback=be_verbose, help="Say more: the files used, progress each second."),
]
SetParameters = Annotated[
    bool,
    typer.Option("--set-parameters", help="Set COM_OF_LOSS_T as --output needs it, and set it back afterwards."),
]
Starts = Annotated[
    WhoStarts | None,
    typer.Option(
        "--start",
        help="Who arms and selects OFFBOARD; mode: a flight mode of our own that the pilot selects (--xrce).",
        show_default="pilot on a serial line, else companion",
    ),
]
ModeName = Annotated[
    str | None,
    typer.Option(
        "--mode-name",
        metavar="NAME",
        help="What the ground station calls the mode of --start mode.",
        show_default="Path",
    ),
]
Finishes = Annotated[
    Ends | None,
    typer.Option(
        "--finish",
        help="What the vehicle does after the path.",
        show_default="land if it began on the ground, else hold",
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Do everything except arming and sending setpoints.")]
Bench = Annotated[
    bool, typer.Option("--bench", help="Propellers off: tilt the vehicle by hand and see the commands point back.")
]
Tube = Annotated[
    float, typer.Option(metavar="M", min=0.5, help="Metres from the path at which the vehicle is handed back.")
]
Floor = Annotated[
    float | None,
    typer.Option(metavar="M", help="Least height above home, in metres.", show_default="1, or less for a low path"),
]
Ceiling = Annotated[
    float | None, typer.Option(metavar="M", help="Greatest height above home, in metres.", show_default="none")
]
Draw = Annotated[
    bool,
    typer.Option("--draw", help="Upload the path as mission items: the ground station shows it on its map."),
]
Xrce = Annotated[
    str | None,
    typer.Option(
        "--xrce",
        metavar="URL",
        help="Serve PX4's XRCE client, as MicroXRCEAgent would: udp://127.0.0.1:8888 or serial:///dev/NAME:BAUD. "
        "With it --output motors and torques fly on a stock PX4.",
        show_default="MAVLink alone",
    ),
]
AcceptDirectMotors = Annotated[
    bool,
    typer.Option(
        "--accept-direct-motors",
        help="Fly motors or torques over XRCE, knowing what PX4 no longer does then (docs/xrce.md).",
    ),
]
AcceptInfeasible = Annotated[
    bool,
    typer.Option("--accept-infeasible", help="Fly even where check says that the vehicle is too weak or too slow."),
]
