"""What every flight is wrapped in: its record, its signals, and what is told where it had no end of its own."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path

from companion.cli.finish import FAILED, INTERRUPTED, NO_VEHICLE, Ending, refuse
from companion.cli.terminal import warn
from companion.daemon.conductor import Conductor
from companion.daemon.last_resort import error_words
from companion.daemon.loop import NoVehicleError, clock
from companion.daemon.signals import Signals
from companion.daemon.vehicle_words import describe_vehicle
from companion.library.orders import Sortie
from companion.record.circumstances import SimulatedWorld
from companion.record.folder import Recorder
from companion.vehicle import CompanionError


def begin_record(directory: Path, sortie: Sortie, epoch: float, simulated: SimulatedWorld | None = None) -> Recorder:
    """The record of a flight that begins, and what is to be said of it. ConfigError: the folder cannot be one."""
    recorder = Recorder(directory, sortie.mission_source, sortie.vehicle_source, epoch, simulated)
    while recorder.words:
        warn(recorder.words.popleft())
    return recorder


def listen_to(signals: Signals, conductor: Conductor, recorder: Recorder) -> None:
    """From now on a signal ends this flight, and a second one the process."""
    signals.stop = conductor.stop

    def last_words() -> None:
        where = describe_vehicle(conductor, clock())
        warn(
            "a second signal: the companion ends at once and hands nothing back"
            + (
                ""
                if where is None
                else f"; {where}. Where it flew on setpoints, PX4 acts on their loss (COM_OBL_RC_ACT)"
            )
        )

    signals.at_once += [last_words, recorder.flush]  # no sync: a process cannot end in the middle of one


def no_vehicle(reason: str, ending: Ending) -> int:
    """Nobody was heard; the exit code."""
    if ending.json:
        refuse(reason, as_json=True)
    warn(reason)
    return NO_VEHICLE


def report_failure(error: Exception, recorder: Recorder, ending: Ending) -> int:
    """The companion itself failed outside of the flight's own turns; the exit code."""
    recorder.keep_failure(traceback.format_exc())
    recorder.close()
    sentence = (
        f"the companion itself failed ({error_words(error)}): nothing more was sent; look at the vehicle, and "
        f"send in the flight folder {recorder.directory}"
    )
    refuse(sentence, ending.json)
    warn(sentence)
    return FAILED


def exit_code_of(fly: Callable[[], int], recorder: Recorder, ending: Ending) -> int:
    """What ``fly`` returns; or where it raises, the exit code of that. The record of what never flew is removed."""
    try:
        return fly()
    except NoVehicleError as error:
        recorder.discard()
        return no_vehicle(str(error), ending)
    except KeyboardInterrupt:  # before anything flew
        recorder.discard()
        return INTERRUPTED
    except CompanionError:
        recorder.discard()
        raise
    except Exception as error:
        return report_failure(error, recorder, ending)
