"""``fly``: a mission on a vehicle."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from companion.cli.finish import NO_VEHICLE, Ending, finish, say
from companion.cli.orders import Sortie
from companion.daemon.address import Port
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.loop import NoVehicleError, clock, run
from companion.mission import Origin
from companion.record.folder import Recorder

WAIT_FOR_VEHICLE = 10.0


@dataclass(frozen=True)
class Flight:
    """One flight on a vehicle."""

    sortie: Sortie
    directory: Path
    duration: float | None
    ending: Ending
    set_parameters: bool = False


def fly(flight: Flight, port: Port) -> int:
    """Fly; the exit code."""
    sortie = flight.sortie
    recorder = Recorder(flight.directory, sortie.mission_source, sortie.vehicle_source, time.time() - clock())
    orders = Orders(
        sortie.mission,
        sortie.vehicle,
        sortie.level,
        flight.duration,
        Origin.TAKEOFF,
        auto=sortie.auto,
        set_parameters=flight.set_parameters,
    )
    conductor = Conductor(orders, recorder, clock(), stream=port.stream)
    say(f"listening to {port.describe()} for a vehicle; Ctrl-C hands it back")
    try:
        stopped = run(conductor, port, recorder, say, WAIT_FOR_VEHICLE)
    except NoVehicleError as error:
        recorder.discard()
        say(str(error))
        return NO_VEHICLE
    finally:
        port.close()
    return finish(conductor, recorder, flight.ending, stopped)
