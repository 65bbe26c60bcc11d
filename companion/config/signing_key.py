"""The key of a signed link: a file of the user's with 32 bytes as 64 hexadecimal digits, mode 0600."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path

from companion.config.syntax.faults import ConfigError, Fault

KEY_SIZE = 32
"""bytes (MAVLink's guide, "Message Signing")."""
MODE = 0o600
_DIGITS = re.compile(rf"[0-9a-fA-F]{{{2 * KEY_SIZE}}}\s*")
_HOW = "make one with: (umask 077; openssl rand -hex 32 > FILE)"


def read_key(path: Path) -> bytes:
    """The key in a file. ConfigError: what is wrong and what to do; the key itself is never said."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError as error:
        raise _fault(path, f"cannot be read: {error.strerror}; {_HOW}") from None
    try:
        about = os.fstat(file)
        if not stat.S_ISREG(about.st_mode):
            raise _fault(path, f"is no file; {_HOW}")
        mode = stat.S_IMODE(about.st_mode)
        if mode != MODE:
            raise _fault(
                path,
                f"has mode {mode:04o}, expected {MODE:04o}: who can read it can command the vehicle; chmod 600 it, and "
                "give the vehicle a new key if others could have read this one",
            )
        if about.st_uid != os.geteuid():
            raise _fault(path, "belongs to somebody else; expected a file of your own")
        text = os.read(file, 4 * KEY_SIZE).decode("ascii", "replace")
    finally:
        os.close(file)
    if not _DIGITS.fullmatch(text):
        raise _fault(path, f"is no key; expected {2 * KEY_SIZE} hexadecimal digits; {_HOW}")
    key = bytes.fromhex(text)
    if not any(key):
        raise _fault(path, f"is all zeros, which takes a vehicle's key away; {_HOW}")
    return key


def _fault(path: Path, message: str) -> ConfigError:
    return ConfigError([Fault("--signing-key", 0, "", f"{path} {message}")])
