"""Signals that ask a flight to end, in order: the vehicle is handed back, never dropped."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Ctrl-C, the service manager, a terminal that was closed."""


@contextlib.contextmanager
def ending_signals(stop: Callable[[], None]) -> Iterator[list[int]]:
    """While it lasts, ``stop`` is called at a signal that asks for the end. The signals that came."""
    came: list[int] = []

    def handler(number: int, frame: FrameType | None) -> None:
        came.append(number)
        stop()

    before = {number: signal.signal(number, handler) for number in ENDING}
    try:
        yield came
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)
