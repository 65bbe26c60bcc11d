"""A serial line, raw, 8N1, without flow control."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import select
import termios
import time
import tty
from pathlib import Path

from companion.daemon.port import AddressError
from companion.mavlink.peer import LINE, Received, Source

CHUNK_MAX = 65536
"""bytes read at once: more than any line's buffer. Engineering choice."""
REOPEN_AFTER = 0.5
"""s between two attempts to open a line again that was unplugged. Engineering choice."""


class SerialPort:
    """One device. Unplugged, it is silent, which the guards see; plugged in again, it speaks again."""

    stream = True
    called: Source | None = LINE
    exposed = False

    def __init__(self, device: str, baud: int) -> None:
        self._device, self._baud = device, baud
        self._file: int | None = _open(device, baud)
        self._unsent = b""
        self._tried_at = 0.0

    def fileno(self) -> int:
        """See Port."""
        return -1 if self._file is None else self._file

    def receive(self, timeout: float) -> list[Received]:
        """See Port."""
        if self._file is None:
            self._reopen(timeout)
            return []
        ready, _, _ = select.select([self._file], [], [], max(timeout, 0.0))
        if not ready:
            return []
        try:
            data = os.read(self._file, CHUNK_MAX)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data:
            self.close()
            return []
        return [(data, LINE)]

    def send(self, data: bytes, to: Source) -> None:
        """See Port. A frame that does not fit is dropped whole: half of one would spoil the next for the other side."""
        if self._file is None:
            return
        try:
            if self._unsent:
                self._unsent = self._unsent[os.write(self._file, self._unsent) :]
            if not self._unsent:
                self._unsent = data[os.write(self._file, data) :]
        except OSError:  # full or unplugged: an old frame is never queued behind a new one
            return

    def close(self) -> None:
        """See Port."""
        if self._file is not None:
            os.close(self._file)
            self._file, self._unsent = None, b""

    def describe(self) -> str:
        """See Port."""
        return f"{self._device} at {self._baud} baud"

    def _reopen(self, timeout: float) -> None:
        now = time.monotonic()
        if now - self._tried_at >= REOPEN_AFTER:
            self._tried_at = now
            with contextlib.suppress(AddressError):
                self._file = _open(self._device, self._baud)
                return
        select.select([], [], [], min(max(timeout, 0.0), REOPEN_AFTER))


def known_rate(baud: int) -> int:
    """The system's number for a baud rate. AddressError: it has none."""
    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise AddressError(f"{baud} is no baud rate of this system; expected 57600, 115200, 460800, 921600, ...")
    return int(speed)


def _open(device: str, baud: int) -> int:
    """The open device, ours alone. AddressError: what is wrong and what to do about it."""
    speed = known_rate(baud)
    try:
        file = os.open(device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise AddressError(f"{device} cannot be opened: {error.strerror}{_hint(error, device)}") from None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        tty.setraw(file)
        attributes = termios.tcgetattr(file)
        attributes[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
        attributes[4] = attributes[5] = speed
        termios.tcsetattr(file, termios.TCSANOW, attributes)
        termios.tcflush(file, termios.TCIFLUSH)
    except termios.error:
        os.close(file)
        raise AddressError(
            f"{device} is not a serial line; expected one such as /dev/ttyAMA0 or /dev/ttyUSB0"
        ) from None
    except OSError as error:
        os.close(file)
        raise AddressError(f"{device} is in use{_hint(error, device)}") from None
    return file


def _hint(error: OSError, device: str) -> str:
    """What to do about it."""
    if error.errno == errno.ENOENT:
        there = sorted(
            str(path) for kind in ("ttyAMA*", "ttyUSB*", "ttyACM*", "serial*") for path in Path("/dev").glob(kind)
        )
        return f"; this machine has {', '.join(there)}" if there else "; is it plugged in?"
    if error.errno == errno.EACCES:
        return "; is the user in the group dialout?"
    users = _users_of(device)
    who = f" by {', '.join(users)}" if users else ""
    return f"{who}; end what uses it, or take another port"


def _users_of(device: str) -> list[str]:
    """The programs that have a device open, as far as we may see them."""
    found = []
    target = os.path.realpath(device)
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if int(process.name) != os.getpid() and any(os.readlink(fd) == target for fd in (process / "fd").iterdir()):
                found.append(f"{(process / 'comm').read_text().strip()} ({process.name})")
    return found
