"""The vehicle's own log of the flight that has just ended, by MAVLink FTP."""

from __future__ import annotations

import queue
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from companion.services.vehicle import HEARTBEAT_WITHIN, ConnectedVehicle, ServiceError

FOLDERS = ("/fs/microsd/log", "/log")
"""Where PX4 keeps its logs: on a card; in its simulation."""
DATED, NUMBERED = re.compile(r"\d{4}-\d\d-\d\d"), re.compile(r"sess\d+")
"""Folders of logs whose UTC the vehicle knew, and of those without."""
CLOSED_WITHIN, LOOKED_EVERY = 10.0, 0.5
"""s for a log to stop growing after disarming, and between two looks (engineering choice)."""
STALLED_AFTER = 15.0
"""s without a byte until a transfer is given up (engineering choice)."""

Progress = Callable[[int, int], None]
"""Told how many bytes of how many have come."""


def fetch_log(vehicle: ConnectedVehicle, folder: Path, progress: Progress) -> Path:
    """Copy the newest log into ``folder`` under its own name; the file. ServiceError: why it cannot be had."""
    from mavsdk.plugins.ftp import Ftp, FtpError
    from mavsdk.plugins.telemetry import Telemetry

    if is_armed(Telemetry(vehicle.system)):
        raise ServiceError("the vehicle is armed and still writes its log; once disarmed: companion vehicle log")
    ftp = Ftp(vehicle.system)
    try:
        path = wait_for_closed_log(ftp)
    except FtpError as error:
        raise ServiceError(f"the vehicle does not show its files by MAVLink FTP ({error.result.name})") from None
    return _download(ftp, path, folder, progress)


def is_armed(telemetry: Any) -> bool:
    """As its next HEARTBEAT says: before the first one MAVSDK's own figure is False. ServiceError: none comes."""
    said: queue.SimpleQueue[bool] = queue.SimpleQueue()
    handle = telemetry.subscribe_armed(lambda armed, _: said.put(bool(armed)))
    try:
        return said.get(timeout=HEARTBEAT_WITHIN)
    except queue.Empty:
        raise ServiceError(f"the vehicle has not been heard for {HEARTBEAT_WITHIN:g} s; is it still on?") from None
    finally:
        telemetry.unsubscribe_armed(handle)


def newest(names: list[str]) -> str | None:
    """Of folders of logs the last by date, else the last by number; of none, None."""
    for kind in (DATED, NUMBERED):
        found = [name for name in names if kind.fullmatch(name)]
        if found:
            return max(found)
    return None


def wait_for_closed_log(ftp: Any) -> str:
    """The path of the newest log, once it has stopped growing. ServiceError: it has not, or there is none."""
    ends = time.monotonic() + CLOSED_WITHIN
    seen = _newest_log(ftp)
    while time.monotonic() < ends:
        time.sleep(LOOKED_EVERY)
        before, seen = seen, _newest_log(ftp)
        if seen == before:
            return seen[0]
    raise ServiceError(
        f"the vehicle still writes {seen[0]} after {CLOSED_WITHIN:g} s, and half of a log was not fetched; once it is "
        "closed: companion vehicle log (SDLOG_MODE 0 closes it at disarming, 2 and 4 only when it is switched off)"
    )


def _newest_log(ftp: Any) -> tuple[str, int]:
    """Its path and its bytes."""
    from mavsdk.plugins.ftp import FtpError, FtpResult

    for folder in FOLDERS:
        try:
            entries = ftp.list_directory(folder).entries
        except FtpError as error:
            if error.result in (FtpResult.FILE_DOES_NOT_EXIST, FtpResult.PROTOCOL_ERROR):
                continue
            raise
        day = newest([entry.name for entry in entries])
        if day is None:
            continue
        logs = {entry.name: entry.size_bytes for entry in ftp.list_directory(f"{folder}/{day}").entries}
        names = [name for name in logs if name.endswith(".ulg")]
        if names:
            return f"{folder}/{day}/{max(names)}", logs[max(names)]
    raise ServiceError("the vehicle has no log; is SDLOG_MODE -1, or its card missing?")


def _download(ftp: Any, path: str, folder: Path, progress: Progress) -> Path:
    from mavsdk.plugins.ftp import FtpResult

    told: queue.SimpleQueue[tuple[Any, int, int]] = queue.SimpleQueue()
    ftp.download_async(
        path, str(folder), True, lambda result, data, _: told.put((result, data.bytes_transferred, data.total_bytes))
    )
    while True:
        try:
            result, done, whole = told.get(timeout=STALLED_AFTER)
        except queue.Empty:
            raise ServiceError(f"{path} does not come: nothing for {STALLED_AFTER:g} s") from None
        if result == FtpResult.NEXT:
            progress(done, whole)
            continue
        if result != FtpResult.SUCCESS:
            raise ServiceError(f"{path} could not be fetched ({result.name})")
        return folder / path.rpartition("/")[2]
