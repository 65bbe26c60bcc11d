"""The person's side: lines on stderr, the result on stdout. Neither can hold up a flight or end it.

A terminal may be closed, a pipe's reader may be gone, a screen may be stopped with Ctrl-S, and a service may have been
started without any of them.
"""

from __future__ import annotations

import contextlib
import enum
import os
import select
import sys
import threading
import time
from collections.abc import Iterator
from typing import IO

from companion.plain_text import printable_lines

BUSY_AFTER, BUSY_PERIOD = 2.0, 5.0
"""s until something that takes long is named, and between two such lines (engineering choice)."""
PATIENCE = 0.2
"""s that a line waits for a screen that is stopped; then it is dropped (it is in notes.txt)."""


def open_standard_streams() -> None:
    """Give stdin, stdout and stderr something to be, whatever we were started with.

    Where 1 or 2 is closed, the next file opened gets that number, and a library's complaint is written into a record.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # it was closed when Python started
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a name in any alphabet, a locale without it


class Volume(enum.IntEnum):
    """How much is said."""

    QUIET = 0
    NORMAL = 1
    VERBOSE = 2


_volume = Volume.NORMAL


def be_quiet(wanted: bool) -> None:
    """From now on only warnings and faults are said."""
    _set(Volume.QUIET, wanted)


def be_verbose(wanted: bool) -> None:
    """From now on more is said."""
    _set(Volume.VERBOSE, wanted)


def be_normal() -> None:
    """As at the start: every command begins so."""
    _set(Volume.NORMAL, True)


def _set(volume: Volume, wanted: bool) -> None:
    global _volume
    if wanted:
        _volume = volume


def is_verbose() -> bool:
    """Whether more is to be said."""
    return _volume is Volume.VERBOSE


def say(text: str) -> None:
    """A line for a person: always on stderr, so that stdout is the result's. Not where it is to be quiet."""
    if _volume > Volume.QUIET:
        warn(text)


def detail(text: str) -> None:
    """A line for whoever asked for more."""
    if _volume is Volume.VERBOSE:
        warn(text)


@contextlib.contextmanager
def busy(what: str) -> Iterator[None]:
    """What goes on inside is named once it takes more than ``BUSY_AFTER`` s, and again every so often."""
    begun, over = time.monotonic(), threading.Event()

    def tell_again() -> None:
        period = BUSY_AFTER
        while not over.wait(period):
            say(f"{what} ... {time.monotonic() - begun:.0f} s")
            period = BUSY_PERIOD

    teller = threading.Thread(target=tell_again, name="busy", daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()


def warn(text: str) -> None:
    """A line that a person must not miss, on stderr."""
    stream = sys.stderr
    if stream is not None and _takes_more(stream):
        _print(text, stream)


def tell(text: str) -> None:
    """The result, on stdout."""
    if sys.stdout is not None:
        _print(text, sys.stdout)


def _print(text: str, stream: IO[str]) -> None:
    try:
        print(printable_lines(text), file=stream, flush=True)
    except OSError:  # the reader is gone, the terminal is closed, the disk is full
        _forget(stream)
    except ValueError:  # a stream that was closed in Python
        return


def _forget(stream: IO[str]) -> None:
    """Nobody listens any more: what is left in the buffer goes nowhere, and is not complained about at the end."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def _takes_more(stream: IO[str]) -> bool:
    try:
        poll = select.poll()
        poll.register(stream.fileno(), select.POLLOUT)
        return bool(poll.poll(1e3 * PATIENCE))
    except (OSError, ValueError):  # not a file at all: a test's or an editor's own
        return True
