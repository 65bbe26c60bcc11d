"""Names in configs/ -> files.

``--vehicle x500`` means ``configs/vehicles/x500.yaml``; anything with a suffix or a slash is a path.
"""

from __future__ import annotations

from pathlib import Path

from companion.config.syntax.faults import ConfigError, Fault

_PACKAGE = Path(__file__).resolve().parents[2]
SHIPPED = next(place for place in (_PACKAGE / "configs", _PACKAGE.parent / "configs") if place.is_dir())
"""The shipped files: inside an installed package, or beside it in a checkout."""


def find(name: str, kind: str) -> Path:
    """The file for ``name`` of ``kind`` (vehicles, worlds, missions). ConfigError: there is none."""
    path = Path(name)
    if path.suffix or len(path.parts) != 1:
        if not path.is_file():
            raise ConfigError([Fault(name, 0, "", f"no such file; expected a {kind[:-1]} file (YAML)")])
        return path
    shipped = SHIPPED / kind / f"{name}.yaml"
    if not shipped.is_file():
        known = ", ".join(names(kind))
        raise ConfigError([Fault(name, 0, "", f"no {kind[:-1]} of this name; expected a path, or one of {known}")])
    return shipped


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
