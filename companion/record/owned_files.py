"""Small files of ours in places that others can write to, as /tmp: state of a vehicle, status of a flight, time stamps.

A directory counts only where it is really one, belongs to us and cannot be written to by everybody; a file only where
it is a plain file of the right owner. Symbolic links are not followed. So nobody else can have us read, overwrite or
create a file that he chose.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path

SIZE_MAX = 1 << 16
"""bytes of such a file, at most; ours have some hundreds."""
PRIVATE = 0o600
"""Permissions: nobody else."""
READABLE = 0o644
"""Permissions: others read."""
_DIRECTORY = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_FILE = os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK  # a pipe in the file's place must not block


def write_owned(path: Path, text: str, mode: int = PRIVATE) -> bool:
    """Write a file that others read: never seen half written. Whether that was possible, and safe."""
    part = f".{path.name}.{os.getpid()}.part"
    try:
        path.parent.mkdir(0o755 if mode & 0o004 else 0o700, parents=True, exist_ok=True)
        with _own_directory(path.parent) as directory:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(part, dir_fd=directory)
            file = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, mode, dir_fd=directory)
            with os.fdopen(file, "w", encoding="utf-8") as out:
                out.write(text)
            os.rename(part, path.name, src_dir_fd=directory, dst_dir_fd=directory)
    except OSError:
        return False
    return True


def read_owned(path: Path, owner: int | None = None) -> str | None:
    """The text of a file of ``owner`` (a user's number; ours where not given); None: there is none, or not such."""
    try:
        file = os.open(path, _FILE)
    except (OSError, ValueError):
        return None
    try:
        about = os.fstat(file)
        wanted = os.geteuid() if owner is None else owner
        if not stat.S_ISREG(about.st_mode) or about.st_uid != wanted or about.st_size > SIZE_MAX:
            return None
        return os.read(file, SIZE_MAX).decode("utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    finally:
        os.close(file)


def owner_of(directory: Path) -> int | None:
    """The user's number a directory belongs to; None where it is none, or a link, or everybody can write to it."""
    try:
        about = directory.lstat()
    except OSError:
        return None
    return about.st_uid if stat.S_ISDIR(about.st_mode) and not about.st_mode & 0o002 else None


@contextlib.contextmanager
def _own_directory(path: Path) -> Iterator[int]:
    """A directory of ours, open. OSError: it is not ours alone."""
    directory = os.open(path, _DIRECTORY)
    try:
        about = os.fstat(directory)
        if about.st_uid != os.geteuid() or about.st_mode & 0o002:
            raise PermissionError(f"{path} belongs to somebody else, or everybody can write to it")
        yield directory
    finally:
        os.close(directory)
