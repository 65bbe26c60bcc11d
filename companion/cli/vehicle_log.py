"""The vehicle's own log, fetched after a flight: never the business of the flight's exit code."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from companion.cli.terminal import say
from companion.daemon.last_resort import error_words
from companion.services.log_files import fetch_log
from companion.services.vehicle import connect_vehicle
from companion.vehicle import CompanionError

if TYPE_CHECKING:
    from companion.record.ulog.joined import VehicleLog

SAID_EVERY = 5.0
"""s between two lines about a transfer."""


def fetch_newest_log(url: str, folder: Path) -> Path:
    """The newest log of the vehicle at ``url``, in ``folder``. CompanionError: why it cannot be had."""
    said = time.monotonic()

    def progress(done: int, whole: int) -> None:
        nonlocal said
        if time.monotonic() - said > SAID_EVERY:
            said = time.monotonic()
            say(f"fetching the vehicle's log ... {done / 1e3:.0f} of {whole / 1e3:.0f} kB")

    with connect_vehicle(url) as vehicle:
        return fetch_log(vehicle, folder, progress)


def fetch_and_join(url: str, directory: Path) -> None:
    """Fetch it into a flight folder and lay it beside the record; say what cannot be."""
    from companion.record.replay import load_flight
    from companion.record.ulog.joined import joined

    try:
        file = fetch_newest_log(url, directory)
        say(f"the vehicle's log: {file}")
        keep_log(directory, joined(file, load_flight(directory).table))
    except CompanionError as error:
        say(f"the vehicle's log is not beside the flight's: {error}")
    except KeyboardInterrupt:  # the flight is over: only the transfer is stopped
        say(f"the vehicle's log was not fetched whole: stopped; companion vehicle log --connect {url} fetches it")
    except Exception as error:  # the flight is flown and recorded: a log that fails must not make it a failure
        say(f"the vehicle's log is not beside the flight's: {error_words(error)}")


def keep_log(directory: Path, log: VehicleLog) -> None:
    """Keep a joined log in the flight folder, and say how well it fits."""
    from companion.record.ulog.joined import keep

    offset, correlation, overlap = log.alignment
    say(
        f"{keep(directory, log)}: {len(log.topics)} topics of {log.file}; {overlap:.1f} s in common, "
        f"body rates agree to {correlation:.3f}, clocks {1e3 * offset:.1f} ms apart"
    )
