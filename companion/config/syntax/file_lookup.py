"""Names in configs/ -> files.

``--vehicle x500`` means ``configs/vehicles/x500.yaml``; anything with a suffix or a slash is a path.
"""

from __future__ import annotations

import difflib
from pathlib import Path

from companion.config.syntax.faults import ConfigError, Fault

_PACKAGE = Path(__file__).resolve().parents[2]
SHIPPED = next(place for place in (_PACKAGE / "configs", _PACKAGE.parent / "configs") if place.is_dir())
"""The shipped files: inside an installed package, or beside it in a checkout."""

SUFFIXES = (".yaml", ".yml", ".plan", ".waypoints")
NEAR_MAX = 3
"""Names that are offered in the place of one that is not there (engineering choice)."""


def find(name: str, kind: str) -> Path:
    """The file for ``name`` of ``kind`` (vehicles, worlds, missions). ConfigError: there is none."""
    path = Path(name)
    if path.suffix or len(path.parts) != 1:
        if not path.is_file():
            raise ConfigError([Fault(name, 0, "", f"no such file; {_meant(_beside(path))}expected a {kind[:-1]} file")])
        return path
    shipped = SHIPPED / kind / f"{name}.yaml"
    if not shipped.is_file():
        raise ConfigError([Fault(name, 0, "", f"no {kind[:-1]} of this name; {_hint(name, kind)}")])
    return shipped


def _hint(name: str, kind: str) -> str:
    """What may have been meant: a file beside, a name that is nearly this one, or any of the names."""
    beside = [f"{name}{suffix}" for suffix in SUFFIXES if Path(f"{name}{suffix}").is_file()]
    near = difflib.get_close_matches(name.lower().replace("-", "_"), names(kind), NEAR_MAX)
    return f"{_meant([*beside, *near])}expected a path, or one of {', '.join(names(kind))}"


def _beside(path: Path) -> list[str]:
    """The files that are nearly called so, where it should be."""
    try:
        there = {entry.name: entry for entry in path.parent.iterdir() if entry.is_file()}
    except OSError:
        return []
    return [str(there[name]) for name in difflib.get_close_matches(path.name, there, NEAR_MAX)]


def _meant(near: list[str]) -> str:
    return f"did you mean {' or '.join(near)}? " if near else ""


def names(kind: str) -> list[str]:
    """The shipped files of ``kind``, by name."""
    return sorted(path.stem for path in (SHIPPED / kind).glob("*.yaml"))


def read(path: Path) -> str:
    """The text of a file. ConfigError: it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError([Fault(str(path), 1, "", f"cannot be read: {error.strerror}")]) from None
    except UnicodeDecodeError as error:
        raise ConfigError([Fault(str(path), 1, "", f"not text in UTF-8: byte {error.start}")]) from None
