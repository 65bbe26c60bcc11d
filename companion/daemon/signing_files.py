"""The time stamps of a signed link, which outlive us: so that what was heard once is refused after a restart too.

$XDG_STATE_HOME/companion/signing-KEY.json      (usually ~/.local/state), KEY being a digest of the key
"""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

from companion.daemon.realtime import HELPER_PRIORITY, at_priority
from companion.mavlink.signing import STAMP_MAX, STREAMS_MAX, TICK, Signing
from companion.record.learned import state_directory
from companion.record.owned_files import read_owned, write_owned
from companion.vehicle import CompanionError

SCHEMA = "companion.signing/1"
PERIOD = 1.0
"""s between two times that the stamps are written. Engineering choice."""
AHEAD = round(2.0 * PERIOD / TICK)
"""Ticks that the stamps are written ahead of what was used, so that a power cut takes none back."""


class StampsError(CompanionError):
    """The stamps cannot be kept (exit code 2)."""


@contextlib.contextmanager
def signing_with(key: bytes, epoch: float, link: int = 0) -> Iterator[Signing]:
    """Sign with a key while it lasts, from the stamps of the last time on. ``epoch``: s since 1970 when our clock read
    zero. StampsError: they cannot be kept."""
    directory = state_directory()
    if directory is None:
        raise StampsError("the time stamps of signing cannot be kept: you have no home directory; set XDG_STATE_HOME")
    file = directory / f"signing-{sha256(b'companion signing key ' + key).hexdigest()[:16]}.json"
    signing = _read_stamps(key, link, file)
    signing.epoch = epoch
    if not _write_stamps(signing, file, AHEAD):
        raise StampsError(
            f"the time stamps of signing cannot be kept in {file}: without them old messages could be replayed; "
            "see whose the directory is, or set XDG_STATE_HOME to one of your own"
        )
    over = threading.Event()

    def keep() -> None:
        at_priority(HELPER_PRIORITY)
        while not over.wait(PERIOD):
            _write_stamps(signing, file, AHEAD)

    keeper = threading.Thread(target=keep, name="stamps", daemon=True)
    keeper.start()
    try:
        yield signing
    finally:
        over.set()
        keeper.join()
        _write_stamps(signing, file, 0)


def _write_stamps(signing: Signing, file: Path, ahead: int) -> bool:
    streams = {"/".join(map(str, stream)): stamp + ahead for stream, stamp in list(signing.streams.items())}
    document = {"schema": SCHEMA, "stamp": signing.stamp + ahead, "streams": streams}
    return write_owned(file, json.dumps(document, indent=2) + "\n")


def _read_stamps(key: bytes, link: int, file: Path) -> Signing:
    """The stamps of the last time; from the start where there are none that make sense."""
    signing = Signing(key, link)
    try:
        document = json.loads(read_owned(file) or "{}")
        stamp, streams = document["stamp"], document["streams"]
        for name, last in list(streams.items())[:STREAMS_MAX]:
            system, component, number = map(int, name.split("/"))
            signing.streams[system, component, number] = _stamp(last)
        signing.stamp = _stamp(stamp)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return signing
    return signing


def _stamp(value: object) -> int:
    if not isinstance(value, int) or not 0 <= value <= STAMP_MAX:
        raise ValueError("no time stamp")
    return value
