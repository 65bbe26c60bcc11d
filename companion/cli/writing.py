"""Files that a command writes for its user: never over another without --force."""

from __future__ import annotations

from pathlib import Path

from companion.config.syntax.faults import ConfigError, Fault


def writable(option: str, file: Path, force: bool) -> None:
    """ConfigError: the file is there already, or cannot be written where it is to be."""
    if file.exists() and (file.is_dir() or not force):
        message = f"{file}: is a folder" if file.is_dir() else f"{file}: exists already; --force writes over it"
        raise ConfigError([Fault(option, 0, "", message)])
    if not file.parent.is_dir():
        raise ConfigError([Fault(option, 0, "", f"{file.parent}: no such folder")])


def write(file: Path, text: str | bytes) -> None:
    """ConfigError: it cannot be written."""
    try:
        file.write_bytes(text.encode() if isinstance(text, str) else text)
    except OSError as error:
        raise ConfigError([Fault(str(file), 0, "", f"cannot be written: {error.strerror}")]) from None
