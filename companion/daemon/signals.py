"""What signals do to a flight. The first (Ctrl-C, SIGTERM) asks for the end in order: the vehicle is handed back. The
second ends the process at once, whatever it is doing. A closed terminal and Ctrl-Z change nothing.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, the service manager."""
IGNORED = (signal.SIGHUP, signal.SIGTTOU, signal.SIGTTIN)
"""A terminal that was closed; one that stops whoever writes to it from the background."""
INTERRUPTED = 130
"""The exit code."""
ONE_PRESS = 0.05
"""s within which signals count as one: ``timeout`` sends its own twice (engineering choice)."""
LEAVE_WITHIN = 0.2
"""s for the last things of a process that ends at once; 0.5 s are promised. Issue 11, rule 3."""
CTRL_Z = (
    "Ctrl-Z does nothing in a flight: a stopped companion sends no setpoints. Ctrl-C hands the vehicle back; a second "
    "one ends the companion at once"
)


class Signals:
    """The signals that ``came``. ``stop``: what the first one does. ``at_once``: what is still done at the second one,
    in a thread of its own and for LEAVE_WITHIN at most."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self.came: list[int] = []
        self.stop: Callable[[], None] | None = None
        self.at_once: list[Callable[[], object]] = []
        self._say = say
        self._counted = 0
        self._counted_at = -ONE_PRESS

    def handle(self, number: int, frame: FrameType | None) -> None:
        """The first signal: in the main thread, between two steps of it. KeyboardInterrupt: nothing flies yet."""
        self.came.append(number)
        if self.stop is None:
            raise KeyboardInterrupt
        self.stop()

    def watch(self, descriptor: int) -> None:
        """Count them in a thread of their own: the main one may be busy with anything. ``descriptor`` gives the
        numbers, a byte each, until its other end is closed."""
        while numbers := os.read(descriptor, 64):
            for number in numbers:
                if number == signal.SIGTSTP:
                    self._say(CTRL_Z)
                elif number in ENDING and time.monotonic() - self._counted_at > ONE_PRESS:
                    self._counted_at = time.monotonic()
                    self._counted += 1
                    if self._counted == 2:
                        self._leave()

    def _leave(self) -> None:
        last = threading.Thread(target=self._do_last_things, daemon=True)
        last.start()
        last.join(LEAVE_WITHIN)
        os._exit(INTERRUPTED)

    def _do_last_things(self) -> None:
        for action in self.at_once:
            with contextlib.suppress(Exception):
                action()


@contextlib.contextmanager
def ending_signals(say: Callable[[str], None]) -> Iterator[Signals]:
    """While it lasts, signals do what is said above. For the main thread."""
    signals = Signals(say)
    read, write = os.pipe2(os.O_CLOEXEC)
    os.set_blocking(write, False)
    watcher = threading.Thread(target=signals.watch, args=(read,), name="signals", daemon=True)
    watcher.start()
    before = {number: signal.signal(number, signals.handle) for number in ENDING}
    before |= {number: signal.signal(number, signal.SIG_IGN) for number in IGNORED}
    before[signal.SIGTSTP] = signal.signal(signal.SIGTSTP, lambda number, frame: None)
    woken = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    try:
        yield signals
    finally:
        signal.set_wakeup_fd(woken)
        for number, previous in before.items():
            signal.signal(number, previous)
        os.close(write)
        watcher.join()
        os.close(read)
