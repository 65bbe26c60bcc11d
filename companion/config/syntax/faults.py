"""What is wrong with a file, said so that a tired person can mend it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.plain_text import printable
from companion.vehicle import CompanionError

Key = tuple[str | int, ...]
"""Where a value stands in a document: ``("rotors", 1, "spin")``."""


def dotted(key: Key) -> str:
    """``rotors[1].spin``"""
    text = ""
    for part in key:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


@dataclass(frozen=True, slots=True, order=True)
class Fault:
    """One thing that is wrong.

    ``key`` is empty where the fault is the file's as a whole; ``line`` is 0 where ``file`` is an option, not a file.
    """

    file: str
    line: int
    key: str
    message: str

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}" if self.line else self.file
        return printable(f"{where}: " + (f"{self.key}: " if self.key else "") + self.message)


class ConfigError(CompanionError):
    """A file that cannot be used: all its faults at once (exit code 2)."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        self.faults = tuple(sorted(set(faults)))
        super().__init__("\n".join(map(str, self.faults)))
