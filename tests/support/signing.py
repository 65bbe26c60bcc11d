"""Keys for tests."""

from __future__ import annotations

from pathlib import Path

KEY = bytes(range(100, 132))
OTHER = bytes(range(1, 33))


def key_file(directory: Path, key: bytes = KEY, mode: int = 0o600) -> Path:
    """A key file as a user makes it."""
    file = directory / f"{key[0]}.key"
    file.write_text(key.hex() + "\n")
    file.chmod(mode)
    return file
