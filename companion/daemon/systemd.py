"""Told to systemd, where it started us: that we are ready, alive, what we do, that we end (sd_notify, no dependency).

The watchdog is fed from the control loop. When that hangs, nothing else may say that all is well.
"""

from __future__ import annotations

import contextlib
import math
import os
import socket
from collections.abc import Mapping

from companion.plain_text import printable


class Service:
    """Our service manager. Without one (``NOTIFY_SOCKET`` is not set) every door does nothing."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        self._socket: socket.socket | None = None
        self._address = "\0" + address[1:] if address.startswith("@") else address
        if address:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
            self._socket.setblocking(False)
        self.period = self._period(environment)
        """s between two signs of life, half of what the watchdog waits; inf without a watchdog."""
        self._alive_at = -math.inf

    def ready(self, status: str) -> None:
        """The link is open."""
        self._say(f"READY=1\nSTATUS={printable(status)}")

    def status(self, text: str) -> None:
        """What is being done, for ``systemctl status``."""
        self._say(f"STATUS={printable(text)}")

    def alive(self, now: float) -> None:
        """A turn of the control loop is done; said no more often than it is asked for."""
        if now - self._alive_at >= self.period:
            self._alive_at = now
            self._say("WATCHDOG=1")

    def stopping(self) -> None:
        """The flight is over."""
        self._say("STOPPING=1")

    def close(self) -> None:
        """Say nothing more."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _period(self, environment: Mapping[str, str]) -> float:
        if self._socket is None or environment.get("WATCHDOG_PID", str(os.getpid())) != str(os.getpid()):
            return math.inf
        try:
            return 0.5e-6 * int(environment["WATCHDOG_USEC"])
        except (KeyError, ValueError):
            return math.inf

    def _say(self, text: str) -> None:
        if self._socket is not None:
            with contextlib.suppress(OSError):  # a manager that does not listen is not worth a flight
                self._socket.sendto(text.encode(), self._address)
